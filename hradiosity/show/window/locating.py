"""Which cell a point lies in, and values there."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells
from hradiosity.show.window.marks import scene_size

_IN_PLANE: Final = 1e-4
"""How far a point may lie from the plane of a cell, over the size of the scene."""


class Located(NamedTuple):
    """cell : (m,) int64, −1 for none; s, t : (m,) along the first and the last edge of the cell, 0 to 1."""

    cell: NDArray[np.int64]
    s: NDArray[np.float64]
    t: NDArray[np.float64]

    def of(self, rows: NDArray[np.int64]) -> Located:
        """Of some of the points."""
        return Located(self.cell[rows], self.s[rows], self.t[rows])


def locate(
    cells: Cells,
    kind: NDArray[np.int64],
    points: NDArray[np.float64],
    of_kind: NDArray[np.int64],
    candidates: int,
    margin: float = 0.0,
) -> Located:
    """The cell of a kind that each point lies in.

    Parameters
    ----------
    cells : Cells
    kind : (n,) int64, of each cell
    points : (m, 3) float64 [m]
    of_kind : (m,) int64, kind that is looked for
    candidates : int
        Cells with the nearest middles are tried; those of long cells lie farther.
    margin : float
        How far beside a cell still counts, over its edges.
    """
    from scipy.spatial import cKDTree

    size = scene_size(cells)
    far = 10.0 * size
    first = cells.first_corner
    edge_u = cells.corners[:, 1] - first
    edge_v = cells.corners[np.arange(len(cells)), np.where(cells.is_triangle, 2, 3)] - first
    share = np.where(cells.is_triangle, 1.0 / 3.0, 0.5)[:, None]
    tree = cKDTree(np.column_stack([first + share * (edge_u + edge_v), far * kind]))
    k = min(candidates, len(cells))
    near = tree.query(np.column_stack([points, far * of_kind]), k)[1].reshape(len(points), k)
    uu, uv, vv = (np.einsum("nk,nk->n", a, b) for a, b in ((edge_u, edge_u), (edge_u, edge_v), (edge_v, edge_v)))
    determinant = np.maximum(uu * vv - uv * uv, 1e-300)
    found, s_found, t_found = np.full(len(points), -1), np.zeros(len(points)), np.zeros(len(points))
    for candidate in near.T:
        offset = points - first[candidate]
        u = np.einsum("nk,nk->n", offset, edge_u[candidate])
        v = np.einsum("nk,nk->n", offset, edge_v[candidate])
        s = (u * vv[candidate] - v * uv[candidate]) / determinant[candidate]
        t = (v * uu[candidate] - u * uv[candidate]) / determinant[candidate]
        low, high = -margin, 1.0 + margin
        beyond = np.where(cells.is_triangle[candidate], s + t > high, (s > high) | (t > high))
        level = np.abs(np.einsum("nk,nk->n", offset, cells.normal[candidate])) <= _IN_PLANE * size
        fits = (s >= low) & (t >= low) & ~beyond & level & (found < 0) & (kind[candidate] == of_kind)
        found[fits], s_found[fits], t_found[fits] = candidate[fits], s[fits], t[fits]
    return Located(found, s_found, t_found)


def values_inside(cells: Cells, at_corner: NDArray[np.float64], place: Located) -> NDArray[np.float64]:
    """(m, c) values (n, 4, c) of corners inside of cells: bilinear, or barycentric in triangles."""
    cell, s, t = place
    triangle = cells.is_triangle[cell]
    weights = np.where(
        triangle[:, None],
        np.stack([1.0 - s - t, s, t, np.zeros_like(s)], axis=1),
        np.stack([(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t], axis=1),
    )
    values: NDArray[np.float64] = np.einsum("mk,mkc->mc", weights, at_corner[cell])
    return values


def middles(cells: Cells) -> tuple[NDArray[np.float64], Located]:
    """(n, 3) middle of each cell [m], and where it lies in its own cell."""
    inside = np.where(cells.is_triangle, 1.0 / 3.0, 0.5)
    own = Located(np.arange(len(cells)), inside, inside)
    return values_inside(cells, cells.corners, own), own
