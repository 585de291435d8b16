"""The light of all lamps together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene


def lamp_flux(scene: Scene) -> NDArray[np.float64]:
    """(n_bands,) flux of all lamps [W per band]; the sky's radiance [W m⁻² sr⁻¹ per band] where no lamp shines."""
    lamps = scene.emitters
    sent = np.zeros(len(scene.bands))
    for patch, luminaire in zip(lamps.patch, lamps.luminaire, strict=True):
        lamp = scene.luminaires[luminaire]
        sides = 2.0 if lamp.two_sided else 1.0
        sent += sides * scene.patches.area[patch] * lamp.exitance if patch >= 0 else 4.0 * np.pi * lamp.intensity
    if not sent.any() and scene.sky is not None:
        sent = scene.sky.radiance
    return sent
