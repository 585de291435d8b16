"""The readings of a scene by Mitsuba's path tracer (extra ``bench``), in a process of its own.

``python -m hradiosity.suites.bench.peer_mitsuba SCENE RESULT.npz CPU_SECONDS TURNS`` writes `irradiance`,
(turns, n_readings, n_bands) in W m⁻² per band, and `cpu_seconds`, (turns,).
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene

_VARIANT: Final = "llvm_ad_spectral"
_WAVELENGTHS: Final = 4
"""Of each path, in that variant."""
_FACET: Final = 2e-4
"""Edge of the facets [m]."""
_HEIGHT: Final = 5e-4
"""Paths start so far in front of them [m]."""
_FIRST_PATHS: Final = 256
_LONGEST_PILOT: Final = 3


class MitsubaRoom:
    """A scene there, with a white facet at each reading.

    Its exitance is the irradiance. So lamps are sampled at the reading too, which an irradiance meter there is not.

    Raises
    ------
    ValueError
        When the scene has what is not handed over: points that shine, a sky, or bands of several widths.
    """

    def __init__(self, scene: Scene) -> None:
        import mitsuba

        if (scene.emitters.patch < 0).any() or scene.sky is not None or np.ptp(scene.bands.width) > 1e-9:
            raise ValueError(f"{scene.name}: only area emitters and even bands are handed to Mitsuba")
        mitsuba.set_variant(_VARIANT)
        self._scene = scene
        with tempfile.TemporaryDirectory() as folder:
            shapes = _shapes(scene, Path(folder)) | {"facets": _facets(scene, Path(folder))}
            self._there = mitsuba.load_dict({"type": "scene"} | shapes)
        self._integrator = mitsuba.load_dict({"type": "path", "max_depth": -1, "rr_depth": 8})

    def irradiance(self, paths: int, seed: int) -> NDArray[np.float64]:
        """(n_readings, n_bands) [W m⁻² per band] from so many paths of each reading."""
        import drjit
        import mitsuba

        bands = self._scene.bands
        low, high, n_bands = float(bands.lower[0]), float(bands.upper[-1]), len(bands)
        place, normal = (
            np.concatenate([getattr(s, key) for s in self._scene.sensors]) for key in ("position", "normal")
        )
        sampler = mitsuba.load_dict({"type": "independent"})
        sampler.seed(seed, len(place) * paths)
        reading = drjit.arange(mitsuba.UInt32, len(place) * paths) // paths

        def gathered(rows: NDArray[np.float64]) -> list[Any]:
            columns = [mitsuba.Float(np.ascontiguousarray(rows[:, axis], np.float32)) for axis in range(3)]
            return [drjit.gather(mitsuba.Float, column, reading) for column in columns]

        onto = mitsuba.Vector3f(*gathered(-normal))
        ray = mitsuba.RayDifferential3f(mitsuba.Ray3f(mitsuba.Point3f(*gathered(place)) - _HEIGHT * onto, onto))
        first, waves = sampler.next_1d(), type(ray.wavelengths)()
        for i in range(_WAVELENGTHS):
            turned = first + i / _WAVELENGTHS
            waves[i] = low + (high - low) * (turned - drjit.floor(turned))
        ray.wavelengths = waves
        radiance = self._integrator.sample(self._there, sampler, ray, None, True)[0]
        total = drjit.zeros(mitsuba.Float, len(place) * n_bands)
        for i in range(_WAVELENGTHS):
            band = drjit.minimum(mitsuba.UInt32((waves[i] - low) / (high - low) * n_bands), n_bands - 1)
            drjit.scatter_reduce(drjit.ReduceOp.Add, total, radiance[i], reading * n_bands + band)
        mean = np.array(total, np.float64).reshape(len(place), n_bands) / (paths * _WAVELENGTHS)
        return mean * np.pi * (high - low)


def _shapes(scene: Scene, folder: Path) -> dict[str, Any]:
    """A mesh for each paint and each lamp."""
    lamp = np.full(len(scene.patches), -1)
    lamp[scene.emitters.patch] = scene.emitters.luminaire
    shapes: dict[str, Any] = {}
    for material, luminaire in sorted(set(zip(scene.patches.material.tolist(), lamp.tolist()))):
        chosen = (scene.patches.material == material) & (lamp == luminaire)
        corners = scene.patches.corners()[chosen]
        second = corners[~scene.patches.is_triangle[chosen]]
        file = folder / f"{material}_{luminaire}.ply"
        _write_ply(file, np.concatenate([corners[:, [0, 1, 3]], second[:, [2, 3, 1]]]))
        paint = scene.materials[material]
        front = {"type": "diffuse", "reflectance": _spectrum(scene, paint.reflectance)}
        shape = {"type": "ply", "filename": str(file), "face_normals": True}
        shape["bsdf"] = {"type": "twosided", "bsdf": front} if paint.two_sided else front
        if luminaire >= 0:
            density = scene.luminaires[luminaire].exitance / scene.bands.width / np.pi
            shape["emitter"] = {"type": "area", "radiance": _spectrum(scene, density)}
        shapes[f"mesh_{material}_{luminaire}".replace("-1", "none")] = shape
    return shapes


def _facets(scene: Scene, folder: Path) -> dict[str, Any]:
    """Small white triangles around the readings, facing as they do."""
    place, normal = (np.concatenate([getattr(s, key) for s in scene.sensors]) for key in ("position", "normal"))
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
    across *= _FACET / np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normal, across)
    file = folder / "facets.ply"
    _write_ply(file, np.stack([place + across, place - 0.5 * across + along, place - 0.5 * across - along], axis=1))
    white = {"type": "diffuse", "reflectance": {"type": "uniform", "value": 1.0}}
    return {"type": "ply", "filename": str(file), "face_normals": True, "bsdf": white}


def _write_ply(path: Path, triangles: NDArray[np.float64]) -> None:
    """Triangles (n, 3, 3) that share no corners."""
    n = len(triangles)
    faces = np.insert(np.arange(3 * n).reshape(n, 3), 0, 3, axis=1)
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {3 * n}\n")
        file.writelines(f"property float {axis}\n" for axis in "xyz")
        file.write(f"element face {n}\nproperty list uchar int vertex_indices\nend_header\n")
        np.savetxt(file, triangles.reshape(-1, 3), fmt="%.9g")
        np.savetxt(file, faces, fmt="%d")


def _spectrum(scene: Scene, values: NDArray[np.float64]) -> dict[str, Any]:
    """Means of the bands at their centres, held out to the edges of the first and the last one."""
    bands = scene.bands
    waves = np.concatenate([bands.lower[:1], bands.centre, bands.upper[-1:]])
    return {"type": "spectrum", "value": list(zip(waves.tolist(), np.pad(values, 1, "edge").tolist()))}


def main() -> None:
    """As many paths as take the CPU seconds that are named, by a count that is timed first."""
    scene_file, result, budget, turns = sys.argv[1:]
    room = MitsubaRoom(load_scene(Path(scene_file)))
    room.irradiance(_FIRST_PATHS, 0)
    paths = _FIRST_PATHS
    for _ in range(_LONGEST_PILOT):
        start = time.process_time()
        room.irradiance(paths, 1)
        paths = max(1, round(paths * float(budget) / (time.process_time() - start)))
    found, spent = [], []
    for turn in range(int(turns)):
        start = time.process_time()
        found.append(room.irradiance(paths, 2 + turn))
        spent.append(time.process_time() - start)
    np.savez(result, irradiance=np.array(found), cpu_seconds=np.array(spent), paths=paths)


if __name__ == "__main__":
    main()
