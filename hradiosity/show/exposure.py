"""From samples to pixels: filter, exposure, display colours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import encode_srgb, out_of_gamut, overexposed, xyz_to_linear_srgb
from hradiosity.show.camera import PicturePoints

BRIGHT_SHARE = 0.01
"""Share of the pixels of surfaces that do not shine which automatic exposure lets be brighter than white."""


@dataclass(frozen=True)
class Developed:
    """A picture for a display.

    pixels : (height, width, 3) uint8, sRGB
    out_of_gamut, overexposed : shares of the pixels that the display cannot show
    """

    pixels: NDArray[np.uint8]
    out_of_gamut: float
    overexposed: float


def pixel_means(points: PicturePoints, values: NDArray[np.floating], n_pixels: int) -> NDArray[np.float64]:
    """(n_pixels, c) mean of the values (n, c) of the points in each pixel: a box filter."""
    means = [np.bincount(points.pixel, points.weight * channel, n_pixels) for channel in values.T]
    return np.stack(means, axis=1)


def white_luminance(xyz: list[NDArray[np.float32]]) -> float:
    """Luminance that a set of pictures shows as white [cd m⁻²].

    Parameters
    ----------
    xyz : list of (n, 3) float32
        Of each picture, where surfaces are seen that do not shine themselves; Y is the luminance [cd m⁻²].

    Returns
    -------
    float
        So that one in a hundred of all these has a channel that the display cannot show; 1 where there is no light.
    """
    brightest = [xyz_to_linear_srgb(samples.astype(np.float64), 1.0).max(axis=1) for samples in xyz]
    seen = np.concatenate([np.zeros(0), *brightest])
    white = float(np.quantile(seen, 1.0 - BRIGHT_SHARE)) if len(seen) else 0.0
    return white if white > 0.0 else 1.0


def develop(points: PicturePoints, xyz: NDArray[np.float32], height: int, width: int, white: float) -> Developed:
    """Display colours.

    Parameters
    ----------
    points : PicturePoints
    xyz : (n, 3) float32
        X, Y, Z of the points with Y the luminance [cd m⁻²].
    height, width : int
    white : float
        Luminance shown as white [cd m⁻²].

    Notes
    -----
    Points are clipped before they are averaged: the edge of a lamp a thousand times brighter than white would else
    be a staircase. The shares refer to the averages before clipping.
    """
    linear = xyz_to_linear_srgb(xyz.astype(np.float64), white)
    mean = pixel_means(points, linear, height * width)
    shown = pixel_means(points, np.clip(linear, 0.0, 1.0), height * width)
    return Developed(
        pixels=to_bytes(encode_srgb(shown)).reshape(height, width, 3),
        out_of_gamut=float(out_of_gamut(mean).mean()),
        overexposed=float(overexposed(mean).mean()),
    )


def to_bytes(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Values 0 … 1 as 0 … 255, rounded."""
    return np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
