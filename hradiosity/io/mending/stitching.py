"""Closing cracks and taking slivers out of triangle meshes, by moving points no farther than a given distance."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.welding import weld

_ROUNDS: Final = 12
_LONG_CHAIN: Final = 3.0
"""Points that hang together over more than so many distances are too fine a detail to be one point."""

Triangles = NDArray[np.int64]
Points = NDArray[np.float64]


def stitched(points: Points, triangles: Triangles, distance: float) -> tuple[Points, Triangles, NDArray[np.int64]]:
    """Join open edges that lie within a distance of each other.

    Corners at open edges that lie within ``distance`` of each other become one; open edges on which, within that
    distance, corners of other open edges lie (T-junctions) are split there; slivers lower than it go, their
    neighbours taking their place. Triangles that lose their area are left out.

    Parameters
    ----------
    points : (n, 3) float64 [m]
    triangles : (m, 3) int64
    distance : float
        Above 0 [m].

    Returns
    -------
    points, triangles, source
        The same points, some of them moved; new triangles; and the triangle that each of them comes from.
    """
    points = points.copy()
    corner = weld(points, 1e-3 * distance)
    triangles = np.unique(corner, return_index=True)[1][corner][triangles]
    source = np.arange(len(triangles))
    for _ in range(_ROUNDS):
        before = triangles
        triangles, source = _proper(_joined_corners(points, triangles, distance), source)
        triangles, source = _split_open_edges(points, triangles, source, distance)
        triangles, source = _without_slivers(points, triangles, source, distance)
        if np.array_equal(before, triangles):
            break
    return points, triangles, source


def open_edges(triangles: Triangles) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges of one triangle only: the triangle, and which of its edges (from corner k to the next)."""
    key = _edge_keys(triangles)
    _, index, count = np.unique(key.ravel(), return_inverse=True, return_counts=True)
    alone = np.flatnonzero(count[index.ravel()] == 1)
    return alone // 3, alone % 3


def _edge_keys(triangles: Triangles) -> NDArray[np.int64]:
    """(m, 3) a number for each edge, whichever way it runs."""
    following = np.roll(triangles, -1, axis=1)
    span = int(triangles.max(initial=0)) + 1
    return np.minimum(triangles, following) * span + np.maximum(triangles, following)


def _proper(triangles: Triangles, source: NDArray[np.int64]) -> tuple[Triangles, NDArray[np.int64]]:
    """Without triangles that have lost a corner."""
    kept = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return triangles[kept], source[kept]


def _joined_corners(points: Points, triangles: Triangles, distance: float) -> Triangles:
    """Triangles whose corners at open edges were replaced by one of those within the distance."""
    triangle, edge = open_edges(triangles)
    if not len(triangle):
        return triangles
    corner = np.unique(np.concatenate([triangles[triangle, edge], triangles[triangle, (edge + 1) % 3]]))
    group = weld(points[corner], distance)
    order = np.lexsort((corner, group))
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    lowest = np.minimum.reduceat(points[corner[order]], starts, axis=0)
    highest = np.maximum.reduceat(points[corner[order]], starts, axis=0)
    fine = (highest - lowest).max(axis=1) <= _LONG_CHAIN * distance
    target = np.arange(len(points))
    target[corner] = np.where(fine[group], corner[order][starts][group], corner)
    return np.asarray(target[triangles])


def _split_open_edges(
    points: Points, triangles: Triangles, source: NDArray[np.int64], distance: float
) -> tuple[Triangles, NDArray[np.int64]]:
    """One open edge of each triangle split at the first corner of another open edge that lies on it."""
    from scipy.spatial import cKDTree

    triangle, edge = open_edges(triangles)
    if not len(triangle):
        return triangles, source
    start, end = triangles[triangle, edge], triangles[triangle, (edge + 1) % 3]
    corner = np.unique(np.concatenate([start, end]))
    along = points[end] - points[start]
    length = np.linalg.norm(along, axis=1)
    tree = cKDTree(points[corner])
    near = tree.query_ball_point(points[start] + 0.5 * along, 0.5 * length + distance)
    count = np.fromiter(map(len, near), np.int64, len(near))
    row = np.repeat(np.arange(len(triangle)), count)
    found = corner[np.concatenate([np.asarray(entry, np.int64) for entry in near])]
    offset = points[found] - points[start[row]]
    share = np.einsum("ij,ij->i", offset, along[row]) / length[row] ** 2
    away = np.linalg.norm(offset - share[:, None] * along[row], axis=1)
    beyond = (share * length[row] > distance) & ((1.0 - share) * length[row] > distance)
    fits = np.flatnonzero(beyond & (away <= distance) & ~(triangles[triangle[row]] == found[:, None]).any(axis=1))
    fits = fits[np.lexsort((share[fits], triangle[row[fits]]))]
    chosen = fits[np.unique(triangle[row[fits]], return_index=True)[1]]
    return _split(triangles, source, triangle[row[chosen]], edge[row[chosen]], found[chosen])


