"""The model in grey, seen from a place that shows what a finding is about; walls that would hide it are left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import encode_srgb
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Scene, View
from hradiosity.show.camera import project, view_axes
from hradiosity.show.exposure import to_bytes
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_closest

Pixels = NDArray[np.uint8]

_SAMPLES: Final = 2
"""Across and down a pixel."""
_PASSES: Final = 12
"""Hidden surfaces that a ray may pass before it counts as leaving the scene."""
_BACKGROUND: Final = (0.93, 0.94, 0.96)
_GREY: Final = 0.55
_LAMP: Final = (0.95, 0.85, 0.35)
_LINE: Final = 0.35
"""Share of the brightness that is left on an outline."""
_FIELD: Final = 45.0
_BOX: Final = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
_FROM: Final = (-0.55, -0.8, 0.62)
"""Direction from the middle of the scene to the camera of the overview."""
_FRAMED: Final = 3.8
"""Distance of a close camera over the size of what it shows."""
_NEAREST: Final = 0.2
"""Least distance of a close camera over the size of the scene."""
_WITHIN: Final = 0.6
"""What a camera inside the bounding box is worth, in shares of what it sees."""
_TIE: Final = 3e-6
"""Over the size of the scene: surfaces closer than this are in one place."""
_STEP: Final = 1e-3
"""Over the size of the scene: a larger step between neighbouring samples is an outline."""
_TARGETS: Final = 24
_SURROUNDINGS: Final = 0.06
"""Of a place without patches: over the size of the scene."""
_ELEVATIONS: Final = (20.0, 40.0, 65.0, -15.0, -40.0)
_AZIMUTHS: Final = 16


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene to look at.

    scene : Scene
    bvh : Bvh
        Of the scene's patches.
    shown : (n_patches, 2) bool
        Sides that are drawn; the others, such as the outsides of a room, are looked through.
    """

    scene: Scene
    bvh: Bvh
    shown: NDArray[np.bool_]

    @property
    def size(self) -> float:
        """Diagonal of the bounding box [m]."""
        low, high = self.scene.patches.bounds()
        return float(np.linalg.norm(high - low))


@dataclass(frozen=True, eq=False)
class _Seen:
    """What n rays meet: patch (n,) or NONE, and the distance (n,) in lengths of the direction."""

    patch: NDArray[np.int64]
    distance: NDArray[np.float64]


