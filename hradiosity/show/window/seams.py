"""Light across seams of smooth shading: where patches of one flat surface meet without sharing their corners.

What `hradiosity.show.seams` does for pictures with rays, here among the cells alone.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Light
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
    found, s, t = _locate(cells, surface_kinds(cells, light), points, np.tile(cell, 2))
    own = np.concatenate([vertex[cell, corner], vertex[cell, following]])
    met = np.flatnonzero(found >= 0)
    met = met[light.exposed[cells.element[found[met]]] > 0.0]
    values = _inside(cells, at_corner, found[met], s[met], t[met])
    n = int(vertex.max(initial=-1)) + 1
    count = 1.0 + np.bincount(own[met], minlength=n)
    mean = np.zeros((n, at_corner.shape[2]))
    mean[vertex.ravel()] = at_corner.reshape(-1, at_corner.shape[2])
    sums = np.stack([np.bincount(own[met], column, n) for column in values.T], axis=1)
    levelled: NDArray[np.float64] = ((mean + sums) / count[:, None])[vertex]
    return levelled


def _locate(
    cells: Cells, kind: NDArray[np.int64], points: NDArray[np.float64], of_cell: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Cell of the same kind that each point (m, 3) lies in, −1 for none, and where in it."""
    from scipy.spatial import cKDTree

    far = 10.0 * scene_size(cells)
    first = cells.corners[:, 0]
    edge_u = cells.corners[:, 1] - first
    edge_v = cells.corners[np.arange(len(cells)), np.where(cells.is_triangle, 2, 3)] - first
    share = np.where(cells.is_triangle, 1.0 / 3.0, 0.5)[:, None]
    tree = cKDTree(np.column_stack([first + share * (edge_u + edge_v), far * kind]))
    k = min(_CANDIDATES, len(cells))
    near = tree.query(np.column_stack([points, far * kind[of_cell]]), k)[1].reshape(len(points), k)
    uu, uv, vv = (np.einsum("nk,nk->n", a, b) for a, b in ((edge_u, edge_u), (edge_u, edge_v), (edge_v, edge_v)))
    determinant = np.maximum(uu * vv - uv * uv, 1e-300)
    found, s_found, t_found = np.full(len(points), -1), np.zeros(len(points)), np.zeros(len(points))
    for candidate in near.T:
        offset = points - first[candidate]
        u = np.einsum("nk,nk->n", offset, edge_u[candidate])
        v = np.einsum("nk,nk->n", offset, edge_v[candidate])
        s = (u * vv[candidate] - v * uv[candidate]) / determinant[candidate]
        t = (v * uu[candidate] - u * uv[candidate]) / determinant[candidate]
        inside = (s >= 0.0) & (t >= 0.0) & np.where(cells.is_triangle[candidate], s + t <= 1.0, (s <= 1.0) & (t <= 1.0))
        fits = inside & (found < 0) & (kind[candidate] == kind[of_cell])
        found[fits], s_found[fits], t_found[fits] = candidate[fits], s[fits], t[fits]
    return found, s_found, t_found


def _inside(
    cells: Cells,
    at_corner: NDArray[np.float64],
    cell: NDArray[np.int64],
    s: NDArray[np.float64],
    t: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(m, c) values inside of cells: bilinear, or barycentric in triangles."""
    triangle = cells.is_triangle[cell]
    weights = np.where(
        triangle[:, None],
        np.stack([1.0 - s - t, s, t, np.zeros_like(s)], axis=1),
        np.stack([(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t], axis=1),
    )
    values: NDArray[np.float64] = np.einsum("mk,mkc->mc", weights, at_corner[cell])
    return values
