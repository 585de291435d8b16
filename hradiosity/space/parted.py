"""Faces that lie back to back in one plane and differ, taken a hair apart so that rays meet the right one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Note, Scene, Sensor
from hradiosity.space.coplanar import COINCIDENT, Coplanar, coplanar_pairs

HAIR: Final = 2.0**-17
"""How far a face is moved, relative to the scene's half extent: what flush surfaces and rounding may be apart."""
_ROUNDING: Final = 1e-8
"""Faces closer than this, relative to the scene's diagonal, lie in one plane; farther apart their order is meant."""
_SAME_WAY: Final = 1.0 - 1e-6
"""Cosine between normals from which on faces of one plane belong to one wall."""
_MOST: Final = 1 << 24
"""Corners times walls of an object up to which its sides are looked for; beyond, faces stand before their backs."""


@dataclass(frozen=True)
class _Wall:
    """Faces of one object in one plane that face the same way.

    faces : (n,) int64
    way : (3,) float64, unit vector to their side
    certain : bool, the object lies on that side only
    """

    faces: NDArray[np.int64]
    way: NDArray[np.float64]
    certain: bool


def part_back_to_back(scene: Scene) -> Scene:
    """The scene with faces that lie in one plane, back to back, and differ moved to their own sides; a note tells.

    Two rooms that share a wall, each with a paint of its own, or a sheet whose sides were modelled as two faces: rays
    would meet either from both sides. A face moves towards its object if that lies on one side of the plane, else to
    where it faces; if both move the same way, the smaller goes twice as far. All faces of the object in that plane go
    with it, so that no crack opens, and so do sensors on them. Faces of solids stay: there matter decides.
    """
    patches = scene.patches
    if not len(patches):
        return scene
    low, high = patches.bounds()
    pairs = _unlike(scene)
    walls = _walls(patches, pairs, COINCIDENT * float(np.linalg.norm(high - low)))
    pairs = _back_to_back(patches, pairs, walls, _ROUNDING * float(np.linalg.norm(high - low)))
    if not len(pairs.first):
        return scene
    hair = HAIR * 0.5 * float((high - low).max())
    shift = np.zeros((len(patches), 3))
    meant = np.concatenate([pairs.first, pairs.second])
    for wall in walls:
        if np.isin(wall.faces, meant).any():
            shift[wall.faces] = hair * wall.way
    _further(patches, pairs, shift)
    moved = replace(patches, origin=patches.origin + shift)
    sensors = tuple(_carried(patches, shift, sensor, hair) for sensor in scene.sensors)
    note = Note(
        "info",
        "surfaces",
        f"{pairs.area.sum():.3g} m² of faces that lie back to back in one plane and differ were moved by "
        f"{1e6 * hair:.2g} µm, each to its own side",
    )
    return replace(scene, patches=moved, sensors=sensors, notes=(*scene.notes, note))


def _unlike(scene: Scene) -> Coplanar:
    """Pairs of faces in one plane, of no solid, that differ in material or light or whose backs are black."""
    patches = scene.patches
    loose = np.flatnonzero(patches.solid == NONE)
    pairs = coplanar_pairs(Patches(**{name: array[loose] for name, array in vars(patches).items()}))
    pairs = replace(pairs, first=loose[pairs.first], second=loose[pairs.second])
    emits = np.zeros(len(patches), bool)
    emits[scene.emitters.patch[scene.emitters.patch != NONE]] = True
    black_back = ~np.array([material.two_sided for material in scene.materials], bool)[patches.material]
    first, second = pairs.first, pairs.second
    unlike = (patches.material[first] != patches.material[second]) | black_back[first] | emits[first] | emits[second]
    return _some(pairs, unlike)


def _some(pairs: Coplanar, which: NDArray[np.bool_]) -> Coplanar:
    return Coplanar(**{name: array[which] for name, array in vars(pairs).items()})


def _walls(patches: Patches, pairs: Coplanar, tolerance: float) -> list[_Wall]:
    """The walls that faces of the pairs belong to."""
    normal, corners = patches.normal, patches.corners()
    walls = []
    waiting = np.unique(np.concatenate([pairs.first, pairs.second]))
    for number in np.unique(patches.object[waiting]):
        own = np.flatnonzero(patches.object == number)
        left = waiting[patches.object[waiting] == number]
        look = len(left) * corners[own].size < _MOST
        while len(left):
            face = left[0]
            height = (corners[own] - patches.origin[face]) @ normal[face]
            flat = (np.abs(height) <= tolerance).all(axis=1) & (normal[own] @ normal[face] > _SAME_WAY)
            below, above = height.min() < -tolerance, height.max() > tolerance
            one_side = bool(look and below != above)
            way = -normal[face] if one_side and below else normal[face]
            walls.append(_Wall(np.union1d(own[flat], face), way, one_side))
            left = np.setdiff1d(left, walls[-1].faces)
    return walls


def _back_to_back(patches: Patches, pairs: Coplanar, walls: list[_Wall], rounding: float) -> Coplanar:
    """Pairs that face apart, or whose objects certainly lie on either side; not those that face over a hair's gap."""
    way, certain = np.zeros((len(patches), 3)), np.zeros(len(patches), bool)
    for wall in walls:
        way[wall.faces], certain[wall.faces] = wall.way, wall.certain
    first, second = pairs.first, pairs.second
    apart = np.einsum("md,md->m", way[first], way[second]) < 0.0
    ahead = np.einsum("md,md->m", patches.centroid[second] - patches.origin[first], way[first])
    meant = ~pairs.same_facing | (apart & certain[first] & certain[second])
    return _some(pairs, meant & ~(apart & (ahead > rounding)))


def _further(patches: Patches, pairs: Coplanar, shift: NDArray[np.float64]) -> None:
    """Where both of a pair were moved the same way, move the smaller object's face once more."""
    together = np.einsum("md,md->m", shift[pairs.first], shift[pairs.second]) > 0.0
    area = np.bincount(patches.object, patches.area)[patches.object]
    first, second = pairs.first[together], pairs.second[together]
    smaller = np.unique(np.where(area[first] < area[second], first, second))
    shift[smaller] *= 2.0


def _carried(patches: Patches, shift: NDArray[np.float64], sensor: Sensor, hair: float) -> Sensor:
    """The sensor with positions on moved faces, or closer in front of them than these moved, moved likewise."""
    position = sensor.position.copy()
    for face in np.flatnonzero(shift.any(axis=1)):
        way = shift[face]
        offset = sensor.position - patches.origin[face]
        height = offset @ way / np.linalg.norm(way)
        near = np.flatnonzero((np.abs(height) <= 2.0 * np.linalg.norm(way)) & (sensor.normal @ way > 0.0))
        edges = np.stack([patches.edge_u[face], patches.edge_v[face]], axis=1)
        share = np.linalg.lstsq(edges, offset[near].T, rcond=None)[0]
        slack = hair / np.linalg.norm(edges, axis=0).min()
        most = share.sum(axis=0) if patches.is_triangle[face] else share.max(axis=0)
        on = near[(share.min(axis=0) >= -slack) & (most <= 1.0 + slack)]
        position[on] = sensor.position[on] + way
    return replace(sensor, position=position)
