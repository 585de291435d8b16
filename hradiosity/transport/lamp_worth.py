"""Points of elements from which rays go to lamps: more of them where their noise would be that of the readings."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.shafts import UNKNOWN
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.lamp_doubt import seen_from_points

PILOT_POINTS: Final = 8
FURTHER_POINTS: Final = 24
"""Points of each element that tell, once, what it sees of each lamp; the second where the first found nothing."""
EXTRA: Final = 2.0
"""Points that are added, at most, over those that the plan has for all elements."""
MOST_TIMES: Final = 64.0
"""Points of an element over those of the plan."""


def points_by_worth(
    scene: DeviceScene,
    elements: DeviceElements,
    clear: NDArray[np.float32],
    worth: NDArray[np.float64],
    sight: NDArray[np.uint8] | None,
    n_points: int,
    seed: int,
    *,
    tolerance: float,
) -> NDArray[np.uint32] | None:
    """(n_rows, n_emitters) points from which a ray goes to an emitter in a replicate; None if `n_points` do for all.

    Points are in proportion to the error of the mean reading by one of them (Neyman 1934).

    Parameters
    ----------
    clear : (n_rows, n_emitters) float32
        Irradiance for unit emission if nothing were in the way.
    worth : (n_rows, n_emitters) float64
        Change of the mean reading, relative to it, by that light.
    sight : (n_rows, n_emitters) uint8, optional
        What shafts proved.
    seed : int
        Of the pilot, which replicates have no part in: their light stays without bias.
    tolerance : float
        Standard error of the mean reading, relative to it, up to which nothing is done.
    """
    n_rows = len(elements.elements)
    if not scene.occlusion or n_rows == 0 or scene.n_emitters == 0:
        return None
    doubt = clear > 0.0 if sight is None else (clear > 0.0) & (sight == UNKNOWN)
    error = np.where(doubt, worth, 0.0)
    if float((error**2).sum()) / (4.0 * n_points) <= tolerance**2:
        return None
    place, upload = (scene, elements), scene.device.upload
    seen = seen_from_points(*place, PILOT_POINTS, seed, upload(doubt, np.float32)).astype(np.float64)
    again = doubt & (seen == 0.0)
    more = seen_from_points(*place, FURTHER_POINTS, seed + 1, upload(again, np.float32)).astype(np.float64)
    seen += np.where(again, more * FURTHER_POINTS / (PILOT_POINTS + FURTHER_POINTS), 0.0)
    open_share = np.clip(np.divide(seen, clear, out=np.zeros_like(seen), where=clear > 0.0), 0.0, 1.0)
    rays = np.where(again, PILOT_POINTS + FURTHER_POINTS, PILOT_POINTS)
    likely = np.where(open_share > 0.0, np.minimum(open_share, 1.0 - 0.5 / rays), 0.0)
    error *= np.sqrt(likely * (1.0 - likely))
    if float((error**2).sum()) / n_points <= tolerance**2:
        return None
    room = (1.0 + EXTRA) * n_rows * scene.n_emitters
    low, high = 0.0, MOST_TIMES / float(error[error > 0.0].min())
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.clip(middle * error, 1.0, MOST_TIMES).sum() <= room else (low, middle)
    return np.rint(n_points * np.clip(low * error, 1.0, MOST_TIMES)).astype(np.uint32)
