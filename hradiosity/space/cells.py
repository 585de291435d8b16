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
    patch = frames.side // 2
    share = grid / elements.divisions[patch][:, None, :]
    corners = (
        patches.origin[patch][:, None, :]
        + share[:, :, 0:1] * patches.edge_u[patch][:, None, :]
        + share[:, :, 1:2] * patches.edge_v[patch][:, None, :]
    )
    on_back = (frames.side % 2 == 1)[:, None, None]
    reversed_ = np.where(frames.is_triangle[:, None, None], corners[:, [2, 1, 0, 0]], corners[:, ::-1])
    return np.where(on_back, reversed_, corners), frames.is_triangle
