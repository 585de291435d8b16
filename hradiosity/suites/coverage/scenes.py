"""The scenes that coverage is measured on."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene, Sensor
from hradiosity.suites.coverage import hard_rooms
from hradiosity.suites.coverage.exact_rooms import exact_spectra, room_text

CUBE_POINT: Final = tuple(f"cube-iso-rho{rho}" for rho in ("0.05", "0.20", "0.30", "0.50", "0.60", "0.80", "0.90"))
PANEL: Final = tuple(f"room443-panel-{name}" for name in ("band-B", "one-wall-dark", "uniform0.5", "752", "band-G"))
CEILINGS: Final = ("B (blue band)", "black walls", "A", "B (red wall band)")
CUBE_CEILING: Final = tuple(f"cube-lum-ceiling-{name}" for name in CEILINGS)
CHECKOUT: Final = Path(__file__).parents[3] / "scenes"
"""Where the scenes of the repository lie; installations come without them."""

Exact = Callable[[Scene], tuple[NDArray[np.float64], NDArray[np.float64]]]


@dataclass(frozen=True)
class CoverageScene:
    """A scene and where its truth comes from.

    about : what it is there for
    load : makes the scene
    exact : its exact spectra and their standard errors; None leaves them to unbiased paths
    paths : of those, from each reading
    fits : in the half that the weight of the mesh term is fitted on; the other half tests it
    """

    name: str
    about: str
    load: Callable[[], Scene]
    exact: Exact | None = None
    paths: int = 1 << 16
    fits: bool = False


def scene_of(text: str) -> Scene:
    """A scene from its file's text, read as a user's would be."""
    with tempfile.TemporaryDirectory(prefix="hradiosity-coverage-") as folder:
        (Path(folder) / "scene.toml").write_text(text, encoding="utf-8")
        return load_scene(Path(folder))


def choose(names: str | None) -> list[CoverageScene]:
    """Scenes by comma-separated names, all without.

    Raises
    ------
    ValueError
        For a name that none has.
    """
    if names is None:
        return list(SCENES)
    known = {scene.name: scene for scene in SCENES}
    unknown = [name for name in names.split(",") if name not in known]
    if unknown:
        raise ValueError(f"no scenes {', '.join(unknown)}; there are {', '.join(known)}")
    return [known[name] for name in names.split(",")]


def _exact(name: str, about: str, lamp: str, rooms: Sequence[str], *, fits: bool) -> CoverageScene:
    return CoverageScene(
        name,
        about,
        lambda: scene_of(room_text(name, lamp, rooms)),
        exact=partial(exact_spectra, lamp=lamp, names=rooms),
        fits=fits,
    )


def _thinned(name: str, steps: dict[str, int]) -> Scene:
    """A scene of the repository with every so-manieth row and column of its grids."""
    scene = load_scene(CHECKOUT / name)
    return replace(scene, sensors=tuple(_thin(sensor, steps.get(sensor.name, 1)) for sensor in scene.sensors))


def _thin(sensor: Sensor, step: int) -> Sensor:
    if sensor.grid is None or step == 1:
        return sensor
    kept = np.arange(len(sensor.position)).reshape(sensor.grid)[step // 2 :: step, step // 2 :: step]
    chosen = kept.ravel()
    return Sensor(sensor.name, sensor.position[chosen], sensor.normal[chosen], (kept.shape[0], kept.shape[1]))


def _made(name: str, about: str, text: Callable[[], str], paths: int, *, fits: bool) -> CoverageScene:
    return CoverageScene(name, about, lambda: scene_of(text()), paths=paths, fits=fits)


SCENES: Final[tuple[CoverageScene, ...]] = (
    _exact("cube_point", "cube, point source, reflectance 0.05 to 0.9, exact", "point", CUBE_POINT, fits=True),
    _exact("panel_room", "room under a panel, exact", "centre", PANEL, fits=False),
    _exact("cube_ceiling", "cube under a shining ceiling, exact", "ceiling", CUBE_CEILING, fits=True),
    CoverageScene("cornell_box", "Cornell box", partial(_thinned, "cornell_box", {"floor": 3}), paths=1 << 17),
    CoverageScene("office", "furnished office", partial(_thinned, "office", {"desk": 3}), paths=1 << 17, fits=True),
    CoverageScene("two_rooms", "dark room behind a gap", partial(_thinned, "two_rooms", {"desk": 2}), paths=1 << 20),
    _made("corridor", "20 m × 1 m, lamp at one end", hard_rooms.corridor, 1 << 20, fits=True),
    _made("louvres", "crossed slats under a lamp", hard_rooms.louvres, 1 << 18, fits=False),
    _made("bright_95", "furnished, reflectance up to 0.95", partial(hard_rooms.bright, 0.95), 1 << 16, fits=True),
    _made("bright_99", "furnished, reflectance up to 0.99", partial(hard_rooms.bright, 0.99), 1 << 15, fits=False),
    _made("spot", "lit by a bright spot on the ceiling", hard_rooms.spot, 1 << 19, fits=True),
    _made("lines", "saturated paints, mercury and sodium lamps", hard_rooms.lines, 1 << 16, fits=False),
    _made("clutter", "many small objects", hard_rooms.clutter, 1 << 17, fits=True),
    _made("slots", "slots, contacts, under furniture", hard_rooms.slots, 1 << 19, fits=False),
)
