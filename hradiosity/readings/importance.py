"""What readings see of the row elements themselves, each reading counting by its own relative error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.path_tracing import upload_points
from hradiosity.readings.pilot_light import met_rows
from hradiosity.space.hierarchy import UNLIT
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_at_points

MOST_READINGS: Final = 32
"""Readings that stand for all of them, evenly from first to last."""
DIRECT_SAMPLES: Final = 16
DARK: Final = 0.05
"""Share of the mean reading that darker ones count like."""


@dataclass(frozen=True)
class SeenRows:
    """What readings see.

    change : (n_rows,) float64, by how much the mean reading changes, relative to itself, with the exitance of each row
    n_rays : int, that this took
    """

    change: NDArray[np.float64]
    n_rays: int


def seen_rows(
    scene: DeviceScene,
    elements: DeviceElements,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    leaving: NDArray[np.float64],
    emission: NDArray[np.float64],
    seed: int,
) -> SeenRows:
    """Rays from readings, evenly over what they see.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    leaving : (n_rows,) float64
        Brightness of what each row reflects.
    emission : (n_emitters,) float64
        Brightness of the emitters.
    seed : int
    """
    n_rows = len(leaving)
    some = np.unique(np.linspace(0, len(position) - 1, MOST_READINGS).astype(np.int64))
    points = upload_points(scene, position[some], normal[some])
    met = met_rows(scene, elements, points, seed)
    place = np.where(met < UNLIT, met, n_rows).astype(np.int64)
    direct = direct_at_points(scene, position[some], normal[some], DIRECT_SAMPLES, seed).astype(np.float64)
    reading = np.append(leaving, 0.0)[place].mean(axis=1) + np.einsum("xe,e->x", direct, emission)
    least = max(DARK * float(reading.mean()), np.finfo(np.float64).tiny)
    weight = 1.0 / (np.maximum(reading, least) * met.size)
    seen = np.bincount(place.ravel(), np.repeat(weight, met.shape[1]), n_rows + 1)
    return SeenRows(seen[:n_rows].astype(np.float64), met.size + DIRECT_SAMPLES * direct.size)
