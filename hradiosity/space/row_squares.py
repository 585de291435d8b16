"""Row elements of unlike sizes: squares of cells on one side's grid, split by fours where light asks for it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.cell_lookup import CellFrames, cell_frames
from hradiosity.space.hierarchy import NONE, Elements, cut_sides, join_cells


@dataclass(frozen=True)
class RowSquares:
    """Where row elements lie that are one square of cells, or one triangle, on a single side.

    single : (n_rows,) bool, the others are groups of faces, and nothing else is known of them
    side : (n_rows,) int64, 2 · patch + side
    grid : (n_rows, 2) int64, squares of that size along both edges of the patch
    place : (n_rows, 2) int64, number of the square on that grid; of a triangle's, its number and 0
    """

    single: NDArray[np.bool_]
    side: NDArray[np.int64]
    grid: NDArray[np.int64]
    place: NDArray[np.int64]

    def middles(self, patches: Patches) -> NDArray[np.float64]:
        """(n_rows, 3) middle of each square, of a group that of its first cell [m]."""
        uv = (self.place + 0.5) / self.grid
        patch = self.side // 2
        triangle = patches.is_triangle[patch]
        uv[triangle] = np.column_stack(_triangle_centre(self.grid[triangle, 0], self.place[triangle, 0]))
        middle: NDArray[np.float64] = (
            patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
        )
        return middle

    def coarser(self, is_triangle: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Whether each row has a square of twice its size to merge into, and which: (n_rows, 4) integers.

        Parameters
        ----------
        is_triangle : (n_patches,) bool
        """
        merges = self.single & (self.grid.max(axis=1, initial=1) > 1)
        place = self.place // 2
        triangle = np.flatnonzero(merges & is_triangle[self.side // 2])
        n = self.grid[triangle, 0]
        place[triangle, 0] = _triangle_number(n // 2, *_triangle_centre(n, self.place[triangle, 0]))
        place[triangle, 1] = 0
        return merges, np.column_stack([self.side, self.grid[:, 0], place])


def row_squares(patches: Patches, elements: Elements) -> RowSquares:
    """The square of cells that each row element is."""
    first = elements.row_cell[elements.row_start[:-1].astype(np.int64)].astype(np.int64)
    last = elements.row_cell[elements.row_start[1:].astype(np.int64) - 1]
    side = elements.cell_side[first].astype(np.int64)
    count = np.diff(elements.row_start.astype(np.int64))
    single = elements.cell_side[last] == side
    width = np.where(single, np.rint(np.sqrt(count)), 1).astype(np.int64)
    grid = elements.divisions[side // 2].astype(np.int64) // width[:, None]
    centre = _cell_centres(cell_frames(elements, patches.is_triangle), elements)[first]
    triangle = patches.is_triangle[side // 2]
    place = np.floor(centre * grid).astype(np.int64)
    place[triangle, 0] = _triangle_number(grid[triangle, 0], *centre[triangle].T)
    place[triangle, 1] = 0
    return RowSquares(single, side, grid, place)


def split_rows(patches: Patches, elements: Elements, chosen: NDArray[np.int64]) -> Elements:
    """Each chosen row that is a square in four, on a grid of twice the cells where that needs smaller ones.

    Parameters
    ----------
    patches : Patches
    elements : Elements
    chosen : (n,) int64
        Row elements; groups of faces stay whole.
    """
    return _split(patches, elements, chosen)[0]


def quarters_of(patches: Patches, elements: Elements, chosen: NDArray[np.int64]) -> tuple[Elements, NDArray[np.int64]]:
    """The quarters of some rows alone, whose rays meet the rows as they are.

    Parameters
    ----------
    patches : Patches
    elements : Elements
    chosen : (n,) int64
        Row elements that are squares.

    Returns
    -------
    quarters : Elements
        For tracing only: ``cell_row`` gives rows of `elements`, all else is of the quarters.
    parent : (4 n,) int64
        Row of `elements` that each is a part of; the quarters of one row follow one another.
    """
    made, parent = _split(patches, elements, chosen)
    is_part = np.isin(parent, chosen)
    cells = is_part[made.cell_row[made.row_cell]]
    count = np.diff(made.row_start.astype(np.int64))[is_part]
    quarters = replace(
        made,
        cell_row=parent[made.cell_row].astype(np.uint32),
        row_start=np.concatenate([[0], np.cumsum(count)]).astype(np.uint32),
        row_cell=made.row_cell[cells],
        row_share=made.row_share[cells],
        area=made.area[is_part],
        row_material=made.row_material[is_part],
    )
    return quarters, parent[is_part]


def cells_after(patches: Patches, elements: Elements, chosen: NDArray[np.int64]) -> int:
    """Cells of the elements that `split_rows` would make."""
    squares = row_squares(patches, elements)
    doubled = _doubled(patches, elements, squares, chosen[squares.single[chosen]])
    return int(np.where(doubled[elements.cell_side // 2], 4, 1).sum())


def _doubled(patches: Patches, elements: Elements, squares: RowSquares, split: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(n_patches,) whether the patch needs a grid of twice the cells along each edge when rows are split."""
    patch = squares.side[split] // 2
    doubled = np.zeros(len(patches), bool)
    doubled[patch[(squares.grid[split] == elements.divisions[patch]).all(axis=1)]] = True
    return doubled


def _split(patches: Patches, elements: Elements, chosen: NDArray[np.int64]) -> tuple[Elements, NDArray[np.int64]]:
    """The elements with some rows in four, and the old row (n_rows,) that each new one is, or is a part of."""
    squares = row_squares(patches, elements)
    split = np.zeros(len(elements), bool)
    split[chosen] = squares.single[chosen]
    doubled = _doubled(patches, elements, squares, np.flatnonzero(split))
    divisions = elements.divisions.astype(np.int64) * np.where(doubled, 2, 1)[:, None]
    lit = np.where(elements.first_cell != NONE, 0, -1).astype(np.int32)
    first_cell, cell_side = cut_sides(patches, lit, divisions)
    finer = replace(elements, divisions=divisions.astype(np.uint32), first_cell=first_cell, cell_side=cell_side)
    centre = _cell_centres(cell_frames(finer, patches.is_triangle), finer)
    side = cell_side.astype(np.int64)
    in_triangle = patches.is_triangle[side // 2]
    old_cell = _number(elements.divisions[side // 2].astype(np.int64), centre, in_triangle)
    old_row = elements.cell_row[elements.first_cell.ravel()[side].astype(np.int64) + old_cell].astype(np.int64)
    quarter = np.zeros(len(side), np.int64)
    inside = np.flatnonzero(split[old_row])
    quarter[inside] = _number(2 * squares.grid[old_row[inside]], centre[inside], in_triangle[inside])
    most = int(quarter.max(initial=0)) + 1
    _, first, cell_row = np.unique(old_row * most + quarter, return_index=True, return_inverse=True)
    made = join_cells(patches, finer.divisions, first_cell, cell_side, elements.side_material, cell_row.ravel())
    return made, old_row[first]


def _cell_centres(frames: CellFrames, elements: Elements) -> NDArray[np.float64]:
    """(n_cells, 2) u and v of the middle of each cell."""
    middle = frames.extent * np.where(frames.is_triangle, 1.0 / 3.0, 0.5)
    return (frames.corner + middle[:, None]) / elements.divisions[frames.side // 2]


def _number(grid: NDArray[np.int64], uv: NDArray[np.float64], is_triangle: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(n,) number of the square of a grid that points lie in, as cells are numbered."""
    place = np.floor(uv * grid).astype(np.int64)
    number = place[:, 0] + grid[:, 0] * place[:, 1]
    number[is_triangle] = _triangle_number(grid[is_triangle, 0], *uv[is_triangle].T)
    return np.asarray(number)


def _triangle_number(n: NDArray[np.int64], u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.int64]:
    """(m,) number of the triangle at points of triangles that are cut n times each way."""
    a, b = np.floor(u * n).astype(np.int64), np.floor(v * n).astype(np.int64)
    left = n - b
    inverted = (u * n - a) + (v * n - b) > 1.0
    return np.asarray(n * n - left * left + 2 * a + inverted)


def _triangle_centre(
    n: NDArray[np.int64], number: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coordinates u and v of the middle of triangles, the reverse of `_triangle_number`."""
    left = np.ceil(np.sqrt(n * n - number)).astype(np.int64)
    left += left * left < n * n - number
    left -= (left - 1) ** 2 >= n * n - number
    position = number - (n * n - left * left)
    inverted = position % 2
    third = (1.0 + inverted) / 3.0
    return (position // 2 + third) / n, (n - left + third) / n
