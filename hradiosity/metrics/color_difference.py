"""How different two colours look: CIE 1976 L*a*b* and the colour difference CIEDE2000 (ISO/CIE 11664-4 and -6)."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

_LINEAR_BELOW: Final = (6.0 / 29.0) ** 3
_POLE: Final = 25.0**7


def lab(tristimulus: NDArray[np.float64], white: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIE 1976 L*, a*, b*.

    Parameters
    ----------
    tristimulus : (…, 3) float64
        X, Y, Z; none below 0.
    white : (3,) float64
        X, Y, Z of white, in the same unit.

    Returns
    -------
    (…, 3) float64
    """
    ratio = tristimulus / white
    f = np.where(ratio > _LINEAR_BELOW, np.cbrt(ratio), (ratio / (3.0 * (6.0 / 29.0) ** 2)) + 4.0 / 29.0)
    fx, fy, fz = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)], axis=-1)


def delta_e_2000(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colour difference CIEDE2000 with all parametric factors 1, ISO/CIE 11664-6:2014.

    Parameters
    ----------
    first, second : (…, 3) float64
        L*, a*, b*.

    Returns
    -------
    (…) float64
    """
    chroma = 0.5 * (np.hypot(first[..., 1], first[..., 2]) + np.hypot(second[..., 1], second[..., 2]))
    stretch = 1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + _POLE))
    (l1, c1, h1), (l2, c2, h2) = (_polar(colour, stretch) for colour in (first, second))
    grey = c1 * c2 == 0.0
    apart = h2 - h1
    far = np.abs(apart) > 180.0
    turn = np.where(grey, 0.0, apart - np.where(far, np.sign(apart) * 360.0, 0.0))
    hue_difference = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(0.5 * turn))
    middle = 0.5 * (h1 + h2) + np.where(far, np.where(h1 + h2 < 360.0, 180.0, -180.0), 0.0)
    hue = np.where(grey, h1 + h2, middle)
    lightness, saturation = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    weight = (
        1.0
        - 0.17 * np.cos(np.radians(hue - 30.0))
        + 0.24 * np.cos(np.radians(2.0 * hue))
        + 0.32 * np.cos(np.radians(3.0 * hue + 6.0))
        - 0.20 * np.cos(np.radians(4.0 * hue - 63.0))
    )
    from_middle = (lightness - 50.0) ** 2
    of_lightness = (l2 - l1) / (1.0 + 0.015 * from_middle / np.sqrt(20.0 + from_middle))
    of_chroma = (c2 - c1) / (1.0 + 0.045 * saturation)
    of_hue = hue_difference / (1.0 + 0.015 * saturation * weight)
    blue = 60.0 * np.exp(-(((hue - 275.0) / 25.0) ** 2))
    rotation = -2.0 * np.sqrt(saturation**7 / (saturation**7 + _POLE)) * np.sin(np.radians(blue))
    squared = of_lightness**2 + of_chroma**2 + of_hue**2 + rotation * of_chroma * of_hue
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


def _polar(
    colour: NDArray[np.float64], stretch: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Lightness, chroma and hue [°, 0 … 360] with a* stretched, as the formula wants them near grey."""
    a = stretch * colour[..., 1]
    hue = np.remainder(np.degrees(np.arctan2(colour[..., 2], a)), 360.0)
    return colour[..., 0], np.hypot(a, colour[..., 2]), hue