def _split(
    triangles: Triangles,
    source: NDArray[np.int64],
    which: NDArray[np.int64],
    edge: NDArray[np.int64],
    point: NDArray[np.int64],
) -> tuple[Triangles, NDArray[np.int64]]:
    """Each of the triangles in two, from a point on one of its edges to the corner opposite."""
    rows = np.arange(len(which))
    turned = triangles[which][rows[:, None], (edge[:, None] + np.arange(3)) % 3]
    one, other = turned.copy(), turned.copy()
    one[:, 1], other[:, 0] = point, point
    whole = triangles.copy()
    whole[which] = one
    return np.concatenate([whole, other]), np.concatenate([source, source[which]])


def _without_slivers(
    points: Points, triangles: Triangles, source: NDArray[np.int64], distance: float
) -> tuple[Triangles, NDArray[np.int64]]:
    """Slivers whose apex lies on their longest edge go; the neighbour across that edge is split at the apex."""
    corner = points[triangles]
    side = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    longest = side.argmax(axis=1)
    rows = np.arange(len(triangles))
    twice_area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    height = twice_area / side[rows, longest]
    shortest = side.min(axis=1)
    flat = (height <= distance) & (height < 1e-2 * side[rows, longest])
    needle = flat & (shortest <= distance)
    triangles, source = _collapsed(triangles, source, rows[needle], side[needle].argmin(axis=1))
    if needle.any():
        return triangles, source
    key = _edge_keys(triangles)
    order = np.argsort(key.ravel(), kind="stable")
    flat_key = key.ravel()[order]
    twin = np.flatnonzero(flat_key[1:] == flat_key[:-1])
    other = np.full(key.size, -1, dtype=np.int64)
    other[order[twin]], other[order[twin + 1]] = order[twin + 1], order[twin]
    sliver = np.flatnonzero(flat)
    across = other[3 * sliver + longest[sliver]]
    lonely = across < 0
    neighbour = np.maximum(across, 0) // 3
    claim = np.full(len(triangles), len(triangles))
    np.minimum.at(claim, sliver, sliver)
    np.minimum.at(claim, neighbour[~lonely], sliver[~lonely])
    wins = (claim[sliver] == sliver) & (lonely | (claim[neighbour] == sliver)) & ~(flat[neighbour] & ~lonely)
    gone, halved = sliver[wins], sliver[wins & ~lonely]
    across = across[wins & ~lonely]
    apex = triangles[halved, (longest[halved] + 2) % 3]
    kept = np.ones(len(triangles), np.bool_)
    kept[gone] = False
    triangles, source = _split(triangles, source, across // 3, across % 3, apex)
    kept = np.concatenate([kept, np.ones(len(triangles) - len(kept), np.bool_)])
    return _proper(triangles[kept], source[kept])


def _collapsed(
    triangles: Triangles, source: NDArray[np.int64], which: NDArray[np.int64], edge: NDArray[np.int64]
) -> tuple[Triangles, NDArray[np.int64]]:
    """Without the shortest edge of some triangles: its two ends become the one with the lower number."""
    if not len(which):
        return triangles, source
    start, end = triangles[which, edge], triangles[which, (edge + 1) % 3]
    low, high = np.minimum(start, end), np.maximum(start, end)
    alone = ~np.isin(high, low)
    target = np.arange(int(triangles.max()) + 1)
    target[high[alone]] = low[alone]
    return _proper(np.asarray(target[triangles]), source)
