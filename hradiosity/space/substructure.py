"""Patches that shoot and the elements below them that receive (Cohen, Greenberg, Immel & Brock 1986).

Each lit side is cut into a grid of cells, the patches, and into two finer grids below it. A row element is a cell of
any of the three grids; a patch whose light varies strongly is replaced by its four parts, and those by theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.cell_lookup import cell_frames, locate_cells
from hradiosity.space.hierarchy import Elements, cut_sides, grid_divisions, join_cells, side_materials
from hradiosity.space.slots import with_slots

SPLITS: Final = 2
"""Times that a patch may be halved along both edges."""
LEAST_SIZE: Final = 0.5
"""Patches with no edge longer than this, in element sizes, are not split."""


@dataclass(frozen=True)
class Substructure:
    """Three nested grids of cells.

    levels : coarse to fine, one element a cell
    ancestor : (SPLITS + 1, n_finest) int64, the cell of each level that a finest cell is a part of
    """

    levels: tuple[Elements, ...]
    ancestor: NDArray[np.int64]

    @property
    def finest(self) -> Elements:
        """The grid with the smallest cells."""
        return self.levels[-1]

    def means(self, values: NDArray[np.float64], level: int) -> NDArray[np.float64]:
        """Values of the finest cells, averaged over the cells of a level; parts of a cell have equal areas."""
        n = len(self.levels[level])
        total = np.bincount(self.ancestor[level], weights=values, minlength=n)
        mean: NDArray[np.float64] = total / np.maximum(np.bincount(self.ancestor[level], minlength=n), 1)
        return mean

    def spread(self, values: NDArray[np.float64], level: int) -> NDArray[np.float64]:
        """Largest less smallest mean over the parts of each cell of a level."""
        parts = self.means(values, level + 1)[self.ancestor[level + 1]]
        n = len(self.levels[level])
        low, high = np.full(n, np.inf), np.full(n, -np.inf)
        np.minimum.at(low, self.ancestor[level], parts)
        np.maximum.at(high, self.ancestor[level], parts)
        difference: NDArray[np.float64] = high - low
        return difference

    def rows(self, patches: Patches, split: Sequence[NDArray[np.bool_]]) -> tuple[Elements, NDArray[np.int64]]:
        """Row elements when some cells are split.

        Parameters
        ----------
        patches : Patches
        split : for each level but the last, (n_cells of that level,) bool

        Returns
        -------
        elements : Elements
            Cells of the finest grid, joined to rows.
        patch : (n_rows,) int64
            Cell of the coarsest level that each row is a part of.
        """
        level = np.zeros(self.ancestor.shape[1], np.int64)
        for k, which in enumerate(split):
            level += (level == k) & which[self.ancestor[k]]
        cell = np.take_along_axis(self.ancestor, level[None], axis=0)[0]
        _, first, row = np.unique(np.column_stack([level, cell]), axis=0, return_index=True, return_inverse=True)
        fine = self.finest
        elements = join_cells(
            patches, fine.divisions, fine.first_cell, fine.cell_side, fine.side_material, row.ravel().astype(np.int64)
        )
        return elements, self.ancestor[0][first]


def cut_substructure(
    patches: Patches,
    space: NDArray[np.int32],
    two_sided: NDArray[np.bool_],
    size: float,
    slots: NDArray[np.int64] | None = None,
) -> Substructure:
    """Cut the lit sides into patches of about `size` and the finer cells below them.

    Parameters
    ----------
    patches : Patches
    space : (n_patches, 2) int32
        Space that each side looks into, negative where no light comes.
    two_sided : (n_materials,) bool
    size : float
        Wanted edge of a patch [m].
    slots : (n_patches, 2) int64, optional
        Cells that walls of slots should have along both edges, see `hradiosity.space.slots`.
    """
    coarse = grid_divisions(patches, size)
    if slots is not None and slots.any():
        coarse = with_slots(patches, (space >= 0).sum(axis=1), coarse, slots)
    long_u, long_v = (np.linalg.norm(edge, axis=1) for edge in (patches.edge_u, patches.edge_v))
    longest = np.maximum(long_u, long_v)
    lengths = np.where(patches.is_triangle[:, None], longest[:, None], np.column_stack([long_u, long_v]))
    splits = np.where(lengths > LEAST_SIZE * size, SPLITS, 0)
    material = side_materials(patches, two_sided)
    levels = tuple(
        _one_row_a_cell(patches, space, coarse << np.minimum(splits, level), material) for level in range(SPLITS + 1)
    )
    frames = cell_frames(levels[-1], patches.is_triangle)
    centre = np.where(frames.is_triangle, 1.0 / 3.0, 0.5)[:, None] * frames.extent[:, None]
    uv = (frames.corner + centre) / levels[-1].divisions[frames.side // 2]
    ancestor = [locate_cells(grid, patches.is_triangle, frames.side, uv[:, 0], uv[:, 1])[0] for grid in levels]
    return Substructure(levels, np.stack(ancestor))


def _one_row_a_cell(
    patches: Patches, space: NDArray[np.int32], divisions: NDArray[np.int64], material: NDArray[np.uint32]
) -> Elements:
    first_cell, cell_side = cut_sides(patches, space, divisions)
    row = np.arange(len(cell_side), dtype=np.int64)
    return join_cells(patches, divisions.astype(np.uint32), first_cell, cell_side, material, row)
