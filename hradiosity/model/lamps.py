"""The light of all lamps, together and as tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Scene


def lamp_flux(scene: Scene) -> NDArray[np.float64]:
    """(n_bands,) flux of all lamps [W per band]; the sky's radiance [W m⁻² sr⁻¹ per band] where no lamp shines."""
    lamps, area = scene.emitters, scene.patches.area
    sent = np.zeros(len(scene.bands))
    for patch, luminaire in zip(lamps.patch, lamps.luminaire, strict=True):
        lamp = scene.luminaires[luminaire]
        sides = 2.0 if lamp.two_sided else 1.0
        sent += sides * area[patch] * lamp.exitance if patch >= 0 else 4.0 * np.pi * lamp.intensity
    if not sent.any() and scene.sky is not None:
        sent = scene.sky.radiance
    return sent


def lamp_emissions(scene: Scene) -> NDArray[np.float64]:
    """(n_luminaires, n_bands) exitance [W m⁻² per band], or intensity of point sources [W sr⁻¹ per band]."""
    return np.array([lamp.emission for lamp in scene.luminaires], np.float64).reshape(-1, len(scene.bands))


def lamp_exitances(scene: Scene) -> NDArray[np.float64]:
    """(n_luminaires, n_bands) exitance [W m⁻² per band]; 0 for point sources."""
    area = np.array([bool(len(lamp.exitance)) for lamp in scene.luminaires], bool)
    return np.where(area[:, None], lamp_emissions(scene), 0.0)


def shining_sides(scene: Scene, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Emitter and 2 · patch + side of each side that a chosen area emitter (n_emitters,) shines from."""
    lamps = scene.emitters
    flat = np.flatnonzero(chosen & (lamps.patch >= 0))
    front = 2 * lamps.patch[flat].astype(np.int64)
    both = np.array([lamp.two_sided for lamp in scene.luminaires], bool)[lamps.luminaire[flat]]
    return np.concatenate([flat, flat[both]]), np.concatenate([front, front[both] + 1])


def side_luminaires(scene: Scene) -> NDArray[np.int32]:
    """(2 n_patches,) luminaire that each side shines as, NONE where it does not."""
    emitter, side = shining_sides(scene, np.ones(len(scene.emitters), bool))
    of_side = np.full(2 * len(scene.patches), NONE, np.int32)
    of_side[side] = scene.emitters.luminaire[emitter]
    return of_side
