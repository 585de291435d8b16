"""Interpolation in leaves: triangles around the centre, without gaps where leaves of two sizes meet."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.leaves import CENTRE, NONE

_FIRST_MIDDLE: Final = CENTRE + 1
EDGE_ENDS: Final = np.array([[[0, 1], [1, 2], [2, 3], [3, 0]], [[0, 1], [1, 2], [2, 0], [2, 0]]], np.int64)
"""(2, 4, 2) places at both ends of each edge, of parallelograms and of triangles, which repeat the last edge."""


def fan_weights(
    vertex: NDArray[np.int32],
    node: NDArray[np.integer],
    s: NDArray[np.float32],
    t: NDArray[np.float32],
    triangle: NDArray[np.bool_],
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Vertices around points, and their weights in piecewise linear interpolation.

    A leaf is the fan of triangles from its centre to its outline; an edge is cut in two where a vertex of a finer
    leaf lies on its middle. Both sides of an edge thus interpolate between the same vertices.

    Parameters
    ----------
    vertex : (n_nodes, 9) int32
        Vertices of each leaf, see `leaves.PLACES`; NONE where an edge is whole.
    node : (n,) int
    s, t : (n,) float32
        In the leaf's frame.
    triangle : (n,) bool

    Returns
    -------
    vertices : (n, 3) int32
    weights : (n, 3) float32, sum 1
    """
    edge, along, outward = _polar(s, t, triangle)
    ends = EDGE_ENDS[triangle.astype(np.int64), edge]
    first, last = vertex[node, ends[:, 0]], vertex[node, ends[:, 1]]
    middle = vertex[node, _FIRST_MIDDLE + edge]
    cut = middle != NONE
    later = cut & (along >= 0.5)
    along = np.where(cut, 2.0 * along - later, along).astype(np.float32)
    vertices = np.stack(
        [vertex[node, CENTRE], np.where(later, middle, first), np.where(cut & ~later, middle, last)], axis=1
    )
    return vertices, np.stack([1.0 - outward, outward * (1.0 - along), outward * along], axis=1)


def _polar(
    s: NDArray[np.float32], t: NDArray[np.float32], triangle: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Edge that the ray from the centre through each point meets, where along it, and how far out the point is."""
    x, y = s - np.float32(0.5), t - np.float32(0.5)
    upright = np.abs(y) >= np.abs(x)
    edge = np.where(upright, np.where(y < 0.0, 0, 2), np.where(x > 0.0, 1, 3))
    outward = np.float32(2.0) * np.maximum(np.abs(x), np.abs(y))
    step = np.where(upright, np.where(y < 0.0, x, -x), np.where(x > 0.0, y, -y))
    along = np.float32(0.5) + step / np.maximum(outward, np.float32(1e-12))
    if triangle.any():
        three = np.stack([t, np.float32(1.0) - s - t, s], axis=1)[triangle]
        opposite = np.argmin(three, axis=1)
        least = three.min(axis=1)
        out = np.float32(1.0) - np.float32(3.0) * least
        ahead = np.take_along_axis(three[:, [2, 0, 1]], opposite[:, None], axis=1)[:, 0]
        edge[triangle] = opposite
        outward[triangle] = out
        along[triangle] = (ahead - least) / np.maximum(out, np.float32(1e-12))
    return edge, np.clip(along, 0.0, 1.0).astype(np.float32), np.clip(outward, 0.0, 1.0).astype(np.float32)
