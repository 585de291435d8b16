"""Light across seams of smooth shading: where patches of one flat surface meet without sharing their corners.

What `hradiosity.show.seams` does for pictures with rays, here among the cells alone.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Light
from hradiosity.show.window.locating import locate, values_inside
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.outlines import edge_flags
from hradiosity.show.window.vertices import surface_kinds

REACH: Final = 2.0**-15
"""How far a neighbour is looked for beyond an outline, over the size of the scene."""
_SHIFT: Final = 1e-3
"""Share of an edge by which its ends are moved inwards, so that they lie beside one neighbour only."""
_CANDIDATES: Final = 8
"""Cells with the nearest middles among which the neighbour is looked for; a seam beside a longer one is left."""
_WHOLE: Final = 40
"""Level of the hierarchy above all: outlines of patches."""


def level_seams(
    cells: Cells, light: Light, vertex: NDArray[np.int64], at_corner: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The same values (n, 4, c), each on an outline averaged with what the surface beyond the outline has there."""
    cell, corner = np.nonzero(edge_flags(cells, _WHOLE))
    if not len(cell):
        return at_corner
    following = np.where(cells.is_triangle[cell] & (corner == 2), 0, (corner + 1) % 4)
    start, end = cells.corners[cell, corner], cells.corners[cell, following]
    along = end - start
    outward = np.cross(along, cells.normal[cell])
    outward *= REACH * scene_size(cells) / np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-300)
    points = np.concatenate([start + _SHIFT * along, end - _SHIFT * along]) + np.tile(outward, (2, 1))
    kind = surface_kinds(cells, light)
    found = locate(cells, kind, points, kind[np.tile(cell, 2)], _CANDIDATES)
    own = np.concatenate([vertex[cell, corner], vertex[cell, following]])
    met = np.flatnonzero(found.cell >= 0)
    met = met[light.exposed[cells.element[found.cell[met]]] > 0.0]
    values = values_inside(cells, at_corner, found.of(met))
    n = int(vertex.max(initial=-1)) + 1
    count = 1.0 + np.bincount(own[met], minlength=n)
    mean = np.zeros((n, at_corner.shape[2]))
    mean[vertex.ravel()] = at_corner.reshape(-1, at_corner.shape[2])
    sums = np.stack([np.bincount(own[met], column, n) for column in values.T], axis=1)
    levelled: NDArray[np.float64] = ((mean + sums) / count[:, None])[vertex]
    return levelled
