"""Nodes over row elements: cells of a patch side merge by fours into coarser ones, up to the whole side.

Row elements are the leaves, with their numbers; groups of small faces are leaves without anything above them
(Hanrahan, Salzman & Aupperle 1991 cut from above; the trees are the same).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.cell_lookup import CELL_CORNERS, CellFrames, cell_frames
from hradiosity.space.cells import cell_corners, place_corners
from hradiosity.space.hierarchy import Elements

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ROOT: Final = -1
"""Parent of a node that has none."""


@dataclass(frozen=True)
class Facets:
    """Flat polygons that nodes consist of, counter-clockwise seen from the lit side.

    corners : (n, 4, 3) float64 [m], world; a triangle repeats its last corner
    is_triangle : (n,) bool
    normal : (n, 3) float64, unit, of the lit side
    area : (n,) float64 [m²]
    side : (n,) int64, 2 · patch + side that each is a part of
    """

    corners: NDArray[np.float64]
    is_triangle: NDArray[np.bool_]
    normal: NDArray[np.float64]
    area: NDArray[np.float64]
    side: NDArray[np.int64]

    @property
    def patch(self) -> NDArray[np.int64]:
        """(n,) the patch."""
        return self.side // 2

    def __len__(self) -> int:
        return len(self.area)


@dataclass(frozen=True)
class Nodes:
    """Trees over the row elements; nodes 0 … n_rows − 1 are these, and parents follow level by level.

    n_rows : number of leaves
    level_start : (n_levels + 1,) int64, first node of each level; level 0 are the leaves
    parent : (n_nodes,) int64, ROOT for none
    child_start, child : (n_nodes + 1,) and (n_nodes − n_roots,) int64, children by parent
    facets : Facets
    facet_start : (n_nodes + 1,) int64, into `facets`; only groups have more than one
    """

    n_rows: int
    level_start: NDArray[np.int64]
    parent: NDArray[np.int64]
    child_start: NDArray[np.int64]
    child: NDArray[np.int64]
    facets: Facets
    facet_start: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.parent)

    @property
    def n_levels(self) -> int:
        """Levels, that of the leaves included."""
        return len(self.level_start) - 1

    @property
    def is_leaf(self) -> NDArray[np.bool_]:
        """(n_nodes,) bool."""
        leaf: NDArray[np.bool_] = np.arange(len(self)) < self.n_rows
        return leaf

    @property
    def roots(self) -> NDArray[np.int64]:
        """Nodes without a parent."""
        return np.flatnonzero(self.parent == ROOT)

    def areas(self) -> NDArray[np.float64]:
        """(n_nodes,) area [m²], covered parts included."""
        area: NDArray[np.float64] = (
            np.add.reduceat(self.facets.area, self.facet_start[:-1]) if len(self) else np.zeros(0)
        )
        return area

    def gathering(self) -> csr_array:
        """(n_nodes, n_rows) with ones where a row element is the node or lies below it.

        Its product with values of the row elements pulls them up by summing; that of its transpose pushes down.
        """
        from scipy.sparse import csr_array

        rows = np.arange(self.n_rows)
        node, leaf, at = [rows], [rows], rows
        for _ in range(self.n_levels - 1):
            at = np.where(at == ROOT, ROOT, self.parent[at])
            node.append(at[at != ROOT])
            leaf.append(rows[at != ROOT])
        places = np.concatenate(node), np.concatenate(leaf)
        return csr_array((np.ones(len(places[0])), places), shape=(len(self), self.n_rows))


@dataclass(frozen=True)
class Squares:
    """Nodes of one level that lie on one grid each.

    frames : their places, in steps of the side's grid at this level
    divisions : (n, 2) int64, size of that grid
    finest : (n, 2) int64, size of the side's grid of cells
    node : (n,) int64
    """

    frames: CellFrames
    divisions: NDArray[np.int64]
    finest: NDArray[np.int64]
    node: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.node)


def build_nodes(patches: Patches, elements: Elements) -> Nodes:
    """Merge the cells of each cut patch side by fours until one is left.

    Where the number of cells along an edge is odd, the last ones merge by twos or stay single. An odd number of
    triangle cells along an edge merges into the whole triangle at once.
    """
    n_rows = len(elements)
    corners, is_triangle = cell_corners(patches, elements)
    order = elements.row_cell.astype(np.int64)
    facets = [_facets(patches, elements.cell_side[order].astype(np.int64), corners[order], is_triangle[order])]
    facet_start = [elements.row_start.astype(np.int64)]
    squares = leaf_squares(patches, elements)
    parent, level_start = [np.full(n_rows, ROOT)], [0, n_rows]
    while len(squares):
        above, parents = merged_squares(squares, level_start[-1])
        all_parents = np.concatenate(parent)
        all_parents[squares.node] = parents
        parent = [all_parents, np.full(len(above), ROOT)]
        facets.append(_square_facets(patches, above, 1 << (len(level_start) - 1)))
        facet_start.append(facet_start[-1][-1] + 1 + np.arange(len(above)))
        level_start.append(level_start[-1] + len(above))
        squares = _unfinished(above)
    all_parents = np.concatenate(parent)
    child_order = np.argsort(all_parents, kind="stable")
    child_count = np.bincount(all_parents[all_parents != ROOT], minlength=len(all_parents))
    return Nodes(
        n_rows=n_rows,
        level_start=np.array(level_start, np.int64),
        parent=all_parents,
        child_start=np.concatenate([[0], np.cumsum(child_count)]),
        child=child_order[np.count_nonzero(all_parents == ROOT) :],
        facets=_joined(facets),
        facet_start=np.concatenate(facet_start),
    )


def leaf_squares(patches: Patches, elements: Elements) -> Squares:
    """The row elements that are single cells of cut sides."""
    frames = cell_frames(elements, patches.is_triangle)
    divisions = elements.divisions.astype(np.int64)[frames.side // 2]
    cut = np.flatnonzero(divisions.max(axis=1, initial=0) > 1)
    return Squares(_taken(frames, cut), divisions[cut], divisions[cut], elements.cell_row[cut].astype(np.int64))


def merged_squares(squares: Squares, first_node: int) -> tuple[Squares, NDArray[np.int64]]:
    """The squares of the next level, and which of their nodes (n,) each square merges into."""
    frames, divisions = squares.frames, squares.divisions
    odd = frames.is_triangle & (divisions[:, 0] % 2 == 1)
    step = np.where(odd, divisions[:, 0], 2)[:, None]
    coarser = np.where(frames.is_triangle[:, None], divisions // step, (divisions + 1) // 2)
    low = frames.corner - (frames.extent == -1)[:, None]
    place = low // step
    inside = (low - place * step).sum(axis=1) + (frames.extent == -1)
    inverted = frames.is_triangle & ~odd & (inside >= 2)
    key = np.column_stack([frames.side, place[:, 1], place[:, 0], inverted])
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    above = CellFrames(
        side=frames.side[first],
        corner=place[first] + inverted[first, None],
        extent=np.where(inverted[first], -1, 1),
        is_triangle=frames.is_triangle[first],
    )
    node = first_node + np.arange(len(first))
    return Squares(above, coarser[first], squares.finest[first], node), first_node + group.ravel()


def _unfinished(squares: Squares) -> Squares:
    """Those that are not whole sides yet."""
    rest = np.flatnonzero(squares.divisions.max(axis=1, initial=0) > 1)
    return Squares(_taken(squares.frames, rest), squares.divisions[rest], squares.finest[rest], squares.node[rest])


def _taken(frames: CellFrames, chosen: NDArray[np.int64]) -> CellFrames:
    return CellFrames(frames.side[chosen], frames.corner[chosen], frames.extent[chosen], frames.is_triangle[chosen])


def _facets(
    patches: Patches, side: NDArray[np.int64], corners: NDArray[np.float64], is_triangle: NDArray[np.bool_]
) -> Facets:
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    area = np.linalg.norm(across, axis=1) * np.where(is_triangle, 0.5, 1.0)
    normal = patches.normal[side // 2] * np.where(side % 2 == 0, 1.0, -1.0)[:, None]
    return Facets(corners, is_triangle, normal, area, side)


def _square_facets(patches: Patches, squares: Squares, width: int) -> Facets:
    """One facet a square of `width` cells; the last ones of a grid may end before."""
    frames = squares.frames
    offset = CELL_CORNERS[frames.is_triangle.astype(np.int64)]
    grid = frames.corner[:, None, :] + frames.extent[:, None, None] * offset
    cells = np.minimum(grid * width, squares.finest[:, None, :]) / squares.finest[:, None, :]
    share = np.where(frames.is_triangle[:, None, None], grid / squares.divisions[:, None, :], cells)
    return _facets(
        patches, frames.side, place_corners(patches, frames.side, frames.is_triangle, share), frames.is_triangle
    )


def _joined(parts: list[Facets]) -> Facets:
    return Facets(
        corners=np.concatenate([p.corners for p in parts]),
        is_triangle=np.concatenate([p.is_triangle for p in parts]),
        normal=np.concatenate([p.normal for p in parts]),
        area=np.concatenate([p.area for p in parts]),
        side=np.concatenate([p.side for p in parts]),
    )
