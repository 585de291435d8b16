"""Where points lie in the cells of the row elements; the order is that of ``cl/include/hr_elements.h``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.hierarchy import NONE, Elements

NO_CELL: Final = -1
"""No cell there: no light reaches that side."""
CELL_CORNERS: Final = np.array([[[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 0], [1, 0], [0, 1], [0, 1]]], np.int64)
"""(2, 4, 2) s and t of the corners of a parallelogram and of a triangle, which repeats its last one."""


@dataclass(frozen=True)
class CellFrames:
    """Every cell as corner + s · extent · (1, 0) + t · extent · (0, 1), in steps of its side's grid.

    A parallelogram cell covers s, t in [0, 1], a triangle s + t <= 1; inverted triangles start at their far corner.

    side : (n_cells,) int64, 2 · patch + side
    corner : (n_cells, 2) int64, in steps of the grid
    extent : (n_cells,) int64, 1, or -1 for an inverted triangle
    is_triangle : (n_cells,) bool
    """

    side: NDArray[np.int64]
    corner: NDArray[np.int64]
    extent: NDArray[np.int64]
    is_triangle: NDArray[np.bool_]


def cell_frames(elements: Elements, is_triangle: NDArray[np.bool_]) -> CellFrames:
    """Place of every cell on the grid of its side.

    Parameters
    ----------
    elements : Elements
    is_triangle : (n_patches,) bool
    """
    side = elements.cell_side.astype(np.int64)
    triangle = is_triangle[side // 2]
    index = np.arange(len(side)) - elements.first_cell.ravel()[side].astype(np.int64)
    n = elements.divisions[side // 2, 0].astype(np.int64)
    corner = np.stack([index % n, index // n], axis=1)
    extent = np.ones(len(side), np.int64)
    from_end = np.where(triangle, n * n - 1 - index, 0)
    root = np.floor(np.sqrt(from_end)).astype(np.int64)
    root -= root * root > from_end
    root += (root + 1) * (root + 1) <= from_end
    position = index - (n * n - (root + 1) ** 2)
    inverted = triangle & (position % 2 == 1)
    corner[triangle] = np.stack([position // 2, n - 1 - root], axis=1)[triangle]
    corner[inverted] += 1
    extent[inverted] = -1
    return CellFrames(side, corner, extent, triangle)


def locate_cells(
    elements: Elements,
    is_triangle: NDArray[np.bool_],
    side: NDArray[np.int64],
    u: NDArray[np.floating],
    v: NDArray[np.floating],
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Cells of points on patch sides, and where in them.

    Parameters
    ----------
    elements : Elements
    is_triangle : (n_patches,) bool
    side : (n,) int64
        2 · patch + side; negative for no point.
    u, v : (n,) float

    Returns
    -------
    cell : (n,) int64, NO_CELL where no light comes
    s, t : (n,) float32
        Coordinates in the cell's frame, see `CellFrames`.
    """
    known = np.maximum(side, 0)
    patch = known // 2
    first = elements.first_cell.ravel()[known].astype(np.int64)
    nu = elements.divisions[patch, 0].astype(np.int64)
    nv = elements.divisions[patch, 1].astype(np.int64)
    fu = np.clip(u * nu.astype(np.float32), 0.0, nu)
    fv = np.clip(v * nv.astype(np.float32), 0.0, nv)
    iu = np.minimum(fu.astype(np.int64), nu - 1)
    iv = np.minimum(fv.astype(np.int64), nv - 1)
    index = iu + nu * iv
    triangle = is_triangle[patch]
    if triangle.any():
        iu[triangle] = np.minimum(iu, nu - 1 - iv)[triangle]
    s = np.clip(fu - iu, 0.0, 1.0).astype(np.float32)
    t = np.clip(fv - iv, 0.0, 1.0).astype(np.float32)
    if triangle.any():
        left = nu - iv
        inverted = triangle & (iu + 1 < left) & (s + t > 1.0)
        index[triangle] = (nu * nu - left * left + 2 * iu + inverted)[triangle]
        s[inverted] = 1.0 - s[inverted]
        t[inverted] = 1.0 - t[inverted]
        over = triangle & (s + t > 1.0)
        t[over] = 1.0 - s[over]
    nowhere = (side < 0) | (first == NONE)
    return np.where(nowhere, NO_CELL, first + index), s, t
