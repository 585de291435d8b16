"""The readings of a scene by Radiance's ``rtrace``, with as many spectral samples as it takes (extra ``bench``)."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene
from hradiosity.model.spectrum import Bands

COARSE: Final = ("-ab", "4", "-ad", "256", "-as", "64", "-aa", "0.3", "-ar", "32", "-ds", "0.1", "-dt", "0")
"""About as long as this program takes at normal quality."""
FINE: Final = ("-ab", "6", "-ad", "1024", "-as", "256", "-aa", "0.15", "-ar", "64", "-ds", "0.05", "-dt", "0")
"""Twenty to thirty times as long."""


def scene_text(scene: Scene) -> str:
    """Materials, lamps and patches in Radiance's own format.

    Raises
    ------
    ValueError
        When the scene has what is not written here: points that shine, or a sky.
    """
    if (scene.emitters.patch < 0).any() or scene.sky is not None:
        raise ValueError(f"{scene.name}: only area emitters are written for Radiance")
    lamp_of = dict(zip(scene.emitters.patch.tolist(), scene.emitters.luminaire.tolist()))
    parts = []
    for i, material in enumerate(scene.materials):
        parts += [_spectrum(f"paint{i}", scene.bands, material.reflectance)]
        parts += [f"paint{i} plastic material{i}\n0\n0\n5 1 1 1 0 0"]
    for i, lamp in enumerate(scene.luminaires):
        parts += [_spectrum(f"light{i}", scene.bands, lamp.exitance / scene.bands.width / np.pi)]
        parts += [f"light{i} light lamp{i}\n0\n0\n3 1 1 1"]
    for i, corners in enumerate(scene.patches.corners()):
        ring = corners[[0, 1, 3]] if scene.patches.is_triangle[i] else corners
        modifier = f"lamp{lamp_of[i]}" if i in lamp_of else f"material{scene.patches.material[i]}"
        parts += [f"{modifier} polygon patch{i}\n0\n0\n{ring.size} {_numbers(ring)}"]
    return "\n".join(parts) + "\n"


def irradiance(scene: Scene, bands: Bands, settings: tuple[str, ...]) -> tuple[NDArray[np.float64], float]:
    """(n_readings, n_bands) float64 in bands of equal width [W m⁻² per band], and CPU seconds of ``rtrace``."""
    import pyradiance

    rays = np.concatenate([np.hstack([s.position, s.normal]) for s in scene.sensors])
    span = ("-cs", str(len(bands)), "-cw", f"{bands.lower[0]:g}", f"{bands.upper[-1]:g}", "-co+")
    with tempfile.TemporaryDirectory() as folder:
        text, octree = Path(folder) / "scene.rad", Path(folder) / "scene.oct"
        text.write_text(scene_text(scene), encoding="utf-8")
        octree.write_bytes(pyradiance.oconv(str(text)))
        before = os.times()
        answer = pyradiance.rtrace(
            "".join(_numbers(ray) + "\n" for ray in rays).encode(),
            octree,
            header=False,
            irradiance=True,
            params=[*span, *settings],
        )
        after = os.times()
    seconds = after.children_user - before.children_user + after.children_system - before.children_system
    # Its spectra run from long to short waves, and hold the mean density of each band over the whole span.
    found = np.array(answer.split(), np.float64).reshape(len(rays), len(bands))[:, ::-1]
    return found * bands.width, seconds


def _spectrum(name: str, bands: Bands, values: NDArray[np.float64]) -> str:
    span = f"{bands.centre[0]:g} {bands.centre[-1]:g}"
    return f"void spectrum {name}\n0\n0\n{len(values) + 2} {span} {_numbers(values)}"


def _numbers(values: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.9g}" for value in values.ravel())
