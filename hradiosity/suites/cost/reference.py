"""A referee that goes on for as long as there is time, in rounds that grow."""

from __future__ import annotations

import math
import time
from typing import Final

import numpy as np

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.model.scene import Scene
from hradiosity.radiosity.referee import scramble_moments
from hradiosity.readings.composition import Composition
from hradiosity.readings.path_scene import prepare_referee
from hradiosity.readings.paths import ROUND_PATHS, SCRAMBLES, PathSums, PathTotals, RefereeSamples, trace_round
from hradiosity.solution import Readings
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene

SEED: Final = 0x7F4A7C15
"""Far from the seeds of users, so that runs and reference share no random numbers."""
GROWTH: Final = 4
"""Paths of a round over those before it, at most."""
ROUND_SHARE: Final = 0.25
"""Of the time that is left, which one round may take."""


class GrowingReference:
    """Unbiased readings of a scene, better the longer they are left alone.

    Parameters
    ----------
    scene : Scene
    device : Device
    kept : RefereeSamples, optional
        Of an earlier run of the same scene, to go on from.
    """

    def __init__(self, scene: Scene, device: Device, kept: RefereeSamples | None = None) -> None:
        self.cpu_seconds = 0.0
        self._scene, self._device = scene, device
        self._planes = Composition(scene.sensors, scene)
        self._totals = PathTotals(len(self._planes.position), len(scene.bands))
        on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
        self._referee = prepare_referee(on_device, scene)
        self._step = max(1, round(1.0 / self._referee.direct_share))
        self._seconds_per_path = math.inf
        if kept is not None:
            self._take(kept)

    @property
    def paths(self) -> int:
        """From each reading so far."""
        return self._totals.paths * SCRAMBLES

    def advance(self, seconds: float) -> bool:
        """One round that should fit into the wall seconds; False when none does."""
        count = self._next_count(seconds)
        if count == 0:
            return False
        built = self._device.build_time.wall
        wall, cpu = time.perf_counter(), self._device.work_cpu_seconds()
        self._totals.add(
            trace_round(
                self._referee,
                self._planes.position,
                self._planes.normal,
                first_path=self._totals.paths,
                n_paths=count,
                seed=SEED,
                response=self._planes.response,
            ),
            count,
        )
        building = self._device.build_time.wall - built
        self._seconds_per_path = (time.perf_counter() - wall - building) / count
        self.cpu_seconds += self._device.work_cpu_seconds() - cpu
        return True

    def samples(self) -> RefereeSamples:
        """All paths so far, to be kept.

        Raises
        ------
        RuntimeError
            Before the first round.
        """
        return self._totals.samples()

    def readings(self) -> dict[str, Readings]:
        """What is known so far, by sensor name; half widths from the spread of the scrambles.

        Raises
        ------
        RuntimeError
            Before the first round.
        """
        return scramble_moments(self._scene, self._totals.samples()).readings()

    def noise(self) -> float:
        """Standard error of the illuminances over their values, root mean square; infinite before the first round."""
        if not self.paths:
            return math.inf
        found = self.readings().values()
        value = np.concatenate([f.illuminance for f in found])
        error = np.concatenate([f.illuminance_half_width for f in found]) / student_quantile(0.95, SCRAMBLES - 1)
        lit = value > 0.0
        return float(np.sqrt(np.mean((error[lit] / value[lit]) ** 2))) if lit.any() else 0.0

    def _next_count(self, seconds: float) -> int:
        """Paths of each scramble in the next round: `GROWTH` times those before, if time and device allow."""
        done = self._totals.paths
        if not math.isfinite(self._seconds_per_path):
            return self._step
        fits = seconds / self._seconds_per_path
        if fits < self._step:
            return 0
        usual = ROUND_PATHS // max(len(self._planes.position) * SCRAMBLES, 1)
        most = max(self._step, min(GROWTH * done, usual, int(ROUND_SHARE * fits)))
        return self._step * (1 << int(math.log2(most / self._step)))

    def _take(self, kept: RefereeSamples) -> None:
        """Count the paths of an earlier run."""
        done = kept.paths // SCRAMBLES
        weights = kept.paths * len(self._planes.position)
        sums = PathSums(kept.per_scramble * done, kept.enclosed * kept.paths, kept.lost_weight * weights, kept.rays)
        self._totals.add(sums, done)
