"""Elements that see a small part of a lamp only: the few points that serve others mostly miss it there.

Behind a narrow gap a lamp's light falls on a strip of each surface, where four rays of a replicate find it one time in
two or three. It may be much of the light of a dark room, and its noise is common to all that is read there.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.space.shafts import UNKNOWN
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import RowHits

PILOT_POINTS: Final = 8
"""Points of each element that tell, once, what it sees of each lamp."""
DOUBTFUL: Final = 0.3
"""All direct light of an element over what it would get from one lamp without obstacles: below that share, more points
look for the lamp if one of the pilot's has seen it. From there on four of them tell the light to 80 %."""
TIMES: Final = 8
"""More points."""


def points_for_lamps(
    scene: DeviceScene,
    elements: DeviceElements,
    clear: NDArray[np.float32],
    emission: NDArray[np.float32],
    sight: NDArray[np.uint8] | None,
    n_points: int,
    seed: int,
) -> NDArray[np.uint32] | None:
    """(n_rows, n_emitters) points from which a ray goes to an emitter in a replicate; None if it is `n_points` for all.

    Parameters
    ----------
    clear : (n_rows, n_emitters) float32
        Irradiance for unit emission if nothing were in the way.
    emission : (n_emitters, n_columns) float32
        Exitance or intensity.
    sight : (n_rows, n_emitters) uint8, optional
        What shafts proved.
    seed : int
        Of the pilot, which replicates have no part in: their light stays without bias.
    """
    n_rows = len(elements.elements)
    if not scene.occlusion or n_rows == 0 or scene.n_emitters == 0:
        return None
    bright = emission.mean(axis=1)
    seen = seen_from_points(scene, elements, PILOT_POINTS, seed) * bright
    doubtful = (seen > 0.0) & (seen.sum(axis=1, keepdims=True) < DOUBTFUL * clear * bright)
    if sight is not None:
        doubtful &= sight == UNKNOWN
    return np.where(doubtful, TIMES * n_points, n_points).astype(np.uint32) if doubtful.any() else None


def seen_from_points(
    scene: DeviceScene, elements: DeviceElements, n_points: int, seed: int, chance: DeviceArray | None = None
) -> NDArray[np.float32]:
    """(n_rows, n_emitters) light for unit emission by some points of each element, whether they are covered or not.

    Parameters
    ----------
    chance : (n_rows, n_emitters) float32 on the device, optional
        Of trying each lamp, see `hradiosity.transport.direct.direct_on_rows`.
    """
    exposed = np.zeros((len(elements.elements), n_points), np.uint32)
    hits = RowHits(exposed, exposed, scene.device.upload(exposed))
    return direct_on_rows(scene, elements, hits, n_points, seed, chance)
