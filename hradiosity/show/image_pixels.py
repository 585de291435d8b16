"""The pixels of an image: final gather in passes that are independent of one another."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import View
from hradiosity.radiosity.point_reader import FIRST_NEAR_FACTOR, NEAR_FACTOR
from hradiosity.show.camera import view_axes
from hradiosity.show.image_guide import LEVELS
from hradiosity.show.image_lamps import CLEAR_LAMPS
from hradiosity.show.image_light import ImageLight

BATCH_PIXELS: Final = 1 << 16
"""Pixels traced at a time."""
SUMS: Final = 9
"""X, Y, Z dull; illuminance; X, Y, Z shining; samples that shine, and on surfaces: as in ``cl/kernels/image.cl``."""


def trace_pass(
    light: ImageLight, view: View, samples: int, seed: int, spectrum: NDArray[np.float32] | None = None
) -> NDArray[np.float64]:
    """One independent estimate of all pixels.

    Parameters
    ----------
    light : ImageLight
    view : View
    samples : int
        In each pixel, spread evenly over it; a power of two spreads them best.
    seed : int
    spectrum : (n_pixels, n_bands) float32, optional
        Gets the radiance [W m⁻² sr⁻¹ per band] of the pixels added.

    Returns
    -------
    (n_pixels, 9) float64
        Means over the samples: X, Y, Z of what does not shine [Y in cd m⁻²]; illuminance of surfaces [lx]; X, Y, Z of
        what shines or lies beyond the scene; shares of the samples on that, and on surfaces.
    """
    n_pixels = view.width * view.height
    sums = np.empty((n_pixels, SUMS))
    for first in range(0, n_pixels, BATCH_PIXELS):
        part = slice(first, min(first + BATCH_PIXELS, n_pixels))
        sums[part], exitance = _trace_batch(light, view, part, samples, seed, spectrum is not None)
        if spectrum is not None:
            spectrum[part] += exitance[:, : light.n_bands] / np.float32(np.pi * samples)
    return sums / samples


def _trace_batch(
    light: ImageLight, view: View, part: slice, samples: int, seed: int, spectra: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Sums (n, 9) and exitance spectra (n, 8 n_groups) of some pixels; no spectra unless asked for."""
    scene, device = light.scene, light.scene.device
    n = part.stop - part.start
    sums = device.empty((n, SUMS), np.float32)
    exitance = device.empty((n if spectra else 0, 8 * light.n_groups), np.float32)
    camera = np.vstack([scene.bvh.to_local(view.position)[None], view_axes(view)])
    device.kernel(
        "image",
        "image_samples",
        HR_GROUPS=light.n_groups,
        HR_SPECTRA=int(spectra),
        HR_GUIDE_LEVELS=LEVELS,
        HR_CLEAR_LAMPS=CLEAR_LAMPS,
    )(
        n,
        **scene.geometry,
        **scene.emitters,
        **light.arguments,
        camera=device.upload(camera, np.float32),
        pixel_sums=sums,
        spectra=exitance,
        width=view.width,
        height=view.height,
        levels=max(1, (max(view.width, view.height) - 1).bit_length()),
        first_pixel=part.start,
        n_samples=samples,
        near_factor=NEAR_FACTOR,
        first_near_factor=FIRST_NEAR_FACTOR,
        seed=seed,
        scale=scene.scale,
    )
    return device.fetch(sums), device.fetch(exitance)
