"""The same scene in a few bands of about equal lumens, for numbers that need no spectra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Luminaire, Material, Scene, Sky
from hradiosity.model.spectrum import Bands
from hradiosity.model.variants import stacked_emission, stacked_sky

PHOTOPIC_BANDS = 9
"""Reflectances differ so little inside that illuminances change by less than a percent, and rates of change too."""


def in_photopic_bands(scene: Scene, count: int = PHOTOPIC_BANDS) -> Scene:
    """The scene without variants in `count` bands or fewer, each of which holds about as many lumens of all lamps.

    Light keeps its lumens in each of them; reflectances are means weighted by the lumens of all luminaires and the sky.

    Parameters
    ----------
    scene : Scene
    count : int
    """
    plain = replace(scene, variants=())
    luminous = luminous_weights(scene.bands)
    light = luminous * (stacked_emission(plain).sum(axis=0) + stacked_sky(plain))
    if not light.any():
        light = luminous + np.finfo(float).tiny
    before = np.cumsum(light) - 0.5 * light
    groups = np.unique(np.minimum(count * before / light.sum(), count - 1).astype(np.int64), return_inverse=True)[1]
    member = np.equal.outer(np.arange(groups.max() + 1), groups)
    bands = Bands(
        np.array([scene.bands.lower[inside][0] for inside in member]),
        np.array([scene.bands.upper[inside][-1] for inside in member]),
    )
    share = member * light + np.finfo(float).tiny * member
    share /= share.sum(axis=1, keepdims=True)
    lumens = luminous_weights(bands)

    def powers(spectrum: NDArray[np.float64]) -> NDArray[np.float64]:
        """Power in each new band that has the lumens which the old bands had."""
        inside = np.einsum("gb,b->g", member, luminous * spectrum)
        return np.asarray(np.divide(inside, lumens, out=np.zeros_like(inside), where=lumens > 0.0))

    return replace(
        plain,
        bands=bands,
        materials=tuple(_averaged(material, share) for material in scene.materials),
        luminaires=tuple(
            Luminaire(
                lamp.name,
                powers(lamp.exitance) if len(lamp.exitance) else lamp.exitance,
                powers(lamp.intensity) if len(lamp.intensity) else lamp.intensity,
                lamp.two_sided,
            )
            for lamp in scene.luminaires
        ),
        sky=None if scene.sky is None else Sky(powers(scene.sky.radiance)),
    )


def _averaged(material: Material, share: NDArray[np.float64]) -> Material:
    """The material in new bands; a mean of reflectances does not round past 1."""
    return replace(material, reflectance=np.minimum(np.einsum("gb,b->g", share, material.reflectance), 1.0))
