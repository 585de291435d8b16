"""Pairs of patches that lie in one plane and overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.model.welding import weld
from hradiosity.space.overlaps import overlap_areas, overlapping_boxes

COINCIDENT = 1e-6
"""Surfaces closer than this, relative to the scene's size, can't be told apart by single precision rays."""
_PARALLEL = 1e-4
"""Normals that differ by less than this [rad] may belong to one plane; distances decide afterwards."""
_BATCH = 1 << 16
"""Pairs whose common area is computed at a time."""


@dataclass(frozen=True)
class Coplanar:
    """Overlapping patches of one plane.

    first, second : (m,) int64, patches; first < second
    area : (m,) float64, common area [m²]
    gap : (m,) float64, distance of the planes in the middle of the smaller patch [m]
    place : (m, 3) float64 [m], middle of the overlap
    same_facing : (m,) bool
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    area: NDArray[np.float64]
    gap: NDArray[np.float64]
    place: NDArray[np.float64]
    same_facing: NDArray[np.bool_]


def coplanar_pairs(patches: Patches) -> Coplanar:
    """All pairs of patches that overlap within `COINCIDENT` of the diagonal of their bounding box."""
    low, high = patches.bounds()
    size = float(np.linalg.norm(high - low))
    tolerance = COINCIDENT * size
    normal = patches.normal
    corners = patches.corners() - 0.5 * (low + high)
    plane, axis = _planes(corners, normal, size)
    flat = _in_plane(corners, axis)
    shared = np.flatnonzero(np.bincount(plane)[plane] > 1)
    pair = shared[
        overlapping_boxes(
            flat[shared].min(axis=1),
            flat[shared].max(axis=1),
            np.unique(plane[shared], return_inverse=True)[1],
            2.0 * tolerance,
        )
    ]
    first, second = pair[:, 0], pair[:, 1]
    gap = _gap(patches, first, second)
    close = gap <= tolerance
    first, second, gap = first[close], second[close], gap[close]
    batches = [slice(i, i + _BATCH) for i in range(0, len(first), _BATCH)]
    area = np.concatenate([np.zeros(0), *(overlap_areas(flat[first[b]], flat[second[b]]) for b in batches)])
    # A strip narrower than the tolerance is two neighbours that touch.
    edge = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    wide = area > 2.0 * tolerance * np.minimum(edge[first], edge[second])
    first, second = first[wide], second[wide]
    lowest, highest = patches.corners().min(axis=1), patches.corners().max(axis=1)
    place = 0.5 * (np.maximum(lowest[first], lowest[second]) + np.minimum(highest[first], highest[second]))
    facing = np.einsum("ij,ij->i", normal[first], normal[second]) > 0.0
    return Coplanar(first, second, area[wide], gap[wide], place, facing)


def _planes(
    corners: NDArray[np.float64], normal: NDArray[np.float64], size: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Number of the plane of each patch, whichever way it faces, and the plane's normal (n, 3).

    Patches with nearly parallel normals are sorted along their common normal, and a new plane begins at each gap.
    """
    n = len(normal)
    both = np.concatenate([normal, -normal])
    direction = weld(both, _PARALLEL)
    one, other = direction[:n], direction[n:]
    first = np.unique(direction, return_index=True)[1]
    cluster = np.minimum(one, other)
    axis = both[first[cluster]]
    along = np.einsum("ncd,nd->nc", corners, axis)
    # Directions are kept apart by more than any two patches can be, so that one sweep serves all.
    apart = 4.0 * size * np.unique(cluster, return_inverse=True)[1]
    low, high = along.min(axis=1) + apart, along.max(axis=1) + apart
    order = np.argsort(low, kind="stable")
    reached = np.maximum.accumulate(high[order])
    begins = np.concatenate([[False], low[order][1:] > reached[:-1] + COINCIDENT * size])
    plane = np.empty(n, np.int64)
    plane[order] = np.cumsum(begins)
    return plane, axis


def _in_plane(points: NDArray[np.float64], axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 4, 2) coordinates across each normal (n, 3)."""
    helper = np.where(np.abs(axis[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(axis, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(axis, u)
    return np.stack([np.einsum("ncd,nd->nc", points, u), np.einsum("ncd,nd->nc", points, v)], axis=2)


def _gap(patches: Patches, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) distance of the smaller patch's centre from the plane of the larger one [m]."""
    swap = patches.area[first] > patches.area[second]
    small, large = np.where(swap, second, first), np.where(swap, first, second)
    offset = patches.centroid[small] - patches.origin[large]
    return np.asarray(np.abs(np.einsum("ij,ij->i", offset, patches.normal[large])))
