"""Elements of twice the size, merged from those that there are: what their light differs by tells what smaller ones
would still change.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.hierarchy import Elements, direction_class
from hradiosity.space.row_squares import row_squares


def coarser_rows(
    patches: Patches, elements: Elements, space: NDArray[np.int32], paint: NDArray[np.uint32], size: float
) -> NDArray[np.int64]:
    """Which coarser element each row element becomes part of.

    Squares of cells of a cut side merge by fours with those of their size. Rows of uncut faces merge with those of the
    same kind in the same cube of edge 2h, as such faces were grouped in cubes of edge h.

    Parameters
    ----------
    patches : Patches
    elements : Elements
    space : (n_rows,) int32
        That each element looks into.
    paint : (n_patches, 2) uint32
        Rows are merged only where this is the same.
    size : float
        Edge length h of the elements [m].

    Returns
    -------
    (n_rows,) int64
        Numbers from 0 without gaps.
    """
    merges, coarser = row_squares(patches, elements).coarser(patches.is_triangle)
    key = np.zeros((len(elements), 6), np.int64)
    key[merges, : coarser.shape[1]] = coarser[merges]
    key[merges, 0] = -1 - coarser[merges, 0]
    rest = np.flatnonzero(~merges)
    if len(rest):
        key[rest] = _kind_and_place(patches, elements, space, paint, size)[rest]
    parent: NDArray[np.int64] = np.unique(key, axis=0, return_inverse=True)[1].ravel().astype(np.int64)
    return parent


def _kind_and_place(
    patches: Patches, elements: Elements, space: NDArray[np.int32], paint: NDArray[np.uint32], size: float
) -> NDArray[np.int64]:
    """(n_rows, 6) paint, space, direction and cube of edge 2h of each row's faces, weighted by area."""
    cell = elements.row_cell.astype(np.int64)
    side = elements.cell_side[cell].astype(np.int64)
    patch = side // 2
    row = elements.cell_row[cell]
    area = patches.area[patch]
    normal = patches.normal[patch] * np.where(side % 2 == 0, 1.0, -1.0)[:, None]
    first = side[elements.row_start[:-1].astype(np.int64)]

    def mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
        sums = np.stack([np.bincount(row, area * values[:, k], len(elements)) for k in range(3)], axis=1)
        return sums / np.bincount(row, area, len(elements))[:, None]

    cube = np.floor((mean(patches.centroid[patch]) - patches.bounds()[0]) / (2.0 * size) + 1e-6).astype(np.int64)
    return np.column_stack([paint.ravel()[first], space, direction_class(mean(normal)), cube])
