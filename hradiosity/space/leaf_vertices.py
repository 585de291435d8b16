"""Which points on patch sides are one and the same: vertices of cells and leaves without seams inside a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.model.welding import connected, weld, weld_distance

_ON_EDGE: Final = 1 << 62
_EDGE_STEPS: Final = 1 << 30
FLAT: Final = 1e-6
"""Two neighbours with normals closer than this (1 - cosine) are one surface."""

_NO_EDGE: Final = -1


@dataclass(frozen=True)
class SideRims:
    """The outlines of the sides, and which of them belong together.

    Sides of neighbouring patches join when they share an edge, lie in one plane and have the same label. Corners and
    edges of joined sides have the same numbers.

    region : (n_sides,) int64, number of the set of joined sides
    corner : (n_sides, 4) int64, number of each corner; a triangle repeats its last one
    edge : (n_sides, 4) int64, number of the edge from each corner to the next; of a triangle the third runs back to
        the first corner
    forward : (n_sides, 4) bool, the edge's own direction is that of the side
    """

    region: NDArray[np.int64]
    corner: NDArray[np.int64]
    edge: NDArray[np.int64]
    forward: NDArray[np.bool_]


def find_rims(patches: Patches, label: NDArray[np.integer]) -> SideRims:
    """Join the sides that form one flat surface.

    Parameters
    ----------
    patches : Patches
    label : (n_patches, 2) int
        Only sides of one label join: object, material, space.
    """
    n = len(patches)
    points = patches.corners().reshape(-1, 3)
    welded = weld(points, weld_distance(points)).reshape(n, 4) if n else np.zeros((0, 4), np.int64)
    start, end = welded, np.roll(welded, -1, axis=1)
    end = np.where(patches.is_triangle[:, None] & (np.arange(4) == 2), welded[:, :1], end)
    low, high = np.minimum(start, end), np.maximum(start, end)
    n_points = int(welded.max(initial=0)) + 1
    edge = np.unique(low * n_points + high, return_inverse=True)[1].reshape(n, 4)
    region = _join(patches, edge, label)
    by_side = np.repeat(np.arange(n), 2)
    return SideRims(
        region=region,
        corner=_paired(region, welded[by_side]),
        edge=_paired(region, edge[by_side]),
        forward=(start <= end)[by_side],
    )


def _join(patches: Patches, edge: NDArray[np.int64], label: NDArray[np.integer]) -> NDArray[np.int64]:
    """(n_sides,) region numbers."""
    n = len(patches)
    owner = np.repeat(np.arange(n), 4)
    real = ~(patches.is_triangle[:, None] & (np.arange(4) == 3)).ravel()
    owner, shared = owner[real], edge.ravel()[real]
    order = np.argsort(shared, kind="stable")
    owner, shared = owner[order], shared[order]
    pairs = [np.zeros((0, 2), np.int64)]
    longest = int(np.bincount(shared).max(initial=1)) if len(shared) else 1
    for gap in range(1, min(longest, 8)):
        same = shared[gap:] == shared[:-gap]
        pairs.append(np.column_stack([owner[:-gap][same], owner[gap:][same]]))
    first, second = np.concatenate(pairs).T
    normal = patches.normal
    cosine = np.einsum("ij,ij->i", normal[first], normal[second])
    flat = np.abs(cosine) > 1.0 - FLAT
    first, second, turned = first[flat], second[flat], (cosine[flat] < 0.0).astype(np.int64)
    one = np.concatenate([2 * first, 2 * first + 1])
    other = np.concatenate([2 * second + turned, 2 * second + 1 - turned])
    alike = label.ravel()[one] == label.ravel()[other]
    return connected(one[alike], other[alike], 2 * n)


def _paired(region: NDArray[np.int64], number: NDArray[np.int64]) -> NDArray[np.int64]:
    """Numbers that are equal where region and number are; shape of `number`, (n_sides, 4)."""
    span = int(number.max(initial=0)) + 1
    joined: NDArray[np.int64] = np.unique(region[:, None] * span + number, return_inverse=True)[1]
    return joined.reshape(number.shape)


def vertex_keys(
    rims: SideRims,
    is_triangle: NDArray[np.bool_],
    side: NDArray[np.int64],
    place: NDArray[np.int64],
    grid: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Numbers of points on sides; equal exactly where joined sides have the same point.

    Parameters
    ----------
    rims : SideRims
    is_triangle : (n_patches,) bool
    side : (n,) int64
    place : (n, 2) int64
        Point in steps along edge_u and edge_v.
    grid : (n, 2) int64
        Steps of the whole edges, below 2^20 with a million patches and 2^27 with a hundred.

    Raises
    ------
    ValueError
        When a side has too many steps for the number of sides.
    """
    bits = (62 - len(rims.region).bit_length()) // 2
    if int(grid.max(initial=0)) >= 1 << bits:
        raise ValueError(f"{grid.max()} steps along an edge are too many for the points of {len(rims.region)} sides")
    u, v = place[:, 0], place[:, 1]
    key = (side << (2 * bits)) | (u << bits) | v
    triangle = is_triangle[side // 2]
    edge, along, length = _on_edges(u, v, grid, triangle)
    rim = np.flatnonzero(edge != _NO_EDGE)
    which, owner = edge[rim], side[rim]
    forward = rims.forward[owner, which]
    steps = np.where(forward, along[rim], length[rim] - along[rim])
    share = np.rint(steps / length[rim] * _EDGE_STEPS).astype(np.int64)
    key[rim] = _ON_EDGE | (rims.edge[owner, which] << 31) | share
    at_end = (along[rim] == 0) | (along[rim] == length[rim])
    corner = (which + (along[rim] != 0)) % np.where(triangle[rim], 3, 4)
    key[rim[at_end]] = -1 - rims.corner[owner, corner][at_end]
    return key


def _on_edges(
    u: NDArray[np.int64], v: NDArray[np.int64], grid: NDArray[np.int64], triangle: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Edge that each point lies on, steps along it from its first corner, and its length; (n,) each."""
    nu, nv = grid[:, 0], grid[:, 1]
    conditions = [v == 0, ~triangle & (u == nu), triangle & (u + v == nu), ~triangle & (v == nv), triangle & (u == 0),
                  ~triangle & (u == 0)]  # fmt: skip
    edge = np.select(conditions, [0, 1, 1, 2, 2, 3], _NO_EDGE)
    along = np.select(conditions, [u, v, v, nu - u, nv - v, nv - v], 0)
    length = np.where(np.isin(edge, (0,)) | (~triangle & (edge == 2)), nu, nv)
    return edge, along, length


def places_in_space(
    patches: Patches, side: NDArray[np.int64], place: NDArray[np.int64], grid: NDArray[np.int64], inset: float
) -> NDArray[np.float64]:
    """Points on sides, moved off the outline of their patch so that neighbours in a corner do not hide them.

    Parameters
    ----------
    side, place, grid : as in `vertex_keys`
    inset : float
        Distance from the outline that every point gets at least [m]; a quarter of the patch where it is narrow.

    Returns
    -------
    (n, 3) float64 [m]
    """
    patch = side // 2
    edge_u, edge_v = patches.edge_u[patch], patches.edge_v[patch]
    share = place / grid
    twice = np.linalg.norm(np.cross(edge_u, edge_v), axis=1)
    size = np.stack(
        [np.linalg.norm(edge_v, axis=1), np.linalg.norm(edge_u, axis=1), np.linalg.norm(edge_v - edge_u, axis=1)],
        axis=1,
    )
    least = np.minimum(0.25, inset * size / np.maximum(twice, 1e-300)[:, None])
    triangle = patches.is_triangle[patch]
    inside = np.clip(share, least[:, :2], 1.0 - least[:, :2])
    thirds = np.maximum(np.column_stack([share, 1.0 - share.sum(axis=1)]), least)
    thirds /= thirds.sum(axis=1, keepdims=True)
    uv = np.where(triangle[:, None], thirds[:, :2], inside)
    moved: NDArray[np.float64] = patches.origin[patch] + uv[:, :1] * edge_u + uv[:, 1:] * edge_v
    return moved
