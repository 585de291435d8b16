"""What can be proved about the sight between receivers and emitters, once for a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, NONE, Patches
from hradiosity.model.scene import Scene
from hradiosity.space.bvh import Bvh
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import Elements

if TYPE_CHECKING:
    from hradiosity.space.lit_sides import LitSides

UNKNOWN: Final = 0
"""Something may stand between, or the search was given up. Values as in ``cl/include/hr_sight.h``."""
FREE: Final = 1
"""Nothing stands between any two points of both."""
HIDDEN: Final = 2
"""One lies behind the other: no light goes between them."""

MOST_VISITS: Final = 64
"""Nodes and leaves of the ray structure that the search for something in between may look into."""
FARTHEST: Final = 3.0
"""Pairs farther apart than so many mean free paths of light are not proved free: hardly any shaft so long is empty."""
MOST_CELLS: Final = 32
"""Row elements of more cells are not tried: all of them would have to be proved, which costs more than the few rays of
the row that a proof may save."""
BATCH_PAIRS: Final = 1 << 22
"""Pairs on the device at a time."""


@dataclass(frozen=True)
class Receivers:
    """Flat places that light comes to.

    corners : (n, 4, 3) float64 [m], world, counter-clockwise seen from the side that receives; a triangle repeats its
        last corner, a point is there four times
    normal : (n, 3) float64, unit, of that side
    patch : (n,) int64, the patch that each lies on, which can't hide anything from it; NONE for a point in space
    """

    corners: NDArray[np.float64]
    normal: NDArray[np.float64]
    patch: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.patch)

    @classmethod
    def points(cls, position: NDArray[np.float64], normal: NDArray[np.float64]) -> Receivers:
        """Single points (n, 3) with unit normals."""
        corners = np.repeat(np.asarray(position, np.float64)[:, None, :], 4, axis=1)
        return cls(corners, normal, np.full(len(position), NONE, np.int64))


@dataclass(frozen=True)
class EmitterShapes:
    """Emitters as polygons.

    corners : (n, 4, 3) float64 [m], world; a point source repeats its place
    normal : (n, 3) float64, unit; 0 for a point source
    patch : (n,) int64, NONE for a point source
    two_sided : (n,) bool
    """

    corners: NDArray[np.float64]
    normal: NDArray[np.float64]
    patch: NDArray[np.int64]
    two_sided: NDArray[np.bool_]

    @classmethod
    def of(cls, scene: Scene) -> EmitterShapes:
        """Of all emitters of a scene, in their order."""
        lamps, patches = scene.emitters, scene.patches
        flat = lamps.patch != NONE
        corners = np.repeat(lamps.position[:, None, :], 4, axis=1)
        corners[flat] = patches.corners()[lamps.patch[flat]]
        normal = np.zeros((len(lamps), 3))
        normal[flat] = patches.normal[lamps.patch[flat]]
        two_sided = np.array([lamp.two_sided for lamp in scene.luminaires], bool)
        return cls(corners, normal, lamps.patch.astype(np.int64), two_sided[lamps.luminaire])


def prove_sight(
    bvh: Bvh,
    receivers: Receivers,
    emitters: EmitterShapes,
    pair_receiver: NDArray[np.integer[Any]],
    pair_emitter: NDArray[np.integer[Any]],
    *,
    reach: float = np.inf,
    most_visits: int = MOST_VISITS,
) -> NDArray[np.uint8]:
    """What is sure about each pair of a receiver and an emitter: UNKNOWN, FREE or HIDDEN.

    That the sight is free is tried where some point of the receiver may be within `reach` of the emitter's centre [m].

    FREE holds for the rays that kernels aim from points of the receiver, lifted by ``hr_offset_origin``, at points of
    the emitter that they see the shining side of (Haines & Wallace 1991).
    """
    device = bvh.device
    sight = np.zeros(len(pair_receiver), np.uint8)
    if not len(sight):
        return sight
    arrays = {
        "receiver_corner": device.upload(bvh.to_local(receivers.corners)),
        "receiver_normal": device.upload(receivers.normal, np.float32),
        "receiver_patch": device.upload(receivers.patch & 0xFFFFFFFF, np.uint32),
        "emitter_corner": device.upload(bvh.to_local(emitters.corners)),
        "emitter_normal": device.upload(emitters.normal, np.float32),
        "emitter_patch": device.upload(emitters.patch & 0xFFFFFFFF, np.uint32),
        "emitter_two_sided": device.upload(emitters.two_sided, np.uint32),
    }
    kernel = device.kernel("shafts", "prove_sight")
    for first in range(0, len(sight), BATCH_PAIRS):
        part = slice(first, first + BATCH_PAIRS)
        n = len(sight[part])
        found = device.empty((n,), np.uint8)
        kernel(
            n,
            **bvh.kernel_arguments(),
            **arrays,
            pair_receiver=device.upload(pair_receiver[part], np.uint32),
            pair_emitter=device.upload(pair_emitter[part], np.uint32),
            sight=found,
            scale=bvh.scale,
            reach=reach,
            most_visits=most_visits,
        )
        sight[part] = device.fetch(found)[:n]
    return sight


def point_sight(
    bvh: Bvh, emitters: EmitterShapes, position: NDArray[np.float64], normal: NDArray[np.float64]
) -> NDArray[np.uint8]:
    """(n_points, n_emitters) what is sure about single points (world frame [m], unit normals)."""
    pairs = np.indices((len(position), len(emitters.patch))).reshape(2, -1)
    found = prove_sight(bvh, Receivers.points(position, normal), emitters, pairs[0], pairs[1])
    return found.reshape(len(position), -1)


def row_sight(
    bvh: Bvh, patches: Patches, elements: Elements, emitters: EmitterShapes, lit: LitSides
) -> NDArray[np.uint8]:
    """(n_rows, n_emitters) what is sure about all cells of each row element.

    Patch sides are tried whole; those that nothing is sure of are cut in four, down to their cells. Pairs that share no
    lit space are left unknown: their shafts would fail, but that no ray found a way from one space to another does not
    prove that there is none.
    """
    cells = _cell_sight(bvh, patches, elements, emitters, lit)
    n_rows = len(elements)
    sight = np.zeros((n_rows, len(emitters.patch)), np.uint8)
    if n_rows:
        start, count = elements.row_start[:-1].astype(np.int64), np.diff(elements.row_start).astype(np.int64)
        sight = cells[elements.row_cell[start]]
        several = count > 1
        if several.any():
            of_these = cells[elements.row_cell[np.repeat(several, count)]]
            first = np.cumsum(count[several]) - count[several]
            low, high = (extreme.reduceat(of_these, first) for extreme in (np.minimum, np.maximum))
            sight[several] = np.where(low == high, low, UNKNOWN)
    return sight


def _share_a_space(lit: LitSides, emitters: EmitterShapes) -> NDArray[np.bool_]:
    """(2 n_patches, n_emitters) whether the side may look into a space that the emitter shines into."""
    space = lit.space.ravel()
    flat = emitters.patch != NONE
    patch = np.where(flat, emitters.patch, 0)
    front = lit.space[patch, 0]
    back = np.where(emitters.two_sided, lit.space[patch, 1], front)
    shared: NDArray[np.bool_] = ~flat | (space[:, None] == front) | (space[:, None] == back)
    return shared


@dataclass(frozen=True)
class _Level:
    """Squares of 2^level cells on all lit sides; a cut triangle is whole above its cells.

    side : (n,) int64, 2 · patch + side
    place : (n, 2) int64, column and row of the square; of a triangle's cell, its number and 0
    parent : (n,) int64, square of the next level
    new : (n,) bool, not the same as its parent
    """

    side: NDArray[np.int64]
    place: NDArray[np.int64]
    parent: NDArray[np.int64]
    new: NDArray[np.bool_]


def _cell_sight(
    bvh: Bvh, patches: Patches, elements: Elements, emitters: EmitterShapes, lit: LitSides
) -> NDArray[np.uint8]:
    """(n_cells, n_emitters) what is sure about each cell."""
    lit_side = np.unique(elements.cell_side).astype(np.int64)
    divisions = elements.divisions[lit_side // 2].astype(np.int64)
    triangle = patches.is_triangle[lit_side // 2]
    top = np.ceil(np.log2(divisions.max(axis=1, initial=1))).astype(np.int64)
    top[triangle] = np.minimum(top[triangle], 1)
    depth = int(top.max(initial=0))
    sight = np.zeros((len(lit_side), len(emitters.patch)), np.uint8)
    shared = _share_a_space(lit, emitters)
    shared[elements.cell_side[np.diff(elements.row_start)[elements.cell_row] > MOST_CELLS]] = False
    for level in range(depth, -1, -1):
        squares = _level(lit_side, divisions, triangle, top, level)
        if level < depth:
            sight = sight[squares.parent]
        tried = (sight == UNKNOWN) & squares.new[:, None] & shared[squares.side]
        pairs = np.nonzero(tried)
        some = tried.any(axis=1)
        used, receiver = np.flatnonzero(some), (np.cumsum(some) - 1)[pairs[0]]
        receivers = _receivers(patches, elements, squares, used, level)
        reach = FARTHEST * lit.free_path
        sight[pairs] = prove_sight(bvh, receivers, emitters, receiver, pairs[1], reach=reach)
    return sight


def _counts(
    divisions: NDArray[np.int64], triangle: NDArray[np.bool_], level: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Columns (m,) of squares on each side, and squares (m,)."""
    columns, rows = ((divisions + (1 << level) - 1) >> level).T
    columns = np.where(triangle, divisions[:, 0] ** 2 if level == 0 else 1, columns)
    return columns, np.where(triangle, columns, columns * rows)


