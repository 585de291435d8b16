"""Whole scenes: time and error against unbiased paths, which are kept in the user's cache folder."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from hradiosity.io.cache import cache_folder
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.solution import Readings
from hradiosity.suites import accuracy
from hradiosity.suites.bench.figure import CPU, ERROR, WALL, Figure, exact_figure, figure_of
from hradiosity.suites.bench.session import Session
from hradiosity.suites.referee_cache import referee_readings, scene_digest

SCENES: Final = ("office", "cornell_box", "two_rooms")
QUALITIES: Final = ("draft", "normal")
PATHS: Final = {False: 16384, True: 2048}
"""Of the referee, from each reading, by whether the run is quick."""
_REFEREE_SEED: Final = 0xBE7C4
"""Far from those of the runs that are compared with it."""


def scene_file(session: Session, name: str) -> Path | None:
    """A scene of the checkout; with a note if there is none, since installations come without scenes."""
    path = Path(__file__).parents[3] / "scenes" / name / "scene.toml"
    if path.is_file():
        return path
    session.notes.append(f"{name} was skipped: scenes come with a checkout of the repository only")
    return None


def reference(session: Session, scene: Scene) -> dict[str, Readings]:
    """Unbiased readings, computed once a machine."""
    paths = PATHS[session.quick]
    folder = cache_folder() / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    cache = folder / f"{scene_digest(scene)[:16]}_{paths}.npz"
    return referee_readings(scene, session.device, paths, seed=_REFEREE_SEED, cache=cache)


def measure(session: Session) -> list[Figure]:
    """Each scene at each quality, repeated with other random numbers."""
    figures = []
    for name in SCENES:
        path = scene_file(session, name)
        if path is None:
            continue
        scene = load_scene(path)
        known = reference(session, scene)
        accuracy.measure(scene, session.device, QUALITIES[0], known)
        for quality in QUALITIES:
            seeds = range(1, 3 if session.quick else 5)
            outcomes = [accuracy.measure(scene, session.device, quality, known, seed=seed) for seed in seeds]
            of = f"scenes: {name} {quality}"
            figures += [
                figure_of(of, [o.cpu_seconds for o in outcomes], CPU),
                figure_of(of, [o.wall_seconds for o in outcomes], WALL),
                figure_of(f"{of}, spectral rms", [o.error.spectral_rms for o in outcomes], ERROR),
                figure_of(f"{of}, illuminance rms", [o.error.illuminance_rms for o in outcomes], ERROR),
            ]
        noise = outcomes[0].error
        figures += [
            exact_figure(f"scenes: {name}, noise of the reference, spectral", noise.reference_spectral_rms, ERROR),
            exact_figure(f"scenes: {name}, noise of the reference, lx", noise.reference_illuminance_rms, ERROR),
        ]
    return figures
