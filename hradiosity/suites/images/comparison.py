"""How far two images are apart, as eyes see it, and how much of that is noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.image_files import display_difference

BLOCK: Final = 8
"""Pixels along the edge of the blocks over which noise is averaged away."""


@dataclass(frozen=True)
class ImageComparison:
    """Differences between an image and its reference.

    delta_e_mean, delta_e_95 : CIEDE2000 over the pixels, mean and 95th percentile
    noise_delta_e_mean : what the noise of both would make of two equal images, by the differences between their halves
    block_delta_e_mean, block_delta_e_95, block_noise_mean : the same over means of blocks of 8 × 8 pixels
    luminance_bias : mean luminance over that of the reference, less 1
    luminance_bias_error : standard error of it, from halves of both
    """

    delta_e_mean: float
    delta_e_95: float
    noise_delta_e_mean: float
    block_delta_e_mean: float
    block_delta_e_95: float
    block_noise_mean: float
    luminance_bias: float
    luminance_bias_error: float


def difference_map(
    first: NDArray[np.float64], second: NDArray[np.float64], white_luminance: float
) -> NDArray[np.float64]:
    """(height, width) CIEDE2000 between X, Y, Z (height, width, 3), on a display with that white [cd m⁻²].

    Light brighter than white counts as white: a lamp's own luminance is nobody's question.
    """
    shown = [np.maximum(light, 0.0) / white_luminance for light in (first, second)]
    scale = [1.0 / np.maximum(light[..., 1:2], 1.0) for light in shown]
    return display_difference(shown[0] * scale[0], shown[1] * scale[1])


def compare_images(
    image: NDArray[np.float64], reference: NDArray[np.float64], white_luminance: float
) -> ImageComparison:
    """Compare an image and a reference that both come in two independent halves.

    Parameters
    ----------
    image, reference : (2, height, width, 3) float64
        X, Y, Z.
    white_luminance : float
        Y of the display's white.
    """
    fine = _differences(image, reference, white_luminance)
    coarse = _differences(blocks(image), blocks(reference), white_luminance)
    means = np.stack([image[..., 1].mean(axis=(1, 2)), reference[..., 1].mean(axis=(1, 2))])
    ratio = means[0].mean() / means[1].mean()
    spread = 0.5 * np.abs(means[:, 0] - means[:, 1]) / means.mean(axis=1)
    return ImageComparison(
        delta_e_mean=float(fine[0].mean()),
        delta_e_95=float(np.quantile(fine[0], 0.95)),
        noise_delta_e_mean=fine[1],
        block_delta_e_mean=float(coarse[0].mean()),
        block_delta_e_95=float(np.quantile(coarse[0], 0.95)),
        block_noise_mean=coarse[1],
        luminance_bias=float(ratio - 1.0),
        luminance_bias_error=float(np.hypot(*spread)),
    )


def blocks(halves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means over blocks of (n, height, width, 3); without what does not fill one."""
    n, height, width, channels = halves.shape
    rows, columns = max(height // BLOCK, 1), max(width // BLOCK, 1)
    size = min(BLOCK, height), min(BLOCK, width)
    cut = halves[:, : rows * size[0], : columns * size[1]]
    means: NDArray[np.float64] = cut.reshape(n, rows, size[0], columns, size[1], channels).mean(axis=(2, 4))
    return means


def _differences(
    image: NDArray[np.float64], reference: NDArray[np.float64], white: float
) -> tuple[NDArray[np.float64], float]:
    """Differences between the means, and what noise alone would make of their mean.

    Halves differ by twice the error of their mean; errors of image and reference add in quadrature.
    """
    found = difference_map(image.mean(axis=0), reference.mean(axis=0), white)
    halves = [difference_map(pair[0], pair[1], white) for pair in (image, reference)]
    return found, float(np.hypot(0.5 * halves[0], 0.5 * halves[1]).mean())