def _level(
    lit_side: NDArray[np.int64],
    divisions: NDArray[np.int64],
    triangle: NDArray[np.bool_],
    top: NDArray[np.int64],
    level: int,
) -> _Level:
    columns, count = _counts(divisions, triangle, level)
    start = np.cumsum(count) - count
    which = np.repeat(np.arange(len(lit_side)), count)
    index = np.arange(len(which)) - start[which]
    place = np.stack([index % columns[which], index // columns[which]], axis=1)
    above_columns, above_count = _counts(divisions, triangle, level + 1)
    above = (place[:, 0] >> 1) + above_columns[which] * (place[:, 1] >> 1)
    parent = (np.cumsum(above_count) - above_count)[which] + np.where(triangle[which], 0, above)
    return _Level(lit_side[which], place, parent, (top >= level)[which])


def _receivers(patches: Patches, elements: Elements, squares: _Level, used: NDArray[np.int64], level: int) -> Receivers:
    """The squares `used` in space."""
    side = squares.side[used]
    patch = side // 2
    on_back = side % 2 == BACK
    normal = patches.normal[patch] * np.where(on_back, -1.0, 1.0)[:, None]
    if level == 0:
        return Receivers(cell_corners(patches, elements)[0][used], normal, patch)
    divisions = elements.divisions[patch].astype(np.float64)
    low = (squares.place[used] << level) / divisions
    high = np.minimum(((squares.place[used] + 1) << level) / divisions, 1.0)
    u = np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], axis=1)[..., None]
    v = np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], axis=1)[..., None]
    corners = patches.origin[patch][:, None] + u * patches.edge_u[patch][:, None] + v * patches.edge_v[patch][:, None]
    whole = patches.is_triangle[patch]
    corners[whole] = patches.corners()[patch[whole]]
    corners[on_back] = corners[on_back, ::-1]
    return Receivers(corners, normal, patch)
