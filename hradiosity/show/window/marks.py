"""Sensors with normals, lamps with aims, cameras: as points and lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Drawn
from hradiosity.model.scene import View
from hradiosity.show.camera import view_axes

ARROW: Final = 0.02
"""Length of a sensor's normal at most, over the size of the scene."""
CLOSE: Final = 0.7
"""Of a sensor's normal at most, over the distance of the next sensor."""
AIM: Final = 0.09
CAMERA: Final = 0.06
_BARB: Final = 0.25


@dataclass(frozen=True)
class Lines:
    """start, end : (n, 3) float64 [m]."""

    start: NDArray[np.float64]
    end: NDArray[np.float64]


def joined(*parts: Lines) -> Lines:
    """All lines together."""
    none = np.zeros((0, 3))
    return Lines(
        np.concatenate([none, *(part.start for part in parts)]), np.concatenate([none, *(part.end for part in parts)])
    )


def scene_size(cells: Cells) -> float:
    """Diagonal of the box around all cells [m]."""
    low, high = cells.bounds
    return max(float(np.linalg.norm(high - low)), 1e-9)


def arrows(start: NDArray[np.float64], direction: NDArray[np.float64], length: float | NDArray[np.float64]) -> Lines:
    """Arrows of a length, or of lengths (n, 1), along unit vectors (n, 3), each with two barbs."""
    end = start + length * direction
    other = np.where(np.abs(direction[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    across = np.cross(direction, other)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    back = end - _BARB * length * direction
    barb = 0.5 * _BARB * length * across
    return Lines(np.concatenate([start, end, end]), np.concatenate([end, back + barb, back - barb]))


def sensor_arrows(drawn: Drawn) -> NDArray[np.float64]:
    """(n,) length of the arrow of each reading [m], shorter where those of a sensor stand close together."""
    sensors, longest = drawn.sensors, ARROW * scene_size(drawn.cells)
    names = np.array(sensors.sensor)
    length = np.full(len(sensors), longest)
    for name in dict.fromkeys(sensors.sensor):
        those = np.flatnonzero(names == name)
        gaps = np.linalg.norm(np.diff(sensors.position[those], axis=0), axis=1)
        gaps = gaps[gaps > 0.0]
        if len(gaps):
            length[those] = min(longest, CLOSE * float(gaps.min()))
    return length


def sensor_lines(drawn: Drawn) -> Lines:
    """Normals of planes, axes of cylinders, lines of sight."""
    sensors = drawn.sensors
    return arrows(sensors.position, sensors.normal, sensor_arrows(drawn)[:, None])


def sensor_marks(drawn: Drawn) -> NDArray[np.float64]:
    """(n, 3) where readings are marked and picked [m]: lines of sight, which share an eye, at their ends."""
    sensors = drawn.sensors
    along = np.where(sensors.looks, sensor_arrows(drawn), 0.0)[:, None]
    marks: NDArray[np.float64] = sensors.position + along * sensors.normal
    return marks


def lamp_places(cells: Cells) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(k, 3) middles and (k, 3) normals of the shining sides, one for all cells of a patch side."""
    shining = np.flatnonzero(cells.luminaire >= 0)
    side = 2 * cells.patch[shining].astype(np.int64) + cells.side[shining]
    _, first, number = np.unique(side, return_index=True, return_inverse=True)
    area = cells.area[shining]
    corners = cells.corners[shining]
    middle = np.where(cells.is_triangle[shining, None], corners[:, :3].mean(axis=1), corners.mean(axis=1))
    total = np.maximum(np.bincount(number, area, len(first)), 1e-300)
    places = np.stack([np.bincount(number, area * middle[:, k], len(first)) / total for k in range(3)], axis=1)
    return places, cells.normal[shining[first]]


def lamp_lines(drawn: Drawn, size: float) -> Lines:
    """Aims of area lamps; three crossed lines at point sources, which shine everywhere."""
    places, normals = lamp_places(drawn.cells)
    points, half = drawn.lamps.position, 0.3 * AIM * size
    crosses = [Lines(points - half * axis, points + half * axis) for axis in np.eye(3)]
    return joined(arrows(places, normals, AIM * size), *crosses)


def camera_lines(views: tuple[View, ...], size: float) -> Lines:
    """A pyramid for each camera, with a line upwards."""
    parts = []
    for view in views:
        forward, right, down = CAMERA * size * view_axes(view)
        far = view.position + forward
        corners = np.array([far - right - down, far + right - down, far + right + down, far - right + down])
        tip = np.broadcast_to(view.position, (4, 3))
        roof = np.repeat([far - 1.6 * down], 2, axis=0)
        parts += [Lines(tip, corners), Lines(corners, np.roll(corners, -1, axis=0)), Lines(corners[:2], roof)]
    return joined(*parts)
