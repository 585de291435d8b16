"""Light of the lamps on the elements: how often each is tried, and from how many points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.space.shafts import UNKNOWN
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import RowHits
from hradiosity.transport.lamp_choice import drawn_at_hits, lamp_probability, light_without_obstacles, many_lamps
from hradiosity.transport.lamp_doubt import points_for_lamps

POINTS_SEED = 0x7F4A7C15
"""Of the pilot that tells where lamps call for more points; no replicate has this seed."""


@dataclass(frozen=True)
class RowLamps:
    """What replicates need to know of elements and lamps.

    emission : (n_emitters, n_columns) float32, exitance or intensity
    sight : (n_rows, n_emitters) uint8, what shafts proved; None without them
    clear : (n_rows, n_emitters) float32 on the device, irradiance for unit emission if nothing were in the way
    chance : (n_rows, n_emitters) float32 on the device, of trying each lamp; None where all are tried
    points : (n_rows, n_emitters) uint32 on the device, from which a ray goes to each lamp; None for the plan's number
    tried : lamps that all elements try in all, on average; None where all are tried
    """

    scene: DeviceScene
    elements: DeviceElements
    emission: NDArray[np.float32]
    sight: NDArray[np.uint8] | None
    clear: DeviceArray
    chance: DeviceArray | None
    points: DeviceArray | None
    tried: float | None

    @classmethod
    def of(
        cls,
        scene: DeviceScene,
        elements: DeviceElements,
        emission: NDArray[np.float32],
        sight: NDArray[np.uint8] | None,
        n_points: int,
        seed: int,
    ) -> RowLamps:
        """Of `n_points` from each element to each lamp in a replicate, with a run's seed."""
        device = scene.device
        clear = light_without_obstacles(scene, elements, roughly=many_lamps(scene))
        chance, points = lamp_probability(scene, clear, emission, sight), None
        if chance is None:
            points = points_for_lamps(scene, elements, clear, emission, sight, n_points, seed ^ POINTS_SEED)
        return cls(
            scene,
            elements,
            emission,
            sight,
            clear=device.upload(clear),
            chance=None if chance is None else device.upload(chance),
            points=None if points is None else device.upload(points),
            tried=None if chance is None else float(chance.sum()),
        )

    def direct(
        self, hits: RowHits, n_points: int, seed: int, points: DeviceArray | None = None
    ) -> tuple[NDArray[np.float32], int]:
        """(n_rows, n_emitters) direct light for unit emission in one replicate, and the rays that it took.

        Parameters
        ----------
        points : (n_rows, n_emitters) uint32 on the device, optional
            From which a ray goes to each lamp, as a replicate's light showed it.
        """
        wanted = self.points if points is None else points
        found = direct_on_rows(self.scene, self.elements, hits, n_points, seed, self.chance, wanted)
        traced = found.size if self.sight is None else int(np.count_nonzero(self.sight == UNKNOWN))
        traced = traced if self.tried is None else min(traced, round(self.tried))
        return found, traced * n_points

    def choice(self, row_direct: DeviceArray) -> DeviceArray:
        """`SurfaceLight.emitter_choice` for the direct light of a replicate."""
        return drawn_at_hits(self.scene, row_direct, self.clear, self.emission)
