"""Parts of hemispheres that lead to places which are known to pass much light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import SIDE


def parts_towards(
    position: NDArray[np.float64], normal: NDArray[np.float64], place: NDArray[np.float64]
) -> NDArray[np.int64]:
    """(n, n_places) part of each hemisphere, by rows, in which a place lies; −1 for those behind.

    Parameters
    ----------
    position, normal : (n, 3) float64
        In the frame of the places [m], unit normals.
    place : (n_places, 3) float64 [m]
    """
    way = place[None] - position[:, None]
    distance = np.linalg.norm(way, axis=2, keepdims=True)
    way = np.divide(way, distance, out=np.zeros_like(way), where=distance > 0.0)
    tangent, bitangent = _tangents(normal)
    x, y, z = (np.einsum("npc,nc->np", way, axis) for axis in (tangent, bitangent, normal))
    u, v = _square_of_disk(x, y)
    column, row = (np.clip(np.floor(SIDE * some), 0, SIDE - 1).astype(np.int64) for some in (u, v))
    return np.where(z > 0.0, row * SIDE + column, -1)


def _tangents(n: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The frame about unit normals (n, 3) that rays are drawn in, as `hr_tangents` in ``cl/include/hr_types.h``."""
    x, y, z = n.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    c = x * y * a
    one = np.column_stack([1.0 + sign * x * x * a, sign * c, -sign * x])
    return one, np.column_stack([c, sign + y * y * a, -y])


def _square_of_disk(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points of the unit square that the concentric map (Shirley & Chiu 1997) takes to points of the unit disk."""
    wide = np.abs(x) > np.abs(y)
    along, across = np.where(wide, x, y), np.where(wide, y, x)
    radius = np.copysign(np.hypot(x, y), along)
    angle = np.arctan2(across * np.sign(along), np.abs(along))
    other = radius * angle / (np.pi / 4.0)
    a, b = np.where(wide, radius, other), np.where(wide, other, radius)
    return 0.5 * (a + 1.0), 0.5 * (b + 1.0)
