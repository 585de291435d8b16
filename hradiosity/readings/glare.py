"""Glare at observers: which luminaires each of them sees, and UGR with the light that the solution has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.glare import (
    LARGEST,
    SMALLEST,
    glare_sum,
    position_index,
    rating_half_width,
    unified_glare_rating,
)
from hradiosity.metrics.photometric import luminance
from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Scene, Sensor
from hradiosity.solution import Readings, Solution
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_closest

POINTS: Final = 1024
"""Points of a luminaire that an observer's view of it is taken from, shared by its faces; four on each at least."""
FREE: Final = 1.0 - 1e-4
"""Share of the way to a point of a luminaire that must be free of other things."""
UP: Final = np.array([0.0, 0.0, 1.0])
NO_SOURCE, NO_BACKGROUND = "no luminaire in view", "no indirect light at the eye"


@dataclass(frozen=True)
class Sources:
    """Luminaires that observers see, a row for each pair.

    observer : (n,) int64
    object : (n,) int64, number of the object that shines
    luminance : (n,) float64 [cd m⁻²], mean over what is seen of it, without light that it reflects
    solid_angle : (n,) float64 [sr], of what is seen
    position_index : (n,) float64, of the middle of what is seen; NaN below the line of sight
    illuminance : (n,) float64 [lx], at the eye
    """

    observer: NDArray[np.int64]
    object: NDArray[np.int64]
    luminance: NDArray[np.float64]
    solid_angle: NDArray[np.float64]
    position_index: NDArray[np.float64]
    illuminance: NDArray[np.float64]

    def of(self, observer: int) -> NDArray[np.int64]:
        """Rows of one observer."""
        return np.flatnonzero(self.observer == observer)

    def doubt(self, row: int) -> str:
        """Why UGR does not hold for a source; empty if it does."""
        angle = float(self.solid_angle[row])
        if not np.isfinite(self.position_index[row]):
            return "lies below the line of sight"
        if not SMALLEST <= angle <= LARGEST:
            side = "small" if angle < SMALLEST else "large"
            return f"is too {side}: {angle:.2g} sr, not {SMALLEST:g} to {LARGEST:g}"
        return ""


@dataclass(frozen=True)
class Glare:
    """UGR at the observers of a sensor.

    ugr, half_width : (n,) float64, and of its 95 % interval, that of the background; NaN where it is refused
    background : (n,) float64 [cd m⁻²]
    reason : why there is no number, empty where there is one
    """

    sensor: str
    ugr: NDArray[np.float64]
    half_width: NDArray[np.float64]
    background: NDArray[np.float64]
    reason: tuple[str, ...]
    sources: Sources


def rate_glare(solution: Solution, device: Device | None = None) -> dict[str, Glare]:
    """UGR at every sensor of a solved scene that asks for it, by name; see `glare_of`.

    Parameters
    ----------
    solution : Solution
    device : Device, optional
        That rays to luminaires are traced on.
    """
    bvh = build_bvh(device or Device(), solution.scene.patches)
    return glare_of(solution.scene, solution.readings, bvh)


def glare_of(scene: Scene, readings: Mapping[str, Readings], bvh: Bvh) -> dict[str, Glare]:
    """UGR at every sensor of a scene that asks for it.

    The background is the indirect light on the plane at the eye: all of it less what comes straight from the
    luminaires that are counted. Its interval is that of the illuminance there; what is seen of each luminaire comes
    from `POINTS` even points and has none.

    Parameters
    ----------
    scene : Scene
    readings : mapping
        Illuminances at the eyes, by sensor.
    bvh : Bvh
        Of the scene's patches.
    """
    wanted = [sensor for sensor in scene.sensors if sensor.glare]
    return {sensor.name: _glare(scene, sensor, readings[sensor.name], bvh) for sensor in wanted}


def _glare(scene: Scene, sensor: Sensor, found: Readings, bvh: Bvh) -> Glare:
    sources = sources_seen(scene, sensor.place, sensor.direction, bvh)
    n = sensor.n_readings
    direct = np.bincount(sources.observer, sources.illuminance, n)
    indirect = np.maximum(found.illuminance - direct, 0.0)
    total = np.zeros(n)
    reasons = [""] * n
    for observer in range(n):
        rows = sources.of(observer)
        doubts = [(row, sources.doubt(int(row))) for row in rows]
        bad = [f"{scene.objects[sources.object[row]]} {doubt}" for row, doubt in doubts if doubt]
        if len(rows) == 0:
            reasons[observer] = NO_SOURCE
        elif bad:
            reasons[observer] = "; ".join(bad)
        elif indirect[observer] <= 0.0:
            reasons[observer] = NO_BACKGROUND
        else:
            shown = (sources.luminance[rows], sources.solid_angle[rows], sources.position_index[rows])
            total[observer] = glare_sum(*shown).sum()
    ugr = unified_glare_rating(total, indirect / np.pi)
    half_width = np.where(np.isfinite(ugr), rating_half_width(indirect, found.illuminance_half_width), np.nan)
    return Glare(sensor.name, ugr, half_width, indirect / np.pi, tuple(reasons), sources)


