"""Whole scenes: time and error against unbiased paths, which are kept in the user's cache folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from hradiosity.io.cache import cache_folder
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.solution import Readings
from hradiosity.suites import accuracy
from hradiosity.suites.bench.figure import CPU, ERROR, WALL, Figure, exact_figure, figure_of
from hradiosity.suites.bench.session import Session
from hradiosity.suites.compare import Comparison
from hradiosity.suites.referee_cache import referee_readings, scene_digest

SCENES: Final = ("office", "cornell_box", "two_rooms")
QUALITIES: Final = ("draft", "normal")
PATHS: Final = {False: 65536, True: 2048}
"""Of the referee, from each reading, by whether the run is quick."""
MORE: Final = {"two_rooms": 2}
"""Times as many for some: the back room is lit through a door, and few paths find the lamp."""
MOST_NOISE: Final = 0.5
"""Of what is measured against the reference: an error is not told if more of it may be the reference's own."""
_REFEREE_SEED: Final = 0xBE7C4
"""Far from those of the runs that are compared with it."""


def scene_file(session: Session, name: str) -> Path | None:
    """A scene of the checkout; with a note if there is none, since installations come without scenes."""
    path = Path(__file__).parents[3] / "scenes" / name / "scene.toml"
    if path.is_file():
        return path
    session.notes.append(f"{name} was skipped: scenes come with a checkout of the repository only")
    return None


def reference(session: Session, name: str, scene: Scene) -> dict[str, Readings]:
    """Unbiased readings, computed once a machine."""
    paths = MORE.get(name, 1) * PATHS[session.quick]
    folder = cache_folder() / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    cache = folder / f"{scene_digest(scene)[:16]}_{paths}.npz"
    return referee_readings(scene, session.device, paths, seed=_REFEREE_SEED, cache=cache)


def error_figures(session: Session, of: str, errors: Sequence[Comparison]) -> list[Figure]:
    """Errors that are the run's own for the most part; a note tells of the others."""
    found = [
        ("spectral rms", [e.spectral_rms for e in errors], errors[0].reference_spectral_rms),
        ("illuminance rms", [e.illuminance_rms for e in errors], errors[0].reference_illuminance_rms),
    ]
    figures = []
    for what, values, noise in found:
        figure = figure_of(f"{of}, {what}", values, ERROR)
        if noise <= MOST_NOISE * figure.value:
            figures.append(figure)
        else:
            session.notes.append(
                f"{figure.name} is not told: {100 * figure.value:.2g} % against a reference with "
                f"{100 * noise:.2g} % of noise"
            )
    return figures


def measure(session: Session) -> list[Figure]:
    """Each scene at each quality, repeated with other random numbers."""
    figures = []
    for name in SCENES:
        path = scene_file(session, name)
        if path is None:
            continue
        scene = load_scene(path)
        known = reference(session, name, scene)
        accuracy.measure(scene, session.device, QUALITIES[0], known)
        for quality in QUALITIES:
            seeds = range(1, 3 if session.quick else 5)
            outcomes = [accuracy.measure(scene, session.device, quality, known, seed=seed) for seed in seeds]
            of = f"scenes: {name} {quality}"
            figures += [
                figure_of(of, [o.cpu_seconds for o in outcomes], CPU),
                figure_of(of, [o.wall_seconds for o in outcomes], WALL),
            ]
            figures += error_figures(session, of, [o.error for o in outcomes])
        noise = outcomes[0].error
        figures += [
            exact_figure(f"scenes: {name}, noise of the reference, spectral", noise.reference_spectral_rms, ERROR),
            exact_figure(f"scenes: {name}, noise of the reference, lx", noise.reference_illuminance_rms, ERROR),
        ]
    return figures
