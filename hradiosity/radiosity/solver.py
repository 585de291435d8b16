"""The replicate loop: surfaces, then readings, until they are as accurate as asked for."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.errors import DeviceError
from hradiosity.model.scene import Note, Scene, Sensor
from hradiosity.model.variants import check_variants
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration, Plan
from hradiosity.planning import make_plan
from hradiosity.planning_memory import check_fits
from hradiosity.planning_seconds import with_geometry
from hradiosity.radiosity.budget import Accuracies, Round
from hradiosity.radiosity.checkpoint import pack_record, pack_round, unpack_record, unpack_round
from hradiosity.radiosity.geometry import Geometry, find_geometry
from hradiosity.radiosity.pacer import Pacer
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.seeds import replicate_seed
from hradiosity.radiosity.state import State
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.radiosity.watching import LightWatch
from hradiosity.readings.differences import VariantMoments, replicate_readings
from hradiosity.readings.effort import Effort, plan_effort
from hradiosity.readings.interval import part_of
from hradiosity.readings.moments import ReadingMoments
from hradiosity.readings.path_tracing import PathRules
from hradiosity.readings.reflected import MeanLight, mean_light, reflected_lux
from hradiosity.readings.sensors import ReadingSamples, read_points
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.readings.twins import Twins
from hradiosity.readings.unseen import brightest_unseen
from hradiosity.solution import Readings, ReflectedLux, Solution
from hradiosity.space.lit_sides import LitSides
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

NEAR_FACTOR, FIRST_NEAR_FACTOR = 0.5, 3.0
"""The solution is never looked up at a hit nearer than so many sizes of its element; the second is for first hits."""
KEPT_BYTES = 256 * 2**20
"""Light of earlier replicates that is kept on the device for reading further points; two replicates always are."""


class RadiositySolver:
    """One run that can be followed state by state, interrupted, resumed, and asked for its solution at any time.

    Parameters
    ----------
    scene : Scene
    options : Options
    device : Device
    calibration : Calibration or ClassicCalibration, optional
        Rates of the device in this mode, for the plan's expected seconds.
    """

    surface_solver: type[SurfaceSolver] = SurfaceSolver
    """What estimates the light on the surfaces."""

    def __init__(
        self,
        scene: Scene,
        options: Options,
        device: Device,
        calibration: Calibration | ClassicCalibration | None = None,
    ) -> None:
        self.scene, self.options, self.device = scene, options, device
        self.record = Record()
        self.cpu_seconds = 0.0
        self.watch: LightWatch | None = None
        self._calibration = calibration
        self._pacer = Pacer.of(options)
        self._geometry: Geometry | None = None
        self._start = time.perf_counter()
        self._earlier_seconds = 0.0
        check_variants(scene)
        self._readings = self._make_moments()
        self._surfaces: SurfaceSolver | None = None
        self._effort: Effort | None = None
        self._twins = Twins(len(self._readings.position))
        self._accuracies: tuple[int, Accuracies] | None = None
        self.notes: tuple[Note, ...] = scene.notes
        self._kept: list[tuple[DeviceElements, SurfaceLight, int]] = []
        self._mean: MeanLight | None = None

    @property
    def replicates(self) -> int:
        """Number of replicates done."""
        return self._readings.count

    @property
    def plan(self) -> Plan:
        """What the run does; made on first use."""
        return self._prepare().plan

    @property
    def on_device(self) -> DeviceScene:
        """The scene's ray structure; made on first use."""
        return self._prepare().on_device

    @property
    def lit(self) -> LitSides:
        """Sides that light was found to reach before the run; made on first use."""
        return self._find_geometry().lit

    def states(self) -> Iterator[State]:
        """Run, yielding after each stage; whoever stops asking keeps what is known so far.

        A keyboard interrupt, or a device that fails, takes back the replicate that it breaks off, so that the solution
        and the checkpoint are those of the replicates before.
        """
        self._prepare()
        smaller = self._pacer.first_round(self.plan.seconds) if self.replicates == 0 else None
        if smaller is not None:
            self._begin(smaller)
        self._pacer.prepared(self._elapsed())
        yield self._state("geometry")
        while self.replicates < self._wanted():
            before = self.checkpoint()
            cpu = self.device.work_cpu_seconds()
            try:
                self._replicate(self._prepare())
            except (KeyboardInterrupt, DeviceError, MemoryError):
                self._load(before)
                raise
            self.cpu_seconds += self.device.work_cpu_seconds() - cpu
            self._pacer.replicated(self._elapsed(), self.record.seconds["readings"])
            yield self._state("replicate")
            larger = self._pacer.larger(self._found(), self.replicates, self._samples(), self._elapsed())
            if larger is not None:
                self._pacer.begin(larger, self._found(), self.replicates, self._elapsed(), self.record.rays)
                self._begin(larger)
                self._pacer.prepared(self._elapsed())
                yield self._state("larger replicates")

    def ask_for(self, accuracy: float) -> None:
        """Go on to this accuracy when `states` is called again, since an audit found the intervals too narrow."""
        self._pacer.asked = replace(self._pacer.asked, accuracy=accuracy)

    @property
    def accuracy_reached(self) -> bool:
        """Whether all readings are as accurate as was asked for; True if nothing was asked."""
        found = self._found()
        if self.options.accuracy is None or not self.scene.sensors:
            return True
        return found is not None and bool((found.total <= self.options.accuracy).all())

    def solution(self) -> Solution:
        """What is known so far.

        Raises
        ------
        RuntimeError
            Before the first replicate.
        """
        if self._surfaces is None or self.replicates == 0:
            raise RuntimeError("nothing was solved yet")
        return Solution(
            scene=replace(self.scene, notes=(*self.notes, *self._surfaces.notes())),
            plan=self.plan,
            elements=self._surfaces.elements,
            surfaces=self._surfaces.surfaces(),
            readings=self._current(),
            replicates=self.replicates,
            complete=self.replicates >= self._wanted(),
            record=self._summary(),
            reader=self.read,
            reflector=self.read_reflected,
            variants=self._readings.variants(self._prepare().shared_errors()),
        )

    def read(self, sensor: Sensor) -> Readings:
        """Light at a further sensor, from the kept light of this process's replicates; see `Solution.read_sensor`.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        """
        if len(self._kept) < 2:
            raise RuntimeError("further points need the light of two replicates or more, computed by this process")
        full = self.options.full_metrics
        moments = ReadingMoments((sensor,), self.scene.bands, full=full, scene=self.scene)
        effort = self._plan_effort(moments, *self._kept[0])
        for elements, light, seed in self._kept:
            self._read(moments, elements, light, seed, effort)
        return moments.readings(self._prepare().shared_errors())[sensor.name]

    @property
    def keeps_light(self) -> bool:
        """Whether there is light to read further points from."""
        return len(self._kept) >= 2

    def read_reflected(
        self, position: NDArray[np.float64], normal: NDArray[np.float64], n_paths: int, seed: int
    ) -> ReflectedLux:
        """Reflected light at many points side by side, from the light kept on the last elements.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        """
        elements = self._kept[-1][0] if self._kept else None
        lights = [light for its_elements, light, _ in self._kept if its_elements is elements]
        if elements is None or len(lights) < 2:
            raise RuntimeError("further points need the light of two replicates or more, computed by this process")
        if self._mean is None or self._mean.replicates != len(lights):
            self._mean = mean_light(self.device, lights)
        scene, seed = self._prepare().on_device, seed ^ self.options.seed
        bands, rules = self.scene.bands, self._rules
        return reflected_lux(scene, elements, self._mean, bands, position, normal, n_paths, rules=rules, seed=seed)

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs, by name; the arrays do not change when the run goes on."""
        surfaces = self._prepare()
        seconds = self._earlier_seconds + self._elapsed()
        return {
            "record": pack_record(self.record, cpu_seconds=self.cpu_seconds, wall_seconds=seconds),
            "round": pack_round(self._pacer.size, self._pacer.rounds),
            **({f"effort/{name}": array for name, array in self._effort.arrays.items()} if self._effort else {}),
            **{f"twins/{name}": array for name, array in self._twins.checkpoint().items()},
            **{f"readings/{name}": array for name, array in self._readings.checkpoint().items()},
            **{f"surfaces/{name}": array for name, array in surfaces.checkpoint().items()},
        }

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from the checkpoint of a run of the same scene, options and device; the numbers are the same bits.

        Raises
        ------
        ValueError
            When the checkpoint does not fit this scene.
        """
        self._prepare()
        geometry = dict(self.record.seconds)
        size, rounds = unpack_round(kept["round"])
        if size.options != self._pacer.size.options:
            self._begin(size)
        self._pacer = Pacer(self.options, size, rounds)
        numbers = self._load(kept)
        for stage, seconds in geometry.items():
            self.record.seconds[stage] = self.record.seconds.get(stage, 0.0) + seconds
        self._earlier_seconds = numbers["wall_seconds"]

    def _load(self, kept: Mapping[str, NDArray[Any]]) -> Mapping[str, float]:
        """Put the moments and the record back; returns the other numbers."""
        effort = part_of(kept, "effort")
        self._effort = Effort.of_arrays(effort) if effort else None
        self._twins.restore(part_of(kept, "twins"))
        self._readings.restore(part_of(kept, "readings"))
        self._accuracies = None
        self._prepare().restore(part_of(kept, "surfaces"))
        record, numbers = unpack_record(kept["record"])
        self.record.__dict__.update(record.__dict__)
        self.cpu_seconds = numbers["cpu_seconds"]
        return numbers

    def _prepare(self) -> SurfaceSolver:
        """Plan and elements of this round; made on first use."""
        if self._surfaces is None:
            geometry = self._find_geometry()
            cpu = self.device.work_cpu_seconds()
            with self.record.timed("geometry"):
                options = self._pacer.size.options
                plan = make_plan(self.scene, options, geometry.lit)
                surfaces = self.surface_solver(
                    self.device, self.scene, geometry.bvh, geometry.lit, plan, options, self.record
                )
                surfaces.plan = surfaces.sized_plan(self._calibration)
                check_fits(surfaces.plan, self.device)
                self._surfaces = surfaces
            surfaces.plan = with_geometry(surfaces.plan, self.record.seconds)
            self.cpu_seconds += self.device.work_cpu_seconds() - cpu
        self._surfaces.watch = self.watch
        return self._surfaces

    def _find_geometry(self) -> Geometry:
        """Ray structure and lit sides, found once; the scene is checked then."""
        if self._geometry is None:
            self._geometry = find_geometry(self.device, self.scene, self.options.seed, self.record)
            self.scene, self.notes = self._geometry.scene, self._geometry.notes
            self.cpu_seconds += self._geometry.cpu_seconds
        return self._geometry

    def _make_moments(self) -> VariantMoments:
        """For the sensors of the scene, before the first replicate."""
        return VariantMoments(self.scene, full=self.options.full_metrics)

    def _begin(self, size: Round) -> None:
        """Start anew with replicates of another size."""
        self._pacer.size = size
        self._readings = self._make_moments()
        self._surfaces, self._effort, self._accuracies = None, None, None
        self._twins = Twins(len(self._readings.position))
        self._kept, self._mean = [], None
        self.record.defects.clear()
        self.record.convergence.clear()
        self._prepare()

    def _replicate(self, surfaces: SurfaceSolver) -> None:
        """One independent estimate of everything, added to the running moments."""
        seed = replicate_seed(self.options.seed, self.replicates)
        light = surfaces.replicate(seed)
        with self.record.timed("readings"):
            if self._effort is None:
                even = self._plan_effort(self._readings, surfaces.on_device_elements, light, seed)
                spread, size = self._readings.planes.spread, self._pacer.size
                self._effort = even.focused(spread(size.focus)).looking(spread(size.lookup))
            first = self._read(self._readings, surfaces.on_device_elements, light, seed, self._effort)
            if self.options.accuracy is not None:
                self._read_twins(first, surfaces.on_device_elements, light, seed, self._effort)
        self.record.rays += self._effort.rays
        size = light.reflected.nbytes + light.emitter_choice.nbytes
        if len(self._kept) < 2 or (len(self._kept) + 1) * size <= KEPT_BYTES:
            self._kept.append((surfaces.on_device_elements, light, seed))

    def _plan_effort(self, moments: ReadingMoments, elements: DeviceElements, light: SurfaceLight, seed: int) -> Effort:
        """Samples of each reading in every replicate."""
        plan = self.plan
        effort = plan_effort(
            self._prepare().on_device,
            elements,
            light,
            moments.position,
            moments.normal,
            light_samples=plan.light_samples,
            gather_samples=plan.gather_samples if plan.gathers or self.scene.sky is not None else 0,
            rules=self._rules,
            seed=seed ^ 0x3C6EF372,
            response=moments.planes.response,
        )
        share = moments.planes.share
        return effort if (share == 1.0).all() else effort.focused(share)

    def _read(
        self, moments: ReadingMoments, elements: DeviceElements, light: SurfaceLight, seed: int, effort: Effort
    ) -> ReadingSamples:
        """One replicate of readings."""
        scene = self._prepare().on_device
        everywhere = np.arange(len(moments.position))
        samples = self._read_some(moments, everywhere, elements, light, seed ^ 0x5BD1E995, effort)
        unseen = brightest_unseen(
            scene,
            light,
            moments.position,
            moments.normal,
            samples,
            light_samples=effort.light,
            gather_samples=effort.gather,
        )
        moments.add(replicate_readings(self.plan.columns, samples, unseen))
        return samples

    def _read_some(
        self,
        moments: ReadingMoments,
        chosen: NDArray[np.int64],
        elements: DeviceElements,
        light: SurfaceLight,
        seed: int,
        effort: Effort,
    ) -> ReadingSamples:
        """Light at some of the points, with an effort for all of them."""
        response = moments.planes.response
        return read_points(
            self._prepare().on_device,
            elements,
            light,
            moments.position[chosen],
            moments.normal[chosen],
            effort if np.array_equal(chosen, np.arange(len(effort.gather))) else effort.some(chosen),
            response=None if response is None else response[chosen],
            rules=self._rules,
            seed=seed,
        )

    def _read_twins(
        self, first: ReadingSamples, elements: DeviceElements, light: SurfaceLight, seed: int, effort: Effort
    ) -> None:
        """Some points once more, to tell the noise of the elements from that of their own rays."""
        chosen = self._twins.chosen
        second = self._read_some(self._readings, chosen, elements, light, seed ^ 0x2545F491, effort)
        weight = self.device.fetch(light.weight)[: first.irradiance.shape[1]].astype(np.float64)
        pair = first.irradiance[chosen], second.irradiance
        self._twins.add(*(np.einsum("xc,c->x", some, weight) for some in pair))

    @property
    def _rules(self) -> PathRules:
        """Where the paths of readings end."""
        return PathRules(self.options.lookup, NEAR_FACTOR, FIRST_NEAR_FACTOR)

    def _wanted(self) -> int:
        """Replicates of this round, as far as is known by now."""
        return self._pacer.wanted(self._found(), self.replicates, self._elapsed())

    def _found(self) -> Accuracies | None:
        """How accurate all readings are; None before two replicates."""
        if self.replicates < 2:
            return None
        if self._accuracies is None or self._accuracies[0] != self.replicates:
            shared = self._prepare().shared_errors()
            readings = self._readings.readings(shared, illuminance_only=True)
            found = Accuracies.of(readings, self._twins.surface_share)
            self._accuracies = self.replicates, found
        return self._accuracies[1]

    def _samples(self) -> NDArray[np.int64]:
        """(n,) paths of each reading in a replicate."""
        return np.zeros(0, np.int64) if self._effort is None else self._readings.planes.total(self._effort.gather)

    def _current(self) -> dict[str, Readings]:
        """Readings with their intervals as of now."""
        return self._readings.readings(self._prepare().shared_errors())

    def _elapsed(self) -> float:
        return time.perf_counter() - self._start

    def _state(self, stage: str) -> State:
        found = self._found()
        errors = np.zeros(0) if found is None else found.total
        history = self.record.convergence[-1].residual if self.record.convergence else (1.0,)
        return State(
            stage=stage,
            replicate=self.replicates,
            replicates=self._wanted(),
            seconds=self._elapsed(),
            error=float(errors.max()) if len(errors) else float("inf"),
            median_error=float(np.median(errors)) if len(errors) else float("inf"),
            elements=0 if self._surfaces is None else len(self._surfaces.elements),
            rays=self.record.rays,
            unshot=history[-1],
            remaining=self._pacer.remaining(found, self.replicates, self._samples(), self._elapsed()),
        )

    def _interval_parts(self) -> list[str]:
        """What the half widths of the readings are made of."""
        readings = self._current().values()
        return list(next(iter(readings)).numbers["illuminance"].parts) if readings else []

    def _summary(self) -> dict[str, Any]:
        return {
            "options": asdict(self.options),
            "device": self.device.description,
            "replicates": self.replicates,
            "rounds_given_up": self._pacer.rounds,
            "focused": bool(len(self._pacer.size.focus)),
            "stage_seconds": dict(self.record.seconds),
            "solve_cpu_s": self.cpu_seconds,
            "kernel_build_s": self.device.build_time.wall,
            "wall_s": self._earlier_seconds + self._elapsed(),
            "rays": self.record.rays,
            "hemicubes": {"drawn": self.record.hemicubes, "seconds": self.record.hemicube_seconds},
            "elements": 0 if self._surfaces is None else len(self._surfaces.elements),
            "interval_parts": self._interval_parts(),
            "defects_before_closure": [asdict(d) for d in self.record.defects],
            "solver": [asdict(c) for c in self.record.convergence],
        }
