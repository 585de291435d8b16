"""Closed shells: which patches have matter behind them."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.welding import connected, weld

SHELL_TOLERANCE: Final = 2e-6
"""Corners closer than this, relative to the diagonal of their object's bounding box, are one vertex of a shell: twice
what the fourth corner of a parallelogram made from two triangles may be off (``meshing.PARALLELOGRAM_TOLERANCE``)."""
_ANGLE_STEPS: Final = 1_000_000
"""Angles around an edge are compared in steps of 2π over this."""


class Shells(NamedTuple):
    """Closed shells among patches.

    solid : (n,) int32, number of the outward-facing shell a patch belongs to, or NONE
    inward : (n,) int32, number of the inward-facing shell (a room, or a body turned inside out), or NONE
    """

    solid: NDArray[np.int32]
    inward: NDArray[np.int32]


class _HalfEdges(NamedTuple):
    """Edges of patches, each with the patch it bounds, sorted by edge.

    patch : (k,) int64
    group : (k,) int64, equal where both ends are equal
    forward : (k,) bool, the patch runs along the edge from its lower to its higher vertex
    """

    patch: NDArray[np.int64]
    group: NDArray[np.int64]
    forward: NDArray[np.bool_]


def find_solids(corners: NDArray[np.float64], is_triangle: NDArray[np.bool_], objects: NDArray[np.integer]) -> Shells:
    """Find closed shells, object by object.

    Corners within 2e-6 of the diagonal of the object's bounding box are one vertex (``SHELL_TOLERANCE``). A shell is
    a set of patches of one object, connected over edges, in which each patch has exactly one neighbour, wound
    consistently, at each edge. Where more than two patches of one object meet at an edge (two boxes that touch), they
    are paired around the edge so that each pair encloses a wedge of matter; boxes that share a face or an edge are
    thus separate solids. A flap or a T-junction leaves its whole shell open. A shell whose mean thickness is below
    that tolerance, such as a sheet modelled twice, is neither solid nor inward.

    Parameters
    ----------
    corners : (n, 4, 3) float64 [m]
        As ``Patches.corners()`` gives them.
    is_triangle : (n,) bool
    objects : (n,) int
        Shells are searched within patches of one number.
    """
    n = len(corners)
    nowhere = np.full(n, NONE, dtype=np.int32)
    if n == 0:
        return Shells(nowhere, nowhere.copy())
    owner = np.unique(objects, return_inverse=True)[1]
    vertex, tolerance = _vertices(corners, owner)
    edges, here = _half_edges(vertex)
    order = _around_edges(edges, corners, here)
    edges = _HalfEdges(edges.patch[order], edges.group[order], edges.forward[order])
    opening, closing, paired = _pair_up(edges)
    shell = connected(edges.patch[opening], edges.patch[closing], n)
    is_open = np.zeros(shell.max() + 1, dtype=np.bool_)
    is_open[shell[edges.patch[~paired]]] = True
    volume, area = _volumes(corners, is_triangle, shell)
    thickness = np.where(is_open, 0.0, volume / area)
    bound = tolerance[owner[np.unique(shell, return_index=True)[1]]]
    return Shells(_numbered(shell, thickness > bound), _numbered(shell, thickness < -bound))


def _vertices(corners: NDArray[np.float64], owner: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(n, 4) vertex numbers, different in different objects, and the welding distance [m] of each object."""
    low = np.full((int(owner.max()) + 1, 3), np.inf)
    high = np.full_like(low, -np.inf)
    np.minimum.at(low, owner, corners.min(axis=1))
    np.maximum.at(high, owner, corners.max(axis=1))
    size = np.linalg.norm(high - low, axis=1)
    scaled = (corners - low[owner, None]) / np.where(size > 0.0, size, 1.0)[owner, None, None]
    scaled[:, :, 0] += 2.0 * owner[:, None]
    return weld(scaled.reshape(-1, 3), SHELL_TOLERANCE).reshape(-1, 4), SHELL_TOLERANCE * size


def _half_edges(vertex: NDArray[np.int64]) -> tuple[_HalfEdges, NDArray[np.int64]]:
    """Half-edges sorted by edge, and the number 4 · patch + side of each; edges without length are left out."""
    start, end = vertex.ravel(), np.roll(vertex, -1, axis=1).ravel()
    side = np.flatnonzero(start != end)
    start, end = start[side], end[side]
    n = int(vertex.max()) + 1
    group = np.unique(np.minimum(start, end) * n + np.maximum(start, end), return_inverse=True)[1]
    order = np.argsort(group, kind="stable")
    return _HalfEdges((side // 4)[order], group[order], (start < end)[order]), side[order]


def _around_edges(edges: _HalfEdges, corners: NDArray[np.float64], side: NDArray[np.int64]) -> NDArray[np.int64]:
    """Order of half-edges by edge, then by angle around it, seen so that matter follows a forward patch.

    Angles count from the first patch of the edge. Of two patches at one angle the one that ends matter comes first,
    because nothing is between them.
    """
    flat = corners.reshape(-1, 3)
    following = side - side % 4 + (side + 1) % 4
    along = flat[following] - flat[side]
    along *= np.where(edges.forward, 1.0, -1.0)[:, None]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inwards = flat.reshape(-1, 4, 3)[edges.patch].mean(axis=1) - 0.5 * (flat[following] + flat[side])
    inwards -= np.einsum("ij,ij->i", inwards, along)[:, None] * along
    first = np.flatnonzero(np.diff(edges.group, prepend=-1))[edges.group]
    zero, axis = inwards[first], along[first]
    # In front of a forward patch lies along × inwards; matter is behind it, so angles run the other way.
    turn = np.arctan2(-np.einsum("ij,ij->i", np.cross(axis, zero), inwards), np.einsum("ij,ij->i", zero, inwards))
    step = np.round(turn * (_ANGLE_STEPS / (2.0 * np.pi))).astype(np.int64) % _ANGLE_STEPS
    return np.lexsort((edges.forward, step, edges.group))


def _pair_up(edges: _HalfEdges) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Half-edges that open a wedge of matter, those that close it, and which ones were paired at all.

    Around an edge of a closed shell opening and closing patches alternate; where they don't, nothing is paired.
    """
    start = np.flatnonzero(np.diff(edges.group, prepend=-1))
    size = np.diff(np.append(start, len(edges.group)))
    here = np.arange(len(edges.group))
    following = here + 1
    following[start + size - 1] = start
    repeated = edges.forward == edges.forward[following]
    faulty = np.zeros(len(start), dtype=np.bool_)
    faulty[edges.group[repeated]] = True
    paired = ~faulty[edges.group]
    opening = here[paired & edges.forward]
    return opening, following[opening], paired


def _volumes(
    corners: NDArray[np.float64], is_triangle: NDArray[np.bool_], shell: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Signed volume [m³] and area [m²] of each shell, by the divergence theorem from its first corner."""
    origin = corners[np.unique(shell, return_index=True)[1], 0]
    base = corners[:, 0] - origin[shell]
    share = np.where(is_triangle, 0.5, 1.0)[:, None]
    vector_area = share * np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    volume = np.bincount(shell, np.einsum("ij,ij->i", base, vector_area) / 3.0).astype(np.float64)
    return volume, np.bincount(shell, np.linalg.norm(vector_area, axis=1)).astype(np.float64)


def _numbered(shell: NDArray[np.int64], wanted: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Shell numbers of patches, counting only the wanted shells, by first patch; NONE elsewhere."""
    number = np.where(wanted, np.cumsum(wanted) - 1, NONE)
    return number[shell].astype(np.int32)
