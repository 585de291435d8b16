"""Which of many lamps an element sends shadow rays to: all that may matter there, and a few of the others by chance;
and which one is drawn at a hit on it.

In a hall of a hundred lamps hardly ten light a desk. What the others could send without obstacles says how often each
is tried; what is found then counts as many times more, so that nothing is missed in the mean (Shirley, Wang & Zimmerman
1996, "Monte Carlo techniques for direct lighting calculations").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.space.shafts import HIDDEN
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

TRIED = 16.0
"""Lamps that an element tries in the mean; all of them where there are no more than twice as many."""
LEAST_PROBABILITY = 1.0 / 32.0
"""Of trying any lamp that an element may see: four points on it don't tell all that a lamp can do."""
BOUND_POINTS = 4
FOUND_SHARE, CLEAR_SHARE = 0.45, 0.45
"""Parts of the probability with which a lamp is drawn at a hit: by the light that a replicate found on the element, and
by what would be there without obstacles; the rest is even, so that no lamp is ever left out."""


def many_lamps(scene: DeviceScene) -> bool:
    """Whether an element tries some of the lamps only."""
    return scene.n_emitters > 2 * TRIED and scene.occlusion


def lamp_probability(
    scene: DeviceScene,
    clear: NDArray[np.float32],
    emission: NDArray[np.float32],
    sight: NDArray[np.uint8] | None,
) -> NDArray[np.float32] | None:
    """(n_rows, n_emitters) probability of trying an emitter from an element; None where all are tried.

    Parameters
    ----------
    clear : (n_rows, n_emitters) float32
        Irradiance for unit emission if nothing were in the way, see `light_without_obstacles`; rough is enough.
    emission : (n_emitters, n_columns) float32
        Exitance or intensity.
    sight : (n_rows, n_emitters) uint8, optional
        What shafts proved.
    """
    if not many_lamps(scene) or len(clear) == 0:
        return None
    light = clear * emission.mean(axis=1)
    if sight is not None:
        light[sight == HIDDEN] = 0.0
    total = light.sum(axis=1, keepdims=True)
    share = np.divide(light, total, out=np.ones_like(light), where=total > 0.0)
    chance: NDArray[np.float32] = np.clip(TRIED * share, LEAST_PROBABILITY, 1.0).astype(np.float32)
    return chance


def drawn_at_hits(
    scene: DeviceScene, direct: DeviceArray, clear: DeviceArray, emission: NDArray[np.float32]
) -> DeviceArray:
    """(n_rows, n_emitters) float32 summed probabilities of drawing an emitter at a hit on an element; ascending to 1.

    Parameters
    ----------
    direct, clear : (n_rows, n_emitters) float32 on the device
        Irradiance of each element for unit emission as it was found, estimates below 0 counting as 0; and if nothing
        were in the way.
    emission : (n_emitters, n_columns) float32
    """
    sums = scene.device.empty(direct.shape, np.float32)
    if direct.ndim == 2:
        n_rows, n_emitters = direct.shape
        scene.device.kernel("direct", "choose_lamps")(
            n_rows,
            direct=direct,
            clear=clear,
            brightness=scene.device.upload(emission.mean(axis=1, dtype=np.float64), np.float32),
            sums=sums,
            found_share=FOUND_SHARE,
            clear_share=CLEAR_SHARE,
            n_emitters=n_emitters,
        )
    return sums


def light_without_obstacles(
    scene: DeviceScene, elements: DeviceElements, *, roughly: bool = False
) -> NDArray[np.float32]:
    """(n_rows, n_emitters) irradiance for unit emission if nothing is in the way, 0 where that is proved hidden anyway;
    roughly, from far emitters by their middle alone.
    """
    n_rows, n_emitters = len(elements.elements), scene.n_emitters
    if n_rows * n_emitters == 0:
        return np.zeros((n_rows, n_emitters), np.float32)
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
