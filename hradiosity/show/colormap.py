"""A colour scale for numbers: even steps for the eye, readable without telling red from green."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import SRGB_WHITE, encode_srgb, xyz_to_linear_srgb

SIZE: Final = 256
_KNOTS: Final = np.array(
    [[14.0, 16.0, -32.0], [30.0, 6.0, -36.0], [48.0, -13.0, -18.0], [64.0, -28.0, 12.0], [80.0, -20.0, 50.0],
     [91.0, -6.0, 58.0]]
)  # fmt: skip
"""CIE L*, a*, b* from dark blue over teal and green to light yellow: lightness rises all the way."""


@cache
def scale_colours() -> NDArray[np.float64]:
    """(256, 3) sRGB values 0 … 1, from the lowest number to the highest.

    A cubic through a few colours in CIE L*a*b*, walked in equal steps of the colour difference ΔE*ab (CIE 15:2018).
    """
    fine = np.linspace(0.0, 1.0, 4 * SIZE)
    curve = cubic(_KNOTS, fine)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    even = np.interp(np.linspace(0.0, length[-1], SIZE), length, fine)
    return encode_srgb(xyz_to_linear_srgb(lab_to_xyz(cubic(_KNOTS, even)), 1.0))


def cubic(knots: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cubic spline through evenly spaced knots, at places 0 … 1 of the way.

    Its third derivative is continuous at the second and the last but one knot ("not a knot", de Boor 1978, chapter 4).
    Written out here, since SciPy's takes half a second to import, in which a window is to open.

    Parameters
    ----------
    knots : (n, c) float64, n at least 4
    at : (m,) float64

    Returns
    -------
    (m, c) float64
    """
    n = len(knots)
    system, right = np.zeros((n, n)), np.zeros_like(knots)
    inner = np.arange(1, n - 1)
    system[inner, inner - 1], system[inner, inner], system[inner, inner + 1] = 1.0, 4.0, 1.0
    right[1:-1] = 6.0 * (knots[:-2] - 2.0 * knots[1:-1] + knots[2:])
    system[0, :3] = system[-1, -3:] = [1.0, -2.0, 1.0]
    second = np.linalg.solve(system, right)
    place = np.clip(at, 0.0, 1.0) * (n - 1)
    left = np.minimum(place.astype(np.int64), n - 2)
    b = (place - left)[:, None]
    a = 1.0 - b
    line = a * knots[left] + b * knots[left + 1]
    bend = (a**3 - a) * second[left] + (b**3 - b) * second[left + 1]
    spline: NDArray[np.float64] = line + bend / 6.0
    return spline


def lab_to_xyz(lab: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tristimulus values of CIE 1976 L*a*b* colours, relative to the white of sRGB with Y = 1 (CIE 15:2018).

    Parameters
    ----------
    lab : (…, 3) float64

    Returns
    -------
    (…, 3) float64
    """
    x, y = SRGB_WHITE
    white = np.array([x / y, 1.0, (1.0 - x - y) / y])
    f_y = (lab[..., 0] + 16.0) / 116.0
    f = np.stack([f_y + lab[..., 1] / 500.0, f_y, f_y - lab[..., 2] / 200.0], axis=-1)
    bend = 6.0 / 29.0
    linear = 3.0 * bend * bend * (f - 4.0 / 29.0)
    tristimulus: NDArray[np.float64] = white * np.where(f > bend, f**3, linear)
    return tristimulus


def colours_of(share: NDArray[np.floating]) -> NDArray[np.float64]:
    """(…, 3) sRGB values 0 … 1 of shares 0 … 1 of the scale; values outside get its ends."""
    index = np.rint(np.clip(np.nan_to_num(share), 0.0, 1.0) * (SIZE - 1)).astype(np.int64)
    colours: NDArray[np.float64] = scale_colours()[index]
    return colours
