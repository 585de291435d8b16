"""Readings by unbiased paths alone, to judge the solver by."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hradiosity.device import Device
from hradiosity.model.scene import Scene
from hradiosity.readings.composition import Composition
from hradiosity.readings.moments import ReadingMoments, ReplicateReadings
from hradiosity.readings.path_scene import prepare_referee
from hradiosity.readings.paths import PathTotals, RefereeSamples, rounds, trace_round
from hradiosity.solution import Readings
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.parted import part_back_to_back
from hradiosity.transport.device_scene import upload_scene


@dataclass(frozen=True)
class RefereeState:
    """Where a run stands.

    paths, wanted : paths from each reading, traced and wanted
    rays : traced so far
    seconds, cpu_seconds : since the start; the latter without reading the scene
    error, median_error : largest and median half width over value of the readings' illuminance (see
        `Readings.accuracy`); 0 without readings
    """

    paths: int
    wanted: int
    rays: int
    seconds: float
    cpu_seconds: float
    error: float
    median_error: float


class Referee:
    """A run that can be followed round by round, interrupted, and asked for its readings at any time.

    Parameters
    ----------
    scene : Scene
    device : Device
    paths_per_reading : int
        Rounded up to as many in each scramble.
    seed : int
    """

    def __init__(self, scene: Scene, device: Device, paths_per_reading: int, seed: int = 0) -> None:
        if paths_per_reading < 1:
            raise ValueError(f"paths_per_reading must be at least 1, is {paths_per_reading}")
        scene = part_back_to_back(scene)
        self.scene, self.device, self.seed = scene, device, seed
        self.cpu_seconds = 0.0
        self._wanted = paths_per_reading
        self._start = time.perf_counter()
        self._planes = Composition(scene.sensors, scene)
        self._totals = PathTotals(len(self._planes.position), len(scene.bands))

    def states(self) -> Iterator[RefereeState]:
        """Run, yielding after each round; whoever stops asking keeps what is known so far."""
        cpu = self.device.work_cpu_seconds()
        bvh = build_bvh(self.device, self.scene.patches)
        referee = prepare_referee(upload_scene(self.device, self.scene, bvh, occlusion=True), self.scene)
        planes = self._planes
        parts = rounds(referee, len(planes.position), self._wanted)
        wanted = sum(count for _, count in parts)
        for first, count in parts:
            sums = trace_round(
                referee,
                planes.position,
                planes.normal,
                first_path=first,
                n_paths=count,
                seed=self.seed,
                response=planes.response,
            )
            self._totals.add(sums, count)
            self.cpu_seconds += self.device.work_cpu_seconds() - cpu
            yield self._state(wanted)
            cpu = self.device.work_cpu_seconds()

    def samples(self) -> RefereeSamples:
        """Spectra of all planes that readings are made of, in the order of the sensors.

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
        return scramble_moments(self.scene, self._totals.samples()).readings()

    def _state(self, wanted: int) -> RefereeState:
        samples = self._totals.samples()
        errors = scramble_moments(self.scene, samples).errors()
        scrambles = len(samples.per_scramble)
        return RefereeState(
            paths=samples.paths,
            wanted=wanted * scrambles,
            rays=samples.rays,
            seconds=time.perf_counter() - self._start,
            cpu_seconds=self.cpu_seconds,
            error=float(errors.max(initial=0.0)),
            median_error=float(np.median(errors)) if len(errors) else 0.0,
        )


def scramble_moments(scene: Scene, samples: RefereeSamples) -> ReadingMoments:
    """Readings with intervals from the spread of the scrambles: every one is a replicate."""
    moments = ReadingMoments(scene.sensors, scene.bands, scene=scene)
    for spectra in samples.per_scramble:
        moments.add(ReplicateReadings(spectra, samples.enclosed))
    return moments


def run_referee(
    scene: Scene,
    device: Device,
    paths_per_reading: int,
    seed: int = 0,
    progress: Callable[[RefereeState], None] | None = None,
) -> dict[str, Readings]:
    """Unbiased readings of all sensors, by name.

    Parameters
    ----------
    progress : callable, optional
        Called after each round. An exception that it raises ends the run; to keep what is known, use `Referee`.
    """
    referee = Referee(scene, device, paths_per_reading, seed)
    for state in referee.states():
        if progress is not None:
            progress(state)
    return referee.readings()