def marked_places(stage: Stage, patches: Sequence[int], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) points that show a finding: its place, and random points of its patches or else around it [m]."""
    own = np.asarray(patches, dtype=np.int64)
    rng = np.random.default_rng(7)
    if not len(own):
        around = rng.standard_normal((_TARGETS, 3))
        around *= _SURROUNDINGS * stage.size / np.linalg.norm(around, axis=1, keepdims=True)
        return np.concatenate([place[None], place + around])
    scene_patches = stage.scene.patches
    area = np.maximum(scene_patches.area[own], np.finfo(float).tiny)
    chosen = own[rng.choice(len(own), _TARGETS, p=area / area.sum())]
    uv = rng.random((_TARGETS, 2))
    fold = scene_patches.is_triangle[chosen] & (uv.sum(axis=1) > 1.0)
    uv[fold] = 1.0 - uv[fold]
    points = scene_patches.origin[chosen] + uv[:, :1] * scene_patches.edge_u[chosen]
    return np.concatenate([place[None], points + uv[:, 1:] * scene_patches.edge_v[chosen]])


def close_view(
    stage: Stage, patches: Sequence[int], place: NDArray[np.float64], size: float, width: int, height: int
) -> View:
    """A camera near a place that sees as much of the patches there as any of a few dozen places around it."""
    targets = marked_places(stage, patches, place)
    near = np.linalg.norm(targets - place, axis=1) <= max(1.2 * size, 1.01 * _SURROUNDINGS * stage.size)
    targets = targets[near]
    reach = float(np.linalg.norm(targets - place, axis=1).max(initial=0.0))
    distance = float(np.clip(_FRAMED * max(reach, 0.5 * size), _NEAREST * stage.size, 1.3 * stage.size))
    around = _directions()
    camera = place + distance * around
    share = _visible_share(stage, camera, targets, patches)
    facing = np.zeros(len(around))
    if patches:
        normal = stage.scene.patches.normal[np.asarray(patches)].mean(axis=0)
        facing = np.abs(around @ normal)
    steep = np.abs(np.degrees(np.arcsin(np.clip(around[:, 2], -1.0, 1.0))) - 35.0) / 90.0
    low, high = stage.scene.patches.bounds()
    within = ((camera > low) & (camera < high)).all(axis=1)
    score = (1.0 if patches else 0.5) * share + 0.4 * np.minimum(facing, 0.7) - 0.3 * steep + _WITHIN * within
    return _looking(camera[int(score.argmax())], place, _FIELD, width, height)


def overview(stage: Stage, width: int, height: int) -> View:
    """A camera outside and above, as near as the whole scene is in its picture."""
    low, high = stage.scene.patches.bounds()
    middle = 0.5 * (low + high)
    corners = low + _BOX * (high - low)
    direction = np.array(_FROM) / np.linalg.norm(_FROM)
    for distance in stage.size * np.linspace(0.7, 2.4, 35):
        view = _looking(middle + distance * direction, middle, _FIELD, width, height)
        share = project(view, corners) / [width, height]
        if (np.abs(share - 0.5) < 0.48).all():
            break
    return view


def frame_lines(stage: Stage, view: View) -> NDArray[np.float64]:
    """(12, 2, 2) edges of the bounding box in pixels of a view."""
    low, high = stage.scene.patches.bounds()
    corner = low + _BOX * (high - low)
    ends = [(i, j) for i in range(8) for j in range(i + 1, 8) if np.abs(_BOX[i] - _BOX[j]).sum() == 1.0]
    return project(view, corner[np.array(ends)].reshape(-1, 3)).reshape(-1, 2, 2)


def draw(stage: Stage, view: View, marked: Sequence[int], colour: tuple[float, float, float]) -> Pixels:
    """(height, width, 3) sRGB of a view, with some patches in a colour.

    Where a marked patch lies in one place with another one it is drawn, whichever of them the ray meets.
    """
    origin, direction, right = _rays(view)
    seen = _first_shown(stage, origin, direction)
    patch, distance, is_marked = _with_marked(stage, origin, direction, seen, marked)
    linear = _shaded(stage, patch, direction, right, is_marked, colour)
    linear[_outlines(stage, origin + distance[:, None] * direction, patch, is_marked, view)] *= _LINE
    mean = linear.reshape(view.height, _SAMPLES, view.width, _SAMPLES, 3).mean(axis=(1, 3))
    return to_bytes(encode_srgb(mean.reshape(-1, 3))).reshape(view.height, view.width, 3)


def _with_marked(
    stage: Stage,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    seen: _Seen,
    marked: Sequence[int],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
    """Patch and distance (n,) of what is seen, and where that is a marked patch: they win in one place with others."""
    if not marked:
        return seen.patch, seen.distance, np.zeros(len(origin), np.bool_)
    own = np.asarray(marked, dtype=np.int64)
    alone = Patches(**{name: array[own] for name, array in vars(stage.scene.patches).items()})
    hits = trace_closest(build_bvh(stage.bvh.device, alone), origin, direction)
    tie = _TIE * stage.size / np.linalg.norm(direction, axis=1)
    is_marked = (hits.patch != NONE) & (hits.t <= seen.distance + tie)
    patch = np.where(is_marked, own[np.maximum(hits.patch, 0)], seen.patch)
    return patch, np.where(is_marked, hits.t, seen.distance), is_marked


def is_in_sight(stage: Stage, view: View, place: NDArray[np.float64], patches: Sequence[int]) -> bool:
    """Whether nothing that is drawn stands between a camera and a place."""
    return bool(_visible_share(stage, view.position[None], place[None], patches)[0] > 0.0)


def _shaded(
    stage: Stage,
    patch: NDArray[np.int64],
    direction: NDArray[np.float64],
    right: NDArray[np.float64],
    is_marked: NDArray[np.bool_],
    colour: tuple[float, float, float],
) -> NDArray[np.float64]:
    """(n, 3) linear colour of the samples: lamps yellow, the rest grey, lit from beside the camera."""
    scene = stage.scene
    paint = np.full((len(scene.patches), 3), _GREY)
    lamps = scene.emitters.patch[scene.emitters.patch != NONE]
    paint[lamps] = _LAMP
    normal = scene.patches.normal[np.maximum(patch, 0)]
    length = np.linalg.norm(direction, axis=1)
    ahead = np.abs(np.einsum("ij,ij->i", normal, direction)) / length
    beside = np.abs(normal @ (0.6 * right + np.array([0.0, 0.0, 0.8])))
    light = 0.35 + 0.4 * ahead + 0.25 * beside
    linear = np.where(is_marked[:, None], np.asarray(colour), paint[np.maximum(patch, 0)]) * light[:, None]
    linear[patch == NONE] = _BACKGROUND
    return np.asarray(linear, dtype=np.float64)


def _outlines(
    stage: Stage, point: NDArray[np.float64], patch: NDArray[np.int64], is_marked: NDArray[np.bool_], view: View
) -> NDArray[np.bool_]:
    """(n,) samples whose right or lower neighbour is marked otherwise, bends away or lies farther off."""
    shape = (_SAMPLES * view.height, _SAMPLES * view.width)
    normal = np.where(patch[:, None] == NONE, 0.0, stage.scene.patches.normal[np.maximum(patch, 0)])
    point = np.where(patch[:, None] == NONE, 0.0, point)
    grid_normal, grid_point = normal.reshape(*shape, 3), point.reshape(*shape, 3)
    grid_kind = (2 * (patch != NONE) + is_marked).reshape(shape)
    edge = np.zeros(shape, np.bool_)
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        bend = np.abs(np.einsum("ijk,ijk->ij", grid_normal[here], grid_normal[there])) < 1.0 - 1e-4
        step = np.abs(np.einsum("ijk,ijk->ij", grid_normal[here], grid_point[there] - grid_point[here]))
        both = (grid_kind[here] > 1) & (grid_kind[there] > 1)
        edge[here] |= (grid_kind[here] != grid_kind[there]) | (both & (bend | (step > _STEP * stage.size)))
    return edge.ravel()


def _first_shown(
    stage: Stage, origin: NDArray[np.float64], direction: NDArray[np.float64], marked: Sequence[int] = ()
) -> _Seen:
    """The first side of each ray that is drawn; marked patches are, from both sides."""
    shown = stage.shown.copy()
    shown[np.asarray(marked, dtype=np.int64)] = True
    n = len(origin)
    patch, distance = np.full(n, NONE, np.int64), np.full(n, np.inf)
    ray, passed, last = np.arange(n), np.zeros(n), np.full(n, NONE, np.int32)
    for _ in range(_PASSES):
        start = origin[ray] + passed[:, None] * direction[ray]
        hits = trace_closest(stage.bvh, start, direction[ray], skip_patch=last)
        far = passed + hits.t.astype(np.float64)
        met = hits.patch != NONE
        drawn = met & shown[np.maximum(hits.patch, 0), hits.side]
        patch[ray[drawn]], distance[ray[drawn]] = hits.patch[drawn], far[drawn]
        onwards = met & ~drawn
        ray, passed, last = ray[onwards], far[onwards], hits.patch[onwards]
        if not len(ray):
            break
    return _Seen(patch, distance)


def _visible_share(
    stage: Stage, eyes: NDArray[np.float64], targets: NDArray[np.float64], patches: Sequence[int]
) -> NDArray[np.float64]:
    """(n,) share of the targets (k, 3) that nothing drawn hides from each eye (n, 3)."""
    direction = (targets[None] - eyes[:, None]).reshape(-1, 3)
    seen = _first_shown(stage, np.repeat(eyes, len(targets), axis=0), direction, patches)
    free = (seen.distance > 1.0 - 2e-3) | np.isin(seen.patch, patches)
    return np.asarray(free.reshape(len(eyes), -1).mean(axis=1))


def _directions() -> NDArray[np.float64]:
    """(n, 3) unit vectors from a place towards the cameras that are tried."""
    azimuth, elevation = np.meshgrid(
        np.radians(np.arange(_AZIMUTHS) * 360.0 / _AZIMUTHS + 10.0), np.radians(_ELEVATIONS)
    )
    level = np.cos(elevation)
    vectors = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)
    return np.asarray(vectors.reshape(-1, 3))


def _looking(position: NDArray[np.float64], at: NDArray[np.float64], field: float, width: int, height: int) -> View:
    direction = (at - position) / np.linalg.norm(at - position)
    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    return View("finding", position, direction, up, field, width, height)


def _rays(view: View) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Origin and direction of every sample, row by row, and the unit vector to the right."""
    forward, right, down = view_axes(view)
    width, height = _SAMPLES * view.width, _SAMPLES * view.height
    x = (2.0 * np.arange(width) + 1.0) / width - 1.0
    y = (2.0 * np.arange(height) + 1.0) / height - 1.0
    direction = forward + y[:, None, None] * down + x[None, :, None] * right
    flat = direction.reshape(-1, 3)
    return np.broadcast_to(view.position, flat.shape), flat, right / np.linalg.norm(right)
