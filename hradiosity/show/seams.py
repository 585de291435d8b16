"""Light across seams: where patches of one flat surface meet without sharing their vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK
from hradiosity.show.light import PictureScene, RowLight
from hradiosity.show.shading import indirect_at
from hradiosity.space.bvh import Bvh
from hradiosity.space.cell_lookup import CELL_CORNERS, locate_cells
from hradiosity.space.leaf_fan import EDGE_ENDS
from hradiosity.space.leaf_vertices import FLAT
from hradiosity.space.visibility import trace_closest

REACH = 2.0**-14
"""How far a neighbour is looked for beyond an edge, relative to the scene's half extent."""
_SHIFT = 1e-3
"""Share of a cell's edge by which its ends are moved inwards, so that they lie beside one neighbour only."""


@dataclass(frozen=True)
class _Rim:
    """Ends of the edges of cells that lie on the outline of their patch, each a little inside its edge.

    vertex : (n,) int32
    side : (n,) int64
    point : (n, 3) float64 [m]
    outward : (n, 3) float64, unit, in the plane of the side and square to the edge
    """

    vertex: NDArray[np.int32]
    side: NDArray[np.int64]
    point: NDArray[np.float64]
    outward: NDArray[np.float64]


def level_seams(picture: PictureScene, bvh: Bvh, rows: RowLight, exposed: NDArray[np.float64]) -> RowLight:
    """The same light, each vertex on an outline averaged with what the surface beyond the outline has there.

    A short ray finds the side beyond: one that lies in the same plane and belongs to the same object, material and
    space. Where both have the same vertices nothing changes, since they share them already. Elements of which solids
    leave nothing `exposed` (n_rows,) have no light and would darken the line at which a surface is cut there.
    """
    rim = _rims(picture, rows)
    patches = picture.scene.patches
    reach = REACH * bvh.scale
    normal = patches.normal[rim.side // 2] * np.where(rim.side % 2 == BACK, -1.0, 1.0)[:, None]
    beyond = rim.point + reach * rim.outward
    hits = trace_closest(bvh, beyond + reach * normal, -normal, 2.0 * reach)
    found = np.maximum(hits.patch, 0).astype(np.int64)
    side = 2 * found + hits.side
    facing = patches.normal[found] * np.where(hits.side == BACK, -1.0, 1.0)[:, None]
    same = (hits.patch >= 0) & (np.einsum("ij,ij->i", facing, normal) > 1.0 - FLAT)
    same &= picture.label.ravel()[side] == picture.label.ravel()[rim.side]
    cell, s, t = locate_cells(picture.elements, patches.is_triangle, np.where(same, side, -1), hits.u, hits.v)
    has_light = exposed > 0.0
    met = np.flatnonzero((cell >= 0) & has_light[picture.elements.cell_row[np.maximum(cell, 0)]])
    values = indirect_at(picture, rows, cell[met], s[met], t[met])
    vertex = rim.vertex[met]
    count = 1.0 + np.bincount(vertex, minlength=len(rows.at_vertex))
    sums = [np.bincount(vertex, channel, len(rows.at_vertex)) for channel in values.T]
    mean = (rows.at_vertex + np.stack(sums, axis=1)) / count[:, None]
    return RowLight(rows.direct, rows.indirect, rows.vertex, mean.astype(np.float32))


def _rims(picture: PictureScene, rows: RowLight) -> _Rim:
    """Both ends of each cell edge on an outline."""
    frames, patches = picture.frames, picture.scene.patches
    low, upright = frames.corner, frames.extent > 0
    grid = picture.grid[frames.side // 2]
    touches = np.stack(
        [
            low[:, 1] == 0,
            np.where(frames.is_triangle, low.sum(axis=1) + 1 == grid[:, 0], low[:, 0] + 1 == grid[:, 0]),
            np.where(frames.is_triangle, low[:, 0] == 0, low[:, 1] + 1 == grid[:, 1]),
            ~frames.is_triangle & (low[:, 0] == 0),
        ],
        axis=1,
    )
    cell, edge = np.nonzero(touches & upright[:, None])
    kind = frames.is_triangle[cell].astype(np.int64)
    ends = EDGE_ENDS[kind, edge]
    patch = frames.side[cell] // 2
    share = (low[cell, None, :] + CELL_CORNERS[kind[:, None], ends]) / grid[cell, None, :]
    first, last = (
        patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
        for uv in (share[:, 0], share[:, 1])
    )
    along = last - first
    outward = np.cross(along, patches.normal[patch])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return _Rim(
        vertex=rows.vertex[cell[:, None], ends].T.ravel(),
        side=np.tile(frames.side[cell], 2),
        point=np.concatenate([first + _SHIFT * along, last - _SHIFT * along]),
        outward=np.tile(outward, (2, 1)),
    )
