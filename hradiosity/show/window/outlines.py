"""Which edges of cells are outlines of elements, or of coarser levels of the hierarchy."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells
from hradiosity.show.window.marks import Lines

Number = TypeVar("Number", np.float64, np.int64)


def hierarchy_levels(cells: Cells) -> int:
    """Times that twos of cells along an edge merge until the most finely cut patch is whole."""
    most = int(cells.grid.max(initial=1))
    return int(np.ceil(np.log2(most)))


def element_levels(cells: Cells) -> NDArray[np.int64]:
    """(n,) times that the patch of each cell was halved to get its element; 0 for a whole patch."""
    along = cells.grid.max(axis=1, initial=1) / np.maximum(cells.width, 1)
    level: NDArray[np.int64] = np.ceil(np.log2(np.maximum(along, 1.0)) - 1e-9).astype(np.int64)
    return level


def edge_flags(cells: Cells, level: int) -> NDArray[np.uint8]:
    """(n, 4) whether the edge from each corner to the next is an outline.

    Parameters
    ----------
    cells : Cells
    level : int
        0 for elements, k for blocks of 2ᵏ × 2ᵏ cells, which never are smaller than an element. Blocks at the end of a
        patch are smaller where numbers are odd, like the nodes of hierarchical links.

    Returns
    -------
    (n, 4) uint8
        A triangle's last one is 0: it has no fourth edge.
    """
    start = cells.place.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    block = np.maximum(cells.width.astype(np.int64), 1 << level)[:, None]
    nu, nv = (cells.grid[:, k].astype(np.int64)[:, None] for k in (0, 1))
    same_u, same_v = start[..., 0] == end[..., 0], start[..., 1] == end[..., 1]
    along_u = same_u & _on_line(start[..., 0], block, nu)
    along_v = same_v & _on_line(start[..., 1], block, nv)
    diagonal = ~same_u & ~same_v & _on_line(start.sum(axis=2), block, nu)
    real = np.any(start != end, axis=2)
    flags: NDArray[np.uint8] = ((along_u | along_v | diagonal) & real).astype(np.uint8)
    # A triangle repeats its last corner, and has its third edge from there to the first one.
    flags[cells.is_triangle, 2] = flags[cells.is_triangle, 3]
    flags[cells.is_triangle, 3] = 0
    return flags


def edge_ends(corners: NDArray[Number], is_triangle: NDArray[np.bool_]) -> NDArray[Number]:
    """Where the edge from each corner (n, 4, …) ends; the third one of a triangle at its first corner."""
    end = np.roll(corners, -1, axis=1)
    end[is_triangle, 2] = corners[is_triangle, 0]
    return end


class FacingOutlines:
    """Outlines of the cells that face the eye.

    Lines, and not edges that the card draws with its faces: those are wrong on faces that reach behind the eye, as
    floors do that are one cell.

    Parameters
    ----------
    cells : Cells
    flags : (n, 4) uint8
        Edges that are outlines.
    """

    def __init__(self, cells: Cells, flags: NDArray[np.uint8]) -> None:
        self._cell, corner = _once(cells, *np.nonzero(flags))
        self._start = cells.corners[self._cell, corner]
        self._end = edge_ends(cells.corners, cells.is_triangle)[self._cell, corner]
        self._normal = cells.normal
        self._offset = np.einsum("nk,nk->n", cells.normal, cells.corners[:, 0])
        self._faced: NDArray[np.bool_] | None = None

    def seen_from(self, eye: NDArray[np.float64]) -> Lines | None:
        """Lines of cells that face an eye (3,); None where they are the same as at the last call."""
        faced = np.einsum("nk,k->n", self._normal, eye) > self._offset
        if self._faced is not None and np.array_equal(faced, self._faced):
            return None
        self._faced = faced
        seen = faced[self._cell]
        return Lines(self._start[seen], self._end[seen])


def _once(
    cells: Cells, cell: NDArray[np.int64], corner: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges without those that a neighbour on the same side of the same patch has too: both are seen, or none."""
    place = cells.place.astype(np.int64)
    spot = place[..., 0] * (int(cells.grid.max(initial=1)) + 1) + place[..., 1]
    start, end = spot[cell, corner], edge_ends(spot, cells.is_triangle)[cell, corner]
    surface = 2 * cells.patch[cell].astype(np.int64) + cells.side[cell]
    keys = (np.maximum(start, end), np.minimum(start, end), surface)
    order = np.lexsort(keys)
    new = np.ones(len(order), np.bool_)
    if len(order) > 1:
        new[1:] = np.any([key[order[1:]] != key[order[:-1]] for key in keys], axis=0)
    kept = np.sort(order[new])
    return cell[kept], corner[kept]


def _on_line(place: NDArray[np.int64], block: NDArray[np.int64], count: NDArray[np.int64]) -> NDArray[np.bool_]:
    on: NDArray[np.bool_] = (place % block == 0) | (place == count)
    return on
