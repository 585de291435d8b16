"""The form factor of two unit squares with a common edge, by other means than the program's."""

import numpy as np


def hinge_factor(degrees):
    """Contour integral over both squares; what remains to be integrated has its singularities at the ends only.

    Of the sixteen pairs of edges the four parallel to the hinge and those that leave the same end of it or opposite
    ends count. Absolute error below 2e-16.
    """
    angle = np.radians(degrees)
    parallel = -_parallel(0.0) + 2.0 * _parallel(1.0) - _parallel(2.0 * np.sin(0.5 * angle))
    return (parallel + 2.0 * np.cos(angle) * (_slanted(angle, 1.0) - _slanted(angle, 0.0))) / (2.0 * np.pi)


def _parallel(distance):
    """∬ ln r of two parallel edges of length 1, abreast: ∫ (1 − u) ln(u² + d²) du."""
    u, weight = _ends_resolved()
    return float(weight @ ((1.0 - u) * np.log(u * u + distance * distance)))


def _slanted(angle, height):
    """∬ ln r of two edges of length 1 from one axis, `height` apart along it; the inner integral in closed form."""
    s, weight = _ends_resolved()
    across = np.hypot(s * np.sin(angle), height)
    return float(weight @ (_inner(1.0 - s * np.cos(angle), across) - _inner(-s * np.cos(angle), across)))


def _inner(along, across):
    """Antiderivative of ln √(w² + g²) in w."""
    return 0.5 * along * np.log(along**2 + across**2) - along + across * np.arctan2(along, across)


def _ends_resolved():
    """Double-exponential points on [0, 1] and their weights (Takahasi & Mori 1974)."""
    t = np.arange(-3.5, 3.5 + 1e-9, 1.0 / 32.0)
    x = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(t)))
    return x, np.pi * np.cosh(t) * x * (1.0 - x) / 32.0
