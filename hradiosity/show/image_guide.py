"""Where the light of each row element comes from: pixels on it gather along that."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.model.scene import View
from hradiosity.show.camera import trace_view
from hradiosity.solution import Solution
from hradiosity.space.bvh import Bvh
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.hierarchy import NONE, SKY, UNLIT
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

LEVELS: Final = 4
SIDE: Final = 2**LEVELS
"""Parts along each edge of the square that stands for the hemisphere; coarser than those of readings, since the points
of an element see other things in a part anyway."""
EVEN_SHARE: Final = 0.25
"""Part of the rays that start evenly, so that none counts more than four times."""
ROWS_AT_ONCE: Final = 4096


def row_guides(
    scene: DeviceScene,
    elements: DeviceElements,
    rows: NDArray[np.int64],
    reflected: NDArray[np.float64],
    sky: float,
    seed: int,
) -> dict[str, DeviceArray]:
    """Tables of `hr_guide` with `LEVELS` levels for some row elements, by the names of the kernel's arguments.

    Parameters
    ----------
    rows : (n,) int64
        Row elements that are seen; others get none.
    reflected : (n_rows,) float64
        Brightness of what each element sends out.
    sky : float
        The same of the sky.
    """
    device, n_rows = scene.device, len(elements.elements)
    number = np.full(n_rows, NONE, np.uint32)
    number[rows] = np.arange(len(rows))
    bright = np.append(reflected, [0.0, sky])
    tables = [np.zeros((0, sum(4**level for level in range(1, LEVELS + 1))), np.float32)]
    for first in range(0, len(rows), ROWS_AT_ONCE):
        some = rows[first : first + ROWS_AT_ONCE]
        row = device.empty((len(some), SIDE * SIDE), np.uint32)
        device.kernel("image_guide", "trace_row_guides", HR_GUIDE_LEVELS=LEVELS)(
            len(some) * SIDE * SIDE,
            **scene.geometry,
            **elements.cells,
            patch_solid=scene.solid,
            rows=device.upload(some, np.uint32),
            met_row=row,
            seed=seed,
            scale=scene.scale,
        )
        found = device.fetch(row)
        place = np.where(found < UNLIT, found, np.where(found == SKY, n_rows + 1, n_rows)).astype(np.int64)
        tables.append(guide_tables(bright[place]))
    return {"row_guide": device.upload(number), "guide": device.upload(np.concatenate(tables))}


def rows_seen(solution: Solution, bvh: Bvh, views: Sequence[View]) -> NDArray[np.int64]:
    """Row elements in the middles of the pixels of some views, ascending."""
    elements, triangles = solution.elements, solution.scene.patches.is_triangle
    seen = np.zeros(len(elements), np.bool_)
    for view in views:
        hits = trace_view(bvh, view, 1)
        cell, _, _ = locate_cells(elements, triangles, hits.side, hits.u, hits.v)
        seen[elements.cell_row[cell[cell >= 0]]] = True
    return np.flatnonzero(seen)


def guide_tables(brightness: NDArray[np.float64]) -> NDArray[np.float32]:
    """Shares of the parts, (n, 4 + 16 + … + SIDE²), coarse levels first, for the brightness (n, SIDE²) found in them.

    What is found in a part is averaged with its neighbours, since one ray says little about edges.
    """
    n = len(brightness)
    wide = np.pad(brightness.reshape(n, SIDE, SIDE), ((0, 0), (1, 1), (1, 1)), mode="edge")
    rows = wide[:, :-2] + wide[:, 1:-1] + wide[:, 2:]
    blurred = rows[:, :, :-2] + rows[:, :, 1:-1] + rows[:, :, 2:]
    total = blurred.sum(axis=(1, 2), keepdims=True)
    even = 1.0 / (SIDE * SIDE)
    share = np.divide(blurred, total, out=np.full_like(blurred, even), where=total > 0.0)
    levels = [(1.0 - EVEN_SHARE) * share + EVEN_SHARE * even]
    while levels[0].shape[1] > 2:
        half = levels[0].shape[1] // 2
        levels.insert(0, levels[0].reshape(n, half, 2, half, 2).sum(axis=(2, 4)))
    return np.concatenate([level.reshape(n, -1) for level in levels], axis=1).astype(np.float32)
