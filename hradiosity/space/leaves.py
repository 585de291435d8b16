"""Leaves: how cells are cut further where the direct light changes quickly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.cell_lookup import CellFrames

NONE: Final = -1
"""No node, no child."""
UNIT: Final = 6
"""Steps along the edge of a leaf of the highest level: middles of edges and centres are whole steps."""
N_PLACES: Final = 9
"""Points of a leaf that light is known at: four corners, the centre, the middles of four edges."""
CENTRE: Final = 4
PLACES: Final = np.array(
    [
        [[0, 0], [6, 0], [6, 6], [0, 6], [3, 3], [3, 0], [6, 3], [3, 6], [0, 3]],
        [[0, 0], [6, 0], [0, 6], [0, 6], [2, 2], [3, 0], [3, 3], [0, 3], [0, 3]],
    ],
    np.int64,
)
"""(2, 9, 2) sixths of the extent along s and t, of parallelograms and of triangles: corner, corner, corner, corner,
centre, and the middle of the edge from each corner to the next. A triangle repeats its last corner and edge."""
_CHILDREN: Final = np.array(
    [[[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], [[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, -1]]], np.int64
)
"""(2, 4, 3): corner of each child in halves of the extent, and sign of its extent."""


@dataclass(frozen=True)
class Leaves:
    """Quadtrees below cells: a node covers corner + (s, t) · extent, and a leaf is a node without children.

    A parallelogram covers s, t in [0, 1], a triangle s + t <= 1; inverted triangles have a negative extent. Steps
    are ``1 / (step · divisions)`` of the patch's edges, so that corners are exact.

    frames : CellFrames
    step : steps along a cell's edge, 6 · 2^(highest level)
    root : (n_cells,) int32, the node that is the whole cell, NONE for a cell without leaves
    cell : (n_nodes,) int32
    corner : (n_nodes, 2) int32 [steps]
    extent : (n_nodes,) int32 [steps], signed
    level : (n_nodes,) int8, 0 for a whole cell
    first_child : (n_nodes,) int32, the first of four, NONE for a leaf
    """

    frames: CellFrames
    step: int
    root: NDArray[np.int32]
    cell: NDArray[np.int32]
    corner: NDArray[np.int32]
    extent: NDArray[np.int32]
    level: NDArray[np.int8]
    first_child: NDArray[np.int32]

    @property
    def n_nodes(self) -> int:
        """Number of nodes, leaves and parents together."""
        return len(self.cell)

    @property
    def max_level(self) -> int:
        """Level that is not split any more."""
        return int(self.step // UNIT).bit_length() - 1

    @property
    def side(self) -> NDArray[np.int64]:
        """(n_nodes,) 2 · patch + side."""
        return self.frames.side[self.cell]

    @property
    def is_triangle(self) -> NDArray[np.bool_]:
        """(n_nodes,) bool."""
        triangle: NDArray[np.bool_] = self.frames.is_triangle[self.cell]
        return triangle

    @property
    def is_leaf(self) -> NDArray[np.bool_]:
        """(n_nodes,) bool."""
        leaf: NDArray[np.bool_] = self.first_child == NONE
        return leaf

    def places(self, nodes: NDArray[np.integer]) -> NDArray[np.int64]:
        """(n, 9, 2) steps: corners, centre and middles of edges of the nodes, in the order of `PLACES`."""
        sixths = PLACES[self.is_triangle[nodes].astype(np.int64)]
        unit = (self.extent[nodes] // UNIT).astype(np.int64)
        places: NDArray[np.int64] = self.corner[nodes][:, None, :] + unit[:, None, None] * sixths
        return places

    def in_cell(self, nodes: NDArray[np.integer]) -> NDArray[np.float64]:
        """(n, 9, 2) the same places in the frames of the nodes' cells."""
        cell = self.cell[nodes]
        corner, extent = self.frames.corner[cell][:, None, :], self.frames.extent[cell][:, None, None]
        inside: NDArray[np.float64] = (self.places(nodes) - self.step * corner) / (self.step * extent)
        return inside

    def locate(
        self, cell: NDArray[np.int64], s: NDArray[np.float32], t: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
        """Leaves of points in cells, and where in them.

        Parameters
        ----------
        cell : (n,) int64
            Negative for none.
        s, t : (n,) float32
            In the cell's frame, see `CellFrames`.

        Returns
        -------
        node : (n,) int32, NONE where the cell has no leaves
        s, t : (n,) float32, in the leaf's frame
        """
        node = np.where(cell >= 0, self.root[np.maximum(cell, 0)], NONE).astype(np.int32)
        s, t = s.copy(), t.copy()
        inside = np.flatnonzero(node != NONE)
        inside = inside[self.first_child[node[inside]] != NONE]
        triangle = self.frames.is_triangle[cell[inside]]
        while len(inside):
            a, b = 2.0 * s[inside], 2.0 * t[inside]
            right, upper = a >= 1.0, b >= 1.0
            middle = triangle & ~right & ~upper & (a + b > 1.0)
            s[inside] = np.where(middle, 1.0 - a, a - right)
            t[inside] = np.where(middle, 1.0 - b, b - upper)
            node[inside] = self.first_child[node[inside]] + np.where(middle, 3, right + 2 * upper)
            deeper = self.first_child[node[inside]] != NONE
            inside, triangle = inside[deeper], triangle[deeper]
        return node, s, t


def plant_leaves(frames: CellFrames, wanted: NDArray[np.bool_], max_level: int) -> Leaves:
    """One leaf for each wanted cell.

    Parameters
    ----------
    frames : CellFrames
    wanted : (n_cells,) bool
    max_level : int
        Times that a cell may be split, 0 to 12.
    """
    if not 0 <= max_level <= 12:
        raise ValueError(f"max_level must lie between 0 and 12, is {max_level}")
    step = UNIT << max_level
    cell = np.flatnonzero(wanted).astype(np.int32)
    root = np.full(len(wanted), NONE, np.int32)
    root[cell] = np.arange(len(cell), dtype=np.int32)
    return Leaves(
        frames=frames,
        step=step,
        root=root,
        cell=cell,
        corner=(step * frames.corner[cell]).astype(np.int32),
        extent=(step * frames.extent[cell]).astype(np.int32),
        level=np.zeros(len(cell), np.int8),
        first_child=np.full(len(cell), NONE, np.int32),
    )


def split_leaves(leaves: Leaves, nodes: NDArray[np.integer]) -> Leaves:
    """The same with four children in each of the nodes, which must be leaves below the highest level."""
    if not leaves.is_leaf[nodes].all() or (leaves.level[nodes] >= leaves.max_level).any():
        raise ValueError("only leaves below the highest level can be split")
    children = _CHILDREN[leaves.is_triangle[nodes].astype(np.int64)]
    half = leaves.extent[nodes][:, None] // 2
    first_child = leaves.first_child.copy()
    first_child[nodes] = leaves.n_nodes + 4 * np.arange(len(nodes), dtype=np.int32)
    corner = leaves.corner[nodes][:, None, :] + half[:, :, None] * children[:, :, :2]
    return Leaves(
        frames=leaves.frames,
        step=leaves.step,
        root=leaves.root,
        cell=np.concatenate([leaves.cell, np.repeat(leaves.cell[nodes], 4)]),
        corner=np.concatenate([leaves.corner, corner.reshape(-1, 2).astype(np.int32)]),
        extent=np.concatenate([leaves.extent, (half * children[:, :, 2]).ravel().astype(np.int32)]),
        level=np.concatenate([leaves.level, np.repeat(leaves.level[nodes] + 1, 4).astype(np.int8)]),
        first_child=np.concatenate([first_child, np.full(4 * len(nodes), NONE, np.int32)]),
    )
