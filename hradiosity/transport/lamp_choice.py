"""Which of many lamps an element sends shadow rays to: all that may matter there, and a few of the others by chance.

In a hall of a hundred lamps hardly ten light a desk. What the others could send without obstacles says how often each
is tried; what is found then counts as many times more, so that nothing is missed in the mean (Shirley, Wang & Zimmerman
1996, "Monte Carlo techniques for direct lighting calculations").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.shafts import HIDDEN
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

TRIED = 16.0
"""Lamps that an element tries in the mean; all of them where there are no more than twice as many."""
LEAST_PROBABILITY = 1.0 / 32.0
"""Of trying any lamp that an element may see: four points on it don't tell all that a lamp can do."""
BOUND_POINTS = 4


def lamp_probability(
    scene: DeviceScene, elements: DeviceElements, emission: NDArray[np.float32], sight: NDArray[np.uint8] | None
) -> NDArray[np.float32] | None:
    """(n_rows, n_emitters) probability of trying an emitter from an element; None where all are tried.

    Parameters
    ----------
    emission : (n_emitters, n_columns) float32
        Exitance or intensity.
    sight : (n_rows, n_emitters) uint8, optional
        What shafts proved.
    """
    n_rows, n_emitters = len(elements.elements), scene.n_emitters
    if n_emitters <= 2 * TRIED or not scene.occlusion or n_rows == 0:
        return None
    light = light_without_obstacles(scene, elements, roughly=True) * emission.mean(axis=1)
    if sight is not None:
        light[sight == HIDDEN] = 0.0
    total = light.sum(axis=1, keepdims=True)
    share = np.divide(light, total, out=np.ones_like(light), where=total > 0.0)
    chance: NDArray[np.float32] = np.clip(TRIED * share, LEAST_PROBABILITY, 1.0).astype(np.float32)
    return chance


def light_without_obstacles(
    scene: DeviceScene, elements: DeviceElements, *, roughly: bool = False
) -> NDArray[np.float32]:
    """(n_rows, n_emitters) irradiance for unit emission if nothing is in the way, 0 where that is proved hidden anyway;
    roughly, from far emitters by their middle alone.
    """
    n_rows, n_emitters = len(elements.elements), scene.n_emitters
    clear = scene.device.empty((n_rows, n_emitters), np.float32)
    scene.device.kernel("direct", "bound_rows", HR_ROUGH=int(roughly))(
        n_rows * n_emitters,
        **scene.geometry,
        **elements.cells,
        **scene.emitters,
        row_sight=elements.sight(scene),
        clear=clear,
        n_points=BOUND_POINTS,
        n_emitters=n_emitters,
    )
    found: NDArray[np.float32] = scene.device.fetch(clear)
    return found
