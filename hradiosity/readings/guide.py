"""Where the light of a reading comes from: one ray to each part of its hemisphere, and the solution where it ends.

Paths then start in proportion to that light. A room that gets its light through a gap, or a sky seen through a small
window, is found by chance alone otherwise.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.path_tracing import Points
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.space.hierarchy import SKY, UNLIT
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

LEVELS: Final = 5
SIDE: Final = 2**LEVELS
"""Parts along each edge of the square that stands for the hemisphere; as in ``cl/include/hr_guide.h``."""
EVEN_SHARE: Final = 0.25
"""Part of the paths that start evenly, so that none counts more than four times."""


def met_rows(scene: DeviceScene, elements: DeviceElements, points: Points, seed: int) -> NDArray[np.uint32]:
    """(n_points, SIDE²) row element, or outcome, that one ray to each part of the hemisphere ends on."""
    device = scene.device
    row = device.empty((points.n, SIDE * SIDE), np.uint32)
    device.kernel("guide", "trace_guide")(
        points.n * SIDE * SIDE,
        **scene.geometry,
        **elements.cells,
        position=points.position,
        normal=points.normal,
        patch_solid=scene.solid,
        met_row=row,
        seed=seed,
        scale=scene.scale,
    )
    met: NDArray[np.uint32] = device.fetch(row)
    return met


def guide_shares(
    scene: DeviceScene, elements: DeviceElements, light: SurfaceLight, points: Points, seed: int
) -> NDArray[np.float32]:
    """(n_points, SIDE²) share of the paths that start in each part of the hemisphere, by rows; sums are 1.

    The light found in a part is averaged with that of its neighbours, since one ray says little about edges.
    """
    device = scene.device
    found = met_rows(scene, elements, points, seed)
    weight = device.fetch(light.weight).astype(np.float64)
    n_rows = len(elements.elements)
    of_rows = device.fetch(light.reflected) @ weight if n_rows else np.zeros(0)
    bright = np.append(of_rows, [0.0, device.fetch(light.sky) @ weight])
    place = np.where(found < UNLIT, found, np.where(found == SKY, n_rows + 1, n_rows)).astype(np.int64)
    return shares_of(bright[place])


def shares_of(brightness: NDArray[np.float64]) -> NDArray[np.float32]:
    """Shares (n, SIDE²) for the brightness found in the parts; even where none was found."""
    n = len(brightness)
    padded = np.pad(brightness.reshape(n, SIDE, SIDE), ((0, 0), (1, 1), (1, 1)), mode="edge")
    rows = padded[:, :-2] + padded[:, 1:-1] + padded[:, 2:]
    blurred = (rows[:, :, :-2] + rows[:, :, 1:-1] + rows[:, :, 2:]).reshape(n, -1)
    total = blurred.sum(axis=1, keepdims=True)
    even = 1.0 / (SIDE * SIDE)
    share = np.divide(blurred, total, out=np.full_like(blurred, even), where=total > 0.0)
    mixed: NDArray[np.float32] = ((1.0 - EVEN_SHARE) * share + EVEN_SHARE * even).astype(np.float32)
    return mixed


def guide_tables(shares: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, 4 + 16 + … + SIDE²) shares of all levels, coarse ones first, as ``hr_guide`` takes them."""
    n = len(shares)
    levels = [shares.astype(np.float64).reshape(n, SIDE, SIDE)]
    while levels[0].shape[1] > 2:
        half = levels[0].shape[1] // 2
        levels.insert(0, levels[0].reshape(n, half, 2, half, 2).sum(axis=(2, 4)))
    return np.concatenate([level.reshape(n, -1) for level in levels], axis=1).astype(np.float32)