def sources_seen(scene: Scene, eye: NDArray[np.float64], gaze: NDArray[np.float64], bvh: Bvh) -> Sources:
    """Luminaires in front of each observer, all shining faces of an object together.

    Point sources have no luminance and do not count as luminaires; their light is part of the background.

    Parameters
    ----------
    eye, gaze : (n, 3) float64 [m], unit
    """
    points = _points(scene)
    sums = np.array([_seen(points, e, g, bvh) for e, g in zip(eye, gaze)]).reshape(len(eye), -1, 6)
    observer, number = np.nonzero(sums[:, :, 0] > 0.0)
    angle, light, lux = (sums[observer, number, k] for k in range(3))
    middle = sums[observer, number, 3:]
    middle = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    across = upright(gaze)[observer]
    index = position_index(gaze[observer], across, middle)
    return Sources(observer, points.objects[number], light / angle, angle, index, lux)


def upright(gaze: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) unit vectors across the lines of sight, upwards; +y where those are upright themselves."""
    level = np.abs(gaze[:, 2]) > 1.0 - 1e-9
    wanted = np.where(level[:, None], np.array([0.0, 1.0, 0.0]), UP)
    across = wanted - np.einsum("nd,nd->n", wanted, gaze)[:, None] * gaze
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


@dataclass(frozen=True)
class _Points:
    """Even points on all shining faces: place, area that each stands for, luminance, which object of `objects`."""

    place: NDArray[np.float64]
    normal: NDArray[np.float64]
    two_sided: NDArray[np.bool_]
    area: NDArray[np.float64]
    luminance: NDArray[np.float64]
    patch: NDArray[np.int64]
    owner: NDArray[np.int64]
    objects: NDArray[np.int64]


def _points(scene: Scene) -> _Points:
    patches, emitters = scene.patches, scene.emitters
    area_lamps = np.flatnonzero(emitters.patch != NONE)
    patch = emitters.patch[area_lamps].astype(np.int64)
    objects, owner = np.unique(patches.object[patch].astype(np.int64), return_inverse=True)
    edge = np.maximum(2, np.sqrt(POINTS / np.bincount(owner, minlength=1))).astype(np.int64)[owner]
    lamps = [scene.luminaires[k] for k in emitters.luminaire[area_lamps]]
    bright = np.array([luminance(lamp.exitance / np.pi, scene.bands) for lamp in lamps])
    both = np.array([lamp.two_sided for lamp in lamps], bool)
    which = np.repeat(np.arange(len(patch)), edge**2)
    number = np.arange(len(which)) - np.repeat(np.cumsum(edge**2) - edge**2, edge**2)
    side = edge[which]
    u, v = (number % side + 0.5) / side, (number // side + 0.5) / side
    # A square folds into a triangle with equal areas: s = √u, the point is (1 − s, s v).
    triangle = patches.is_triangle[patch][which]
    s = np.sqrt(u)
    u, v = np.where(triangle, 1.0 - s, u), np.where(triangle, s * v, v)
    own = patch[which]
    place = patches.origin[own] + u[:, None] * patches.edge_u[own] + v[:, None] * patches.edge_v[own]
    return _Points(
        place,
        patches.normal[own],
        both[which],
        patches.area[own] / side**2,
        bright[which] if len(bright) else np.zeros(0),
        own,
        owner[which],
        objects,
    )


def _seen(points: _Points, eye: NDArray[np.float64], gaze: NDArray[np.float64], bvh: Bvh) -> NDArray[np.float64]:
    """(n_objects, 6) solid angle, luminance times solid angle, illuminance at the eye, sum of directions."""
    way = points.place - eye
    square = np.einsum("nd,nd->n", way, way)
    direction = way / np.sqrt(square)[:, None]
    facing = -np.einsum("nd,nd->n", direction, points.normal)
    facing = np.where(points.two_sided, np.abs(facing), facing)
    ahead = direction @ gaze
    some = np.flatnonzero((facing > 0.0) & (ahead > 0.0))
    hits = trace_closest(bvh, np.broadcast_to(eye, (len(some), 3)), way[some], t_max=2.0)
    some = some[(hits.patch == points.patch[some]) | (hits.t > FREE)]
    angle = points.area[some] * facing[some] / square[some]
    light = points.luminance[some] * angle
    columns = [angle, light, light * ahead[some], *(angle[:, None] * direction[some]).T]
    n = len(points.objects)
    return np.stack([np.bincount(points.owner[some], column, n) for column in columns], axis=1)
