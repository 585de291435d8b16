"""The Planckian locus in CIE 1960 u, v: chromaticities of black bodies, and which of them is nearest to a colour."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import PLANCK_C2
from hradiosity.model import photometry

COLDEST, HOTTEST = 1000.0, 100_000.0
"""Ends of the locus here [K]."""
_NODES: Final = 397
"""Knots of the locus, one in 2.5 reciprocal megakelvins: cubics between them are good to 1e-9 in u and v."""
_COARSE: Final = 4
"""Every so many knots are looked at to begin with."""
_STEPS: Final = 6
"""Newton steps; three suffice wherever the colour has a temperature at all."""


@dataclass(frozen=True)
class Locus:
    """Cubic Hermite curve through chromaticities of black bodies.

    mired : (m,) float64 [MK⁻¹], ascending in equal steps
    uv : (m, 2) float64
    slope : (m, 2) float64, derivative of uv by mired
    """

    mired: NDArray[np.float64]
    uv: NDArray[np.float64]
    slope: NDArray[np.float64]


def relative_radiance(wavelength: NDArray[np.float64], temperature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Planck's law without its first constant.

    Parameters
    ----------
    wavelength : (m,) float64 [nm]
    temperature : (n,) float64 [K]

    Returns
    -------
    (n, m) float64
        Relative spectral radiance per nm.
    """
    metres = wavelength * 1e-9
    exponent = PLANCK_C2 / (metres * temperature[:, None])
    power: NDArray[np.float64] = (wavelength / 560.0) ** -5 / np.expm1(exponent)
    return power


@cache
def locus() -> Locus:
    """From 1000 K to 100 000 K, by the 1931 observer in 1 nm, as Ohno 2014 (Leukos 10, 47) tabulates it."""
    mired = np.linspace(1e6 / HOTTEST, 1e6 / COLDEST, _NODES)
    wavelength, functions = photometry.observer("1931")
    power = relative_radiance(wavelength, 1e6 / mired)
    exponent = PLANCK_C2 * 1e3 * mired[:, None] / wavelength
    change = power * exponent / mired[:, None] / np.expm1(-exponent)  # derivative by mired
    # u = 4 X / (X + 15 Y + 3 Z), v = 6 Y / (X + 15 Y + 3 Z)
    parts = np.stack([4.0 * functions[:, 0], 6.0 * functions[:, 1], functions @ [1.0, 15.0, 3.0]], axis=1)
    sums, rates = (np.einsum("mw,wc->mc", part, parts) for part in (power, change))
    uv, bottom = sums[:, :2] / sums[:, 2:], sums[:, 2:]
    return Locus(mired, uv, (rates[:, :2] - uv * rates[:, 2:]) / bottom)


def nearest_on_locus(uv: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The black body whose colour is nearest, and how far it is.

    Parameters
    ----------
    uv : (n, 2) float64, CIE 1960, finite

    Returns
    -------
    temperature : (n,) float64 [K]
        `COLDEST` or `HOTTEST` where the nearest lies at or beyond an end.
    distance : (n,) float64
        Positive above the locus (greener), negative below.
    """
    curve = locus()
    coarse = curve.uv[::_COARSE]
    square = (uv[:, None, 0] - coarse[:, 0]) ** 2 + (uv[:, None, 1] - coarse[:, 1]) ** 2
    step = curve.mired[1] - curve.mired[0]
    low, high = curve.mired[0], curve.mired[-1]
    guess = curve.mired[::_COARSE][square.argmin(axis=1)]
    least, most = np.maximum(guess - _COARSE * step, low), np.minimum(guess + _COARSE * step, high)
    mired = guess
    for _ in range(_STEPS):
        point, first, second = _along(curve, mired)
        away = point - uv
        gradient = (away * first).sum(axis=1)
        curvature = (first**2).sum(axis=1) + (away * second).sum(axis=1)
        downhill = np.where(curvature > 0.0, gradient / np.where(curvature > 0.0, curvature, 1.0), np.sign(gradient))
        mired = np.clip(mired - downhill, least, most)
    point, first, _ = _along(curve, mired)
    away = uv - point
    above = np.sign(away[:, 1] * first[:, 0] - away[:, 0] * first[:, 1])
    return 1e6 / mired, above * np.hypot(away[:, 0], away[:, 1])


def _along(
    curve: Locus, mired: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(n, 2) points of the curve, and first and second derivatives by mired."""
    step = curve.mired[1] - curve.mired[0]
    knot = np.clip(((mired - curve.mired[0]) / step).astype(np.int64), 0, len(curve.mired) - 2)
    t = ((mired - curve.mired[knot]) / step)[:, None]
    start, end = curve.uv[knot], curve.uv[knot + 1]
    leaving, arriving = step * curve.slope[knot], step * curve.slope[knot + 1]
    square = 3.0 * (end - start) - 2.0 * leaving - arriving
    cube = 2.0 * (start - end) + leaving + arriving
    point = start + t * (leaving + t * (square + t * cube))
    first = leaving + t * (2.0 * square + 3.0 * t * cube)
    second = 2.0 * square + 6.0 * t * cube
    return point, first / step, second / step**2
