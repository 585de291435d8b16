"""Spectra as pictures need them: tristimulus values of lamps, paints and reflected light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model import photometry
from hradiosity.model.scene import Scene
from hradiosity.model.spectrum import Bands, band_integral

CHANNELS = 4
"""X, Y, Z of the reflected exitance [lm m⁻²], and the illuminance [lx]."""


def emitted_xyz(scene: Scene) -> NDArray[np.float32]:
    """(n_sides, 3) X, Y, Z of the emitted exitance M₀ [lm m⁻²] of all sides."""
    weights = xyz_weights(scene.bands)
    out = np.zeros((2 * len(scene.patches), 3), np.float32)
    for patch, luminaire in zip(scene.emitters.patch, scene.emitters.luminaire, strict=True):
        if patch >= 0:
            lamp = scene.luminaires[luminaire]
            sides = (2 * patch, 2 * patch + 1) if lamp.two_sided else (2 * patch,)
            out[list(sides)] += np.einsum("b,bc->c", lamp.exitance, weights).astype(np.float32)
    return out


def paint_colours(scene: Scene) -> NDArray[np.float64]:
    """(n_materials + 1, 3) X, Y, Z of the paints, and of black, under CIE D65; Y of a perfect white is 1."""
    return colours_of_paints(np.concatenate([scene.reflectance, np.zeros((1, len(scene.bands)))]), scene.bands)


def colours_of_paints(reflectance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """(n, 3) X, Y, Z of reflectances (n, n_bands) under CIE D65; Y of a perfect white is 1."""
    light = band_integral(photometry.illuminant("D65"), bands, "hold").value
    weights = light[:, None] * xyz_weights(bands)
    return np.asarray(np.einsum("mb,bc->mc", reflectance, weights / weights[:, 1].sum()))


def reflected_channels(
    scene: Scene, material: NDArray[np.integer], irradiance: NDArray[np.float64]
) -> NDArray[np.float32]:
    """(n, 4) channels of irradiance (n, n_bands) on materials (n,), which may be ``n_materials`` for black."""
    reflectance = np.concatenate([scene.reflectance, np.zeros((1, len(scene.bands)))])
    return np.column_stack(
        [
            np.einsum("xb,bc->xc", reflectance[material] * irradiance, xyz_weights(scene.bands)),
            np.einsum("xb,b->x", irradiance, luminous_weights(scene.bands)),
        ]
    ).astype(np.float32)
