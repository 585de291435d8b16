"""Corners of the cells that patches are cut into; the order is that of ``cl/include/hr_elements.h``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.hierarchy import Elements


def cell_corners(patches: Patches, elements: Elements) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Corners of every cell, counter-clockwise seen from the side that the cell lies on.

    Returns
    -------
    corners : (n_cells, 4, 3) float64 [m]
        A triangle repeats its last corner.
    is_triangle : (n_cells,) bool
    """
    patch = (elements.cell_side // 2).astype(np.int64)
    first = elements.first_cell.ravel()[elements.cell_side].astype(np.int64)
    index = np.arange(len(patch)) - first
    divisions = elements.divisions[patch].astype(np.int64)
    is_triangle = patches.is_triangle[patch]
    grid = np.where(is_triangle[:, None, None], _of_triangle(index, divisions), _of_parallelogram(index, divisions))
    share = grid / divisions[:, None, :]
    corners = (
        patches.origin[patch][:, None, :]
        + share[:, :, 0:1] * patches.edge_u[patch][:, None, :]
        + share[:, :, 1:2] * patches.edge_v[patch][:, None, :]
    )
    return np.where((elements.cell_side % 2 == 1)[:, None, None], _reversed(corners, is_triangle), corners), is_triangle


def _of_parallelogram(index: NDArray[np.int64], divisions: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n, 4, 2) corners in steps of the grid, index iu + nu·iv."""
    low = np.stack([index % divisions[:, 0], index // divisions[:, 0]], axis=1)
    corners: NDArray[np.int64] = low[:, None, :] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    return corners


def _of_triangle(index: NDArray[np.int64], divisions: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n, 4, 2) corners in steps of the grid: rows of n, n − 1, … upright cells with inverted ones between them."""
    n = divisions[:, 0]
    from_end = np.maximum(n * n - 1 - index, 0)
    root = np.floor(np.sqrt(from_end)).astype(np.int64)
    root -= root * root > from_end
    root += (root + 1) * (root + 1) <= from_end
    position = index - (n * n - (root + 1) ** 2)
    low = np.stack([position // 2, n - 1 - root], axis=1)
    upright = np.array([[0, 0], [1, 0], [0, 1], [0, 1]])
    inverted = np.array([[1, 0], [1, 1], [0, 1], [0, 1]])
    return low[:, None, :] + np.where((position % 2 == 1)[:, None, None], inverted, upright)


def _reversed(corners: NDArray[np.float64], is_triangle: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The same corners the other way round; a triangle still repeats its last one."""
    return np.where(is_triangle[:, None, None], corners[:, [2, 1, 0, 0]], corners[:, ::-1])
