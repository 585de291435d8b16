"""Reflected light on the row elements, gathered once more for smooth pictures.

The solution needs few rays from each element, since readings average over many elements; side by side in a picture
the same noise shows as blotches.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from hradiosity.solution import Solution
from hradiosity.space.hierarchy import COVERED, UNLIT
from hradiosity.transport.device_scene import DeviceScene, upload_elements
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.glow import glow_of

RAYS: Final = 4_000_000
"""From all elements together."""
LEAST_RAYS, MOST_RAYS = 64, 512
"""From one."""


def gather_rows(solution: Solution, on_device: DeviceScene) -> NDArray[np.float64]:
    """(n_rows, n_bands) irradiance of the elements by what others reflect, and by weak lamps [W m⁻² per band].

    The mean exitance of the elements that cosine-distributed rays meet; independent of the exchange that was solved.
    """
    elements = solution.elements
    n_rows = len(elements)
    if n_rows == 0:
        return np.zeros((0, len(solution.scene.bands)))
    n_samples = int(np.clip(RAYS // n_rows, LEAST_RAYS, MOST_RAYS))
    hits = trace_rows(on_device, upload_elements(on_device.device, elements), n_samples, seed=_seed(solution))
    met = hits.row < UNLIT
    exposed = n_samples - (hits.row == COVERED).sum(axis=1)
    start = np.concatenate([[0], np.cumsum(met.sum(axis=1))])
    share = np.repeat(1.0 / np.maximum(exposed, 1), np.diff(start)).astype(np.float32)
    rays = csr_array((share, hits.row[met].astype(np.int64), start), shape=(n_rows, n_rows))
    gathered: NDArray[np.float64] = (rays @ _exitance(solution)).astype(np.float64)
    return gathered


def _exitance(solution: Solution) -> NDArray[np.float32]:
    """(n_rows, n_bands) what the elements send out apart from the lamps that get shadow rays."""
    scene, elements, plan = solution.scene, solution.elements, solution.plan
    reflectance = np.concatenate([scene.reflectance, np.zeros((1, len(scene.bands)))])
    exitance = reflectance[elements.row_material] * solution.surfaces.irradiance * plan.interreflection
    glow = glow_of(scene, plan.columns, plan.weak_emitters)
    side = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    exitance += plan.columns.to_bands(glow.exitance)[glow.paint.ravel()[side]]
    return exitance.astype(np.float32)


def _seed(solution: Solution) -> int:
    """Of the picture's own random numbers."""
    return int(solution.record["options"]["seed"]) ^ 0x7F4A7C15
