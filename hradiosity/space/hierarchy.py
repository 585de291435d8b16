"""Row elements: how the patches are cut, and small ones joined."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.slots import with_slots

NONE: Final = 0xFFFFFFFF
"""No element there."""
MISS: Final = 0xFFFFFFFF
"""Outcome of a ray: left the scene below the horizon. Values as in ``cl/include/hr_outcomes.h``."""
SKY: Final = 0xFFFFFFFE
"""Outcome of a ray: left the scene above the horizon."""
COVERED: Final = 0xFFFFFFFD
"""Outcome of a ray: it started inside a solid."""
UNLIT: Final = 0xFFFFFFFC
"""Outcome of a ray: it ended on a side that no light was found to reach."""
LONG: Final = 0xFFFFFFFB
"""Outcome of a path: it met more hits than it has room for."""


@dataclass(frozen=True)
class Elements:
    """The row elements of a scene, and the grid of cells that hits are sorted into.

    Each lit patch side is cut into cells: nu × nv sub-parallelograms (index iu + nu·iv) or n × n sub-triangles, listed
    by rows of decreasing length. A row element owns one cell, or the single cells of several small patches.

    divisions : (n_patches, 2) uint32, cells along edge_u and edge_v; even or 1, so that twos merge into coarser cells
    first_cell : (n_patches, 2) uint32, first cell of the front and of the back, NONE where no light comes
    cell_row : (n_cells,) uint32, the row element that owns the cell
    cell_side : (n_cells,) uint32, 2 · patch + side
    row_start : (n_rows + 1,) uint32, into `row_cell`
    row_cell : (n_cells,) uint32, cells of row 0, then of row 1, …
    row_share : (n_cells,) float32, share of the row's area up to and with this cell, ordered as `row_cell`
    area : (n_rows,) float64 [m²], covered parts included
    side_material : (n_patches, 2) uint32, material of each side; ``n_materials`` stands for the black back of a
        one-sided one
    row_material : (n_rows,) uint32
    """

    divisions: NDArray[np.uint32]
    first_cell: NDArray[np.uint32]
    cell_row: NDArray[np.uint32]
    cell_side: NDArray[np.uint32]
    row_start: NDArray[np.uint32]
    row_cell: NDArray[np.uint32]
    row_share: NDArray[np.float32]
    area: NDArray[np.float64]
    side_material: NDArray[np.uint32]
    row_material: NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.area)


def build_elements(
    patches: Patches,
    space: NDArray[np.int32],
    two_sided: NDArray[np.bool_],
    size: float,
    *,
    grouping: bool = True,
    paint: NDArray[np.uint32] | None = None,
    slots: NDArray[np.int64] | None = None,
) -> Elements:
    """Cut the lit sides into elements of about `size`, and join small faces.

    Parameters
    ----------
    patches : Patches
    space : (n_patches, 2) int32
        Space that each side looks into, −1 where no light comes.
    two_sided : (n_materials,) bool
    size : float
        Wanted edge length h of an element [m].
    grouping : bool
        Join uncut faces of one material and one space whose normals lie within about 45° and whose centres lie in one
        cube of edge h (Willmott, Heckbert & Garland 1999 call such a set a face cluster).
    paint : (n_patches, 2) uint32, optional
        Faces are joined only where this is the same, in place of the material.
    slots : (n_patches, 2) int64, optional
        Cells that walls of slots should have along both edges, see `hradiosity.space.slots`.
    """
    divisions = grid_divisions(patches, size)
    if slots is not None and slots.any():
        divisions = with_slots(patches, (space >= 0).sum(axis=1), divisions, slots)
    first_cell, cell_side = cut_sides(patches, space, divisions)
    side_material = side_materials(patches, two_sided)
    count = _cells_a_side(patches, divisions)
    cell_row = (
        _group_rows(patches, space, cell_side, count, side_material if paint is None else paint, size)
        if grouping
        else np.arange(len(cell_side), dtype=np.int64)
    )
    return join_cells(patches, divisions.astype(np.uint32), first_cell, cell_side, side_material, cell_row)


def cut_sides(
    patches: Patches, space: NDArray[np.int32], divisions: NDArray[np.int64]
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """`Elements.first_cell` and `Elements.cell_side` when the sides with space >= 0 are cut by `divisions`."""
    lit = space >= 0
    counts = np.where(lit, _cells_a_side(patches, divisions)[:, None], 0)
    starts = np.concatenate([[0], np.cumsum(counts.ravel())])
    first_cell = np.where(lit, starts[:-1].reshape(-1, 2), NONE).astype(np.uint32)
    return first_cell, np.repeat(np.arange(2 * len(patches), dtype=np.uint32), counts.ravel())


def _cells_a_side(patches: Patches, divisions: NDArray[np.integer]) -> NDArray[np.int64]:
    nu, nv = divisions.T.astype(np.int64)
    count: NDArray[np.int64] = np.where(patches.is_triangle, nu * nu, nu * nv)
    return count


def join_cells(
    patches: Patches,
    divisions: NDArray[np.uint32],
    first_cell: NDArray[np.uint32],
    cell_side: NDArray[np.uint32],
    side_material: NDArray[np.uint32],
    cell_row: NDArray[np.int64],
) -> Elements:
    """Elements of given cells; arguments as the fields of `Elements`."""
    count = _cells_a_side(patches, divisions)
    order = np.argsort(cell_row, kind="stable")
    n_rows = int(cell_row.max()) + 1 if len(cell_row) else 0
    row_start = np.searchsorted(cell_row[order], np.arange(n_rows + 1)).astype(np.uint32)
    cell_area = (patches.area / count)[cell_side // 2]
    area = np.bincount(cell_row, weights=cell_area, minlength=n_rows).astype(np.float64)
    return Elements(
        divisions=divisions,
        first_cell=first_cell,
        cell_row=cell_row.astype(np.uint32),
        cell_side=cell_side,
        row_start=row_start,
        row_cell=order.astype(np.uint32),
        row_share=_shares(cell_area[order], cell_row[order], area, row_start),
        area=area,
        side_material=side_material,
        row_material=side_material.ravel()[cell_side[order[row_start[:-1]]]] if n_rows else np.zeros(0, np.uint32),
    )


def grid_divisions(patches: Patches, size: float) -> NDArray[np.int64]:
    """Cells along both edges: one, or the even number that comes nearest to `size`.

    A triangle is cut n times each way so that its cells have about the area size², but no edge above twice `size`.
    """
    length_u = np.linalg.norm(patches.edge_u, axis=1)
    length_v = np.linalg.norm(patches.edge_v, axis=1)
    longest = np.maximum(np.maximum(length_u, length_v), np.linalg.norm(patches.edge_v - patches.edge_u, axis=1))
    lengths = np.stack([length_u, length_v], axis=1)
    across = np.maximum(np.sqrt(patches.area), 0.5 * longest)
    lengths[patches.is_triangle] = across[patches.is_triangle, None]
    halves = np.maximum(np.rint(lengths / (2.0 * size)), 1.0)
    cells: NDArray[np.int64] = np.where(lengths <= 1.25 * size, 1, 2 * halves).astype(np.int64)
    return cells


def side_materials(patches: Patches, two_sided: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """(n_patches, 2) material of each side, ``n_materials`` for a black back."""
    back = np.where(two_sided[patches.material], patches.material, len(two_sided))
    material: NDArray[np.uint32] = np.stack([patches.material, back], axis=1).astype(np.uint32)
    return material


def _group_rows(
    patches: Patches,
    space: NDArray[np.int32],
    cell_side: NDArray[np.uint32],
    count: NDArray[np.int64],
    paint: NDArray[np.uint32],
    size: float,
) -> NDArray[np.int64]:
    """(n_cells,) row of each cell: cells of cut patches alone, single cells with others of their kind and place."""
    patch, side = cell_side // 2, cell_side % 2
    single = count[patch] == 1
    normal = patches.normal[patch] * np.where(side == 0, 1.0, -1.0)[:, None]
    cube = np.floor((patches.centroid[patch] - patches.bounds()[0]) / size + 1e-6).astype(np.int64)
    kind = np.column_stack([paint.ravel()[cell_side], space.ravel()[cell_side], direction_class(normal), cube])
    kind[~single] = -1
    kind[~single, 0] = -1 - np.flatnonzero(~single)
    _, first, group = np.unique(kind, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    row: NDArray[np.int64] = rank[group.ravel()]
    return row


def direction_class(normal: NDArray[np.float64]) -> NDArray[np.int64]:
    """Number of the direction's part of a cube map with 3 × 3 parts a face, each less than 45° wide."""
    axis = np.argmax(np.abs(normal) > np.abs(normal).max(axis=1, keepdims=True) - 1e-9, axis=1)
    rows = np.arange(len(normal))
    main = normal[rows, axis]
    others = np.stack([normal[rows, (axis + 1) % 3], normal[rows, (axis + 2) % 3]], axis=1)
    angle = np.arctan2(others, np.abs(main)[:, None])
    third = np.clip(np.floor((angle / (np.pi / 4) + 1.0) * 1.5), 0, 2).astype(np.int64)
    part: NDArray[np.int64] = ((axis * 2 + (main > 0)) * 3 + third[:, 0]) * 3 + third[:, 1]
    return part


def _shares(
    cell_area: NDArray[np.float64],
    cell_row: NDArray[np.int64],
    area: NDArray[np.float64],
    row_start: NDArray[np.uint32],
) -> NDArray[np.float32]:
    """Summed share of each row's area, in row order; the last cell of a row has exactly 1."""
    if not len(cell_area):
        return np.zeros(0, np.float32)
    total = np.cumsum(cell_area)
    before = np.concatenate([[0.0], total])[row_start[:-1]]
    usable = area[cell_row] > 0.0
    share: NDArray[np.float32] = np.divide(
        total - before[cell_row], area[cell_row], out=np.ones_like(total), where=usable
    ).astype(np.float32)
    share[row_start[1:] - 1] = 1.0
    return share
