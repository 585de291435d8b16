"""Which lamps the pixels of an element take for seen, and which they try."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.space.hierarchy import NONE
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import RowHits
from hradiosity.transport.lamp_choice import lamp_probability, light_without_obstacles

LAMP_POINTS, FEW_LAMP_POINTS = 32, 8
"""Points on each element that try the lamps: all of them, or those that may matter among many."""
CLEAR_LAMPS: Final = 8
"""Lamps of an element that count by their closed forms, at most; as in ``cl/kernels/image.cl``."""
LEAST_DOUBT: Final = 0.02
"""Doubt about a lamp of which all points of an element see all or nothing, where 1/4 is the most."""
EVEN_SHARE: Final = 0.1
"""Of the probability with which lamps are tried, shared evenly."""


def lamp_tables(
    scene: DeviceScene, elements: DeviceElements, hits: RowHits, brightness: NDArray[np.float64], seed: int
) -> dict[str, DeviceArray]:
    """Device arrays by the names of the arguments of ``image_samples``.

    Parameters
    ----------
    hits : RowHits
        Of the same seed.
    brightness : (n_emitters,) float64
        Of unit irradiance by each emitter.
    """
    device, n_rows, n_emitters = scene.device, len(elements.elements), scene.n_emitters
    free = np.zeros((n_rows, n_emitters), np.float32)
    seen = np.ones(free.shape)
    if free.size:
        free = light_without_obstacles(scene, elements)
    if free.size and scene.occlusion:
        chance = lamp_probability(scene, free, brightness[:, None].astype(np.float32), None)
        points = LAMP_POINTS if chance is None else FEW_LAMP_POINTS
        tried = None if chance is None else device.upload(chance)
        direct = direct_on_rows(scene, elements, hits, points, seed, tried)
        # What was not tried counts as hidden, what was by the light that was found.
        seen = seen_shares(direct if chance is None else direct * chance, free)
    is_clear, listed = clear_lamps(seen, free * brightness)
    return {
        "lamp_choice": device.upload(summed_chances(seen, free * brightness)),
        "lamp_clear": device.upload(is_clear.astype(np.uint8)),
        "clear_lamps": device.upload(listed),
    }


def seen_shares(direct: NDArray[np.floating], free: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n_rows, n_emitters) share of each lamp's light that arrives; 0 where none could."""
    share = np.divide(direct, free, out=np.zeros(free.shape), where=free > 0.0)
    clipped: NDArray[np.float64] = np.clip(share, 0.0, 1.0)
    return clipped


def clear_lamps(seen: NDArray[np.float64], light: NDArray[np.float64]) -> tuple[NDArray[np.bool_], NDArray[np.uint32]]:
    """Which lamps count by their closed forms on each element: those mostly seen, the brightest if there are many.

    Returns
    -------
    (n_rows, n_emitters) bool
    (n_rows, CLEAR_LAMPS) uint32
        Their numbers, NONE behind the last.
    """
    n_rows, n_emitters = seen.shape
    listed = np.full((n_rows, CLEAR_LAMPS), NONE, np.uint32)
    brightness = np.where(seen > 0.5, light, 0.0)
    order = np.argsort(-brightness, axis=1, kind="stable")[:, :CLEAR_LAMPS]
    used = np.take_along_axis(brightness, order, axis=1) > 0.0
    listed[:, : order.shape[1]] = np.where(used, order, NONE)
    is_clear = np.zeros((n_rows, n_emitters), np.bool_)
    np.put_along_axis(is_clear, order, used, axis=1)
    return is_clear, listed


def summed_chances(seen: NDArray[np.float64], light: NDArray[np.float64]) -> NDArray[np.float32]:
    """(n_rows, n_emitters) ascending sums of the chances of trying each lamp.

    A shadow ray helps where it is in doubt whether a lamp is seen: in proportion to light times the spread of what one
    ray finds. The last sum is 1.
    """
    n_emitters = seen.shape[1]
    if n_emitters == 0:
        return np.zeros(seen.shape, np.float32)
    spread = light * np.sqrt(seen * (1.0 - seen) + LEAST_DOUBT)
    total = spread.sum(axis=1, keepdims=True)
    share = np.divide(spread, total, out=np.full(spread.shape, 1.0 / n_emitters), where=total > 0.0)
    sums: NDArray[np.float32] = np.cumsum((1.0 - EVEN_SHARE) * share + EVEN_SHARE / n_emitters, axis=1).astype(
        np.float32
    )
    sums[:, -1] = 1.0
    return sums
