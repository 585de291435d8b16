"""Corners of cells: what they share for smooth shading, and where they are drawn."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Light

_SAME_PLACE: Final = 1e-6
"""Corners nearer than this, over the size of the scene, are one."""
_SAME_NORMAL: Final = 1e-3
_HAIR: Final = 2e-5
"""Over the size of the scene: a thirtieth of a pixel, and more than screen coordinates are rounded by."""
_MOST_OF_EDGE: Final = 0.05
_OFFSET: Final = 0.381966
"""Of the grid on which corners are told apart: round coordinates do not lie between two of its places."""


def shared_corners(cells: Cells, light: Light) -> NDArray[np.int64]:
    """(n, 4) number of the vertex at each corner: shared by cells of one flat surface.

    That is one object, material, space and direction, like the surfaces inside which pictures have no seam.
    """
    if not len(cells):
        return np.zeros((0, 4), np.int64)
    low, high = cells.corners.min(axis=(0, 1)), cells.corners.max(axis=(0, 1))
    step = _SAME_PLACE * max(float(np.linalg.norm(high - low)), 1e-30)
    place = np.floor((cells.corners - low) / step + _OFFSET).astype(np.int64)
    key = _mixed(place.reshape(-1, 3)) * np.uint64(31) + np.repeat(_surface_keys(cells, light), 4)
    number: NDArray[np.int64] = np.unique(key, return_inverse=True)[1].reshape(-1, 4)
    return number


def surface_kinds(cells: Cells, light: Light) -> NDArray[np.int64]:
    """(n,) number of the object, material, space and direction of each cell together."""
    kinds: NDArray[np.int64] = np.unique(_surface_keys(cells, light), return_inverse=True)[1].reshape(-1)
    return kinds


def _surface_keys(cells: Cells, light: Light) -> NDArray[np.uint64]:
    facing = np.floor(cells.normal / _SAME_NORMAL + _OFFSET).astype(np.int64)
    return _mixed(np.column_stack([cells.object, cells.material, light.space[cells.element], facing]))


def corner_means(
    cells: Cells, light: Light, vertex: NDArray[np.int64], values: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(n, 4, c) at each corner, the mean of values (n, c) over the cells that meet there, weighted with exposed area.

    The weights are those of `hradiosity.show.light`.
    """
    weight = np.repeat(cells.area * (1e-6 + light.exposed[cells.element]), 4)
    weight[3::4][cells.is_triangle] = 0.0
    flat = vertex.ravel()
    count = int(flat.max(initial=-1)) + 1
    total = np.bincount(flat, weight, count)
    total = np.where(total > 0.0, total, 1.0)
    means = [np.bincount(flat, weight * np.repeat(column, 4), count) / total for column in values.T]
    return np.stack(means, axis=1)[vertex]


def _mixed(keys: NDArray[np.int64]) -> NDArray[np.uint64]:
    """(n,) one number for each row (n, k): 64-bit mixing (Steele, Lea & Flood 2014), column after column."""
    out = np.zeros(len(keys), np.uint64)
    for column in keys.T:
        out = (out ^ column.astype(np.uint64)) + np.uint64(0x9E3779B97F4A7C15)
        out = (out ^ (out >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        out = (out ^ (out >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        out ^= out >> np.uint64(31)
    return out


def swollen(cells: Cells) -> NDArray[np.float64]:
    """(n, 4, 3) corners, a hair farther out: else the ground shines through where a corner lies on another's edge."""
    corners = cells.corners
    count = np.where(cells.is_triangle, 3, 4)[:, None]
    turn = np.arange(4)
    rows = np.arange(len(cells))[:, None]
    after = corners[rows, (turn + 1) % count] - corners
    before = corners[rows, (np.minimum(turn, count - 1) - 1) % count] - corners
    after[cells.is_triangle, 3] = after[cells.is_triangle, 2]
    lengths = [np.linalg.norm(edge, axis=2, keepdims=True) for edge in (after, before)]
    outwards = sum(-edge / np.maximum(length, 1e-300) for edge, length in zip((after, before), lengths, strict=True))
    shortest = lengths[0].min(axis=1, keepdims=True)
    hair = np.minimum(_HAIR * float(np.linalg.norm(np.subtract(*cells.bounds))), _MOST_OF_EDGE * shortest)
    out: NDArray[np.float64] = corners + hair * outwards
    return out
