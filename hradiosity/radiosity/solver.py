"""The replicate loop: surfaces, then readings, until they are as accurate as asked for."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Scene, Sensor
from hradiosity.options import Options
from hradiosity.plan import Plan
from hradiosity.planning import make_plan
from hradiosity.radiosity.surfaces import Record, SurfaceSolver
from hradiosity.readings.interval import RunningMoments
from hradiosity.readings.sensors import read_points
from hradiosity.solution import Readings, Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.lit_sides import find_lit_sides

MAX_REPLICATES = 256


@dataclass(frozen=True)
class State:
    """Where a run stands.

    stage : what was just finished
    replicate, replicates : done, and wanted so far
    seconds : wall seconds since the start
    error, median_error : largest and median half width over value of all readings (see `Readings.accuracy`);
        infinite before two replicates
    elements, rays : row elements, and rays traced so far
    unshot : relative residual of the last solution
    """

    stage: str
    replicate: int
    replicates: int
    seconds: float
    error: float
    median_error: float
    elements: int
    rays: int
    unshot: float


def solve(scene: Scene, options: Options | None = None, device: Device | None = None) -> Solution:
    """Light everywhere in the scene; see `RadiositySolver` to follow the run or to read further points."""
    solver = RadiositySolver(scene, options or Options(), device or Device())
    for _ in solver.states():
        pass
    return solver.solution()


class RadiositySolver:
    """One run that can be followed state by state, interrupted, and asked for its solution at any time.

    Parameters
    ----------
    scene : Scene
    options : Options
    device : Device
    """

    def __init__(self, scene: Scene, options: Options, device: Device, calibration: Calibration | None = None) -> None:
        self.scene, self.options, self.device = scene, options, device
        self.record = Record()
        self.cpu_seconds = 0.0
        self._calibration = calibration
        self._start = time.perf_counter()
        self._readings = ReadingMoments(scene.sensors, scene.bands)
        self._surfaces: SurfaceSolver | None = None
        self._kept = KeptLight()

    def states(self) -> Iterator[State]:
        """Run, yielding after each stage; whoever stops asking keeps what is known so far."""
        cpu = time.process_time()
        surfaces = self._prepare()
        self.cpu_seconds += time.process_time() - cpu
        wanted = self.options.replicates
        yield self._state("geometry", wanted)
        while self._spectra.count < wanted:
            cpu = time.process_time()
            self._replicate(surfaces)
            self.cpu_seconds += time.process_time() - cpu
            if self._spectra.count >= wanted and not self._finished():
                wanted += 1
            yield self._state("replicate", wanted)

    @property
    def accuracy_reached(self) -> bool:
        """Whether all readings are as accurate as was asked for; True if nothing was asked."""
        return self.options.accuracy is None or float(self._errors().max(initial=0.0)) <= self.options.accuracy

    def solution(self) -> Solution:
        """What is known so far.

        Raises
        ------
        RuntimeError
            Before the first replicate.
        """
        if self._surfaces is None or self._spectra.count == 0:
            raise RuntimeError("nothing was solved yet")
        return Solution(
            scene=self.scene,
            plan=self.plan,
            elements=self._surfaces.elements,
            surfaces=self._surfaces.surfaces(),
            readings={name: self._readings(i, name) for i, name in enumerate(self._slices)},
            replicates=self._spectra.count,
            complete=self._spectra.count >= self.options.replicates,
            record=self._summary(),
        )

    def _prepare(self) -> SurfaceSolver:
        """Ray structure, lit sides, plan and elements."""
        with self.record.timed("geometry"):
            bvh = build_bvh(self.device, self.scene.patches)
            lit = find_lit_sides(self.scene, bvh, seed=self.options.seed)
            self.plan: Plan = make_plan(self.scene, self.options, lit)
            self._surfaces = SurfaceSolver(
                self.device, self.scene, bvh, lit, self.plan, self.options, self.record
            )
        return self._surfaces

    def _replicate(self, surfaces: SurfaceSolver) -> None:
        """One independent estimate of everything, added to the running moments."""
        seed = int(np.random.SeedSequence((self.options.seed, self._spectra.count)).generate_state(1)[0])
        light = surfaces.replicate(seed)
        plan = self.plan
        with self.record.timed("readings"):
            samples = read_points(
                surfaces.on_device,
                surfaces.on_device_elements,
                light,
                self._position,
                self._normal,
                light_samples=plan.light_samples,
                gather_samples=plan.gather_samples if plan.interreflection else 0,
                seed=seed ^ 0x5BD1E995,
            )
            spectra = plan.columns.to_bands(samples.irradiance)
        self.record.rays += len(spectra) * (len(self.scene.emitters) * plan.light_samples + 3 * plan.gather_samples)
        lux = np.einsum("xb,b->x", spectra, self._weights)
        self._spectra.add(spectra)
        self._lux.add(lux)
        self._sensor_lux.add(np.array([lux[part].mean() for part in self._slices.values()]))
        self._enclosed.add(samples.enclosed)

    def _finished(self) -> bool:
        """Whether to stop when the wanted replicates are done."""
        if self.options.accuracy is None and self.options.time is None:
            return True
        out_of_time = self.options.time is not None and self._elapsed() >= self.options.time
        reached = self.options.accuracy is not None and self.accuracy_reached
        return out_of_time or reached or self._spectra.count >= MAX_REPLICATES

    def _elapsed(self) -> float:
        return time.perf_counter() - self._start

    def _errors(self) -> NDArray[np.float64]:
        if not self._slices:
            return np.zeros(0)
        return np.concatenate([self._readings(i, name).accuracy for i, name in enumerate(self._slices)])

    def _readings(self, index: int, name: str) -> Readings:
        part = self._slices[name]
        return Readings(
            sensor=name,
            position=self._position[part],
            normal=self._normal[part],
            irradiance=self._spectra.mean[part],
            half_width=self._spectra.half_width()[part],
            illuminance=self._lux.mean[part],
            illuminance_half_width=self._lux.half_width()[part],
            mean_illuminance=float(self._sensor_lux.mean[index]),
            mean_illuminance_half_width=float(self._sensor_lux.half_width()[index]),
            enclosed=self._enclosed.mean[part],
        )

    def _state(self, stage: str, wanted: int) -> State:
        errors = self._errors() if self._spectra.count >= 2 else np.zeros(0)
        history = self.record.convergence[-1].residual if self.record.convergence else (1.0,)
        return State(
            stage=stage,
            replicate=self._spectra.count,
            replicates=wanted,
            seconds=self._elapsed(),
            error=float(errors.max()) if len(errors) else float("inf"),
            median_error=float(np.median(errors)) if len(errors) else float("inf"),
            elements=0 if self._surfaces is None else len(self._surfaces.elements),
            rays=self.record.rays,
            unshot=history[-1],
        )

    def _summary(self) -> dict[str, Any]:
        return {
            "options": asdict(self.options),
            "device": self.device.description,
            "replicates": self._spectra.count,
            "stage_seconds": dict(self.record.seconds),
            "solve_cpu_s": self.cpu_seconds,
            "wall_s": self._elapsed(),
            "rays": self.record.rays,
            "elements": 0 if self._surfaces is None else len(self._surfaces.elements),
            "interval_parts": ["sampling"],
            "defects_before_closure": [asdict(d) for d in self.record.defects],
            "solver": [asdict(c) for c in self.record.convergence],
        }


def _stacked(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def _slices(sensors: tuple[Sensor, ...]) -> dict[str, slice]:
    ends = np.cumsum([0] + [len(s.position) for s in sensors])
    return {s.name: slice(int(ends[i]), int(ends[i + 1])) for i, s in enumerate(sensors)}
