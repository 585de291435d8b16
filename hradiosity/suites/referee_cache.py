"""Keeps the referee's readings of a scene in a file, since they take long and do not change."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hradiosity.device import Device
from hradiosity.model.scene import Scene
from hradiosity.radiosity.referee import Referee, RefereeState, scramble_moments
from hradiosity.readings.paths import RefereeSamples
from hradiosity.solution import Readings


def referee_readings(
    scene: Scene,
    device: Device,
    paths: int,
    *,
    seed: int = 0,
    cache: Path | None = None,
    progress: Callable[[RefereeState], None] | None = None,
) -> dict[str, Readings]:
    """Unbiased readings by sensor name; parameters as those of `referee_samples`."""
    samples = referee_samples(scene, device, paths, seed=seed, cache=cache, progress=progress)
    return scramble_moments(scene, samples).readings()


def referee_samples(
    scene: Scene,
    device: Device,
    paths: int,
    *,
    seed: int = 0,
    cache: Path | None = None,
    progress: Callable[[RefereeState], None] | None = None,
) -> RefereeSamples:
    """Unbiased spectra of all readings, from the cache if it holds as many paths of the same scene and seed.

    Parameters
    ----------
    paths : int
        From each reading.
    cache : Path, optional
        An ``.npz`` file, read and written; a KeyboardInterrupt writes what was reached, and goes on to the caller.
    progress : callable, optional
        Called after each round.
    """
    digest = scene_digest(scene)
    kept = load_samples(cache, digest, seed, paths) if cache is not None else None
    if kept is None:
        referee = Referee(scene, device, paths, seed)
        traced = False
        try:
            for state in referee.states():
                traced = True
                if progress is not None:
                    progress(state)
        finally:
            if cache is not None and traced:
                save_samples(cache, digest, seed, referee.samples())
        kept = referee.samples()
    return kept


def scene_digest(scene: Scene) -> str:
    """Hexadecimal digits that change when anything that light depends on does."""
    digest = hashlib.sha256()
    patches, emitters = scene.patches, scene.emitters
    arrays = [patches.origin, patches.edge_u, patches.edge_v, patches.is_triangle, patches.material, patches.solid]
    arrays += [emitters.patch, emitters.position, emitters.luminaire, scene.bands.lower, scene.bands.upper]
    arrays += [scene.reflectance, np.array([m.two_sided for m in scene.materials], bool)]
    for lamp in scene.luminaires:
        arrays += [lamp.exitance, lamp.intensity, np.array([lamp.two_sided])]
    for sensor in scene.sensors:
        arrays += [np.frombuffer(sensor.name.encode(), np.uint8), sensor.position, sensor.normal]
        if sensor.parts is not None and sensor.parts.response is not None:
            arrays.append(sensor.parts.response)
    if scene.sky is not None:
        arrays.append(scene.sky.radiance)
    for array in arrays:
        digest.update(str(array.shape).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def save_samples(path: Path, digest: str, seed: int, samples: RefereeSamples) -> None:
    """Keep samples in an ``.npz`` file, with what they belong to."""
    np.savez(
        path,
        digest=digest,
        seed=seed,
        paths=samples.paths,
        rays=samples.rays,
        lost_weight=samples.lost_weight,
        per_scramble=samples.per_scramble,
        enclosed=samples.enclosed,
    )


def load_samples(path: Path, digest: str, seed: int, paths: int) -> RefereeSamples | None:
    """What the file holds; None when there is none, or it is of another scene or seed, or of fewer paths."""
    if not path.is_file():
        return None
    with np.load(path, allow_pickle=False) as kept:
        if str(kept["digest"]) != digest or int(kept["seed"]) != seed or int(kept["paths"]) < paths:
            return None
        return RefereeSamples(
            per_scramble=kept["per_scramble"],
            enclosed=kept["enclosed"],
            paths=int(kept["paths"]),
            lost_weight=float(kept["lost_weight"]),
            rays=int(kept["rays"]),
        )
