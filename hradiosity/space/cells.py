"""Corners of the cells that patches are cut into, in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.cell_lookup import CELL_CORNERS, cell_frames
from hradiosity.space.hierarchy import Elements


def cell_corners(patches: Patches, elements: Elements) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Corners of every cell, counter-clockwise seen from the side that the cell lies on.

    Returns
    -------
    corners : (n_cells, 4, 3) float64 [m]
        A triangle repeats its last corner.
    is_triangle : (n_cells,) bool
    """
    frames = cell_frames(elements, patches.is_triangle)
    offset = CELL_CORNERS[frames.is_triangle.astype(np.int64)]
    grid = frames.corner[:, None, :] + frames.extent[:, None, None] * offset
    share = grid / elements.divisions[frames.side // 2][:, None, :]
    return place_corners(patches, frames.side, frames.is_triangle, share), frames.is_triangle


def place_corners(
    patches: Patches, side: NDArray[np.int64], is_triangle: NDArray[np.bool_], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, 4, 3) corners in space [m], counter-clockwise seen from the side that they lie on.

    Parameters
    ----------
    patches : Patches
    side : (n,) int64, 2 · patch + side
    is_triangle : (n,) bool
    share : (n, 4, 2) float64
        (u, v) of the corners on the patch, counter-clockwise seen from its front; a triangle repeats its last one.
    """
    patch = side // 2
    corners = (
        patches.origin[patch][:, None, :]
        + share[:, :, 0:1] * patches.edge_u[patch][:, None, :]
        + share[:, :, 1:2] * patches.edge_v[patch][:, None, :]
    )
    on_back = (side % 2 == 1)[:, None, None]
    reversed_ = np.where(is_triangle[:, None, None], corners[:, [2, 1, 0, 0]], corners[:, ::-1])
    placed: NDArray[np.float64] = np.where(on_back, reversed_, corners)
    return placed
