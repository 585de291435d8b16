"""The replicate loop: surfaces, then readings, until they are as accurate as asked for."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
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
from hradiosity.radiosity.accuracies import Accuracies
from hradiosity.radiosity.budget import Step
from hradiosity.radiosity.checkpoint import (
    pack_numbers,
    pack_pace,
    pack_record,
    unpack_numbers,
    unpack_pace,
    unpack_record,
)
from hradiosity.radiosity.pacer import Pacer
from hradiosity.radiosity.point_reader import PointReader
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.remedy import Held
from hradiosity.radiosity.round import TOO_FEW, Round
from hradiosity.radiosity.rounds import Rounds
from hradiosity.radiosity.state import State
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.radiosity.watching import LightWatch
from hradiosity.readings.interval import part_of
from hradiosity.readings.reflected import reflected_lux
from hradiosity.solution import Readings, ReflectedLux, Solution
from hradiosity.space.lit_sides import LitSides
from hradiosity.transport.device_scene import DeviceScene


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
    reads_again = True
    """Whether single points can be read again in each replicate; if not, an accuracy takes more replicates."""

    def __init__(
        self,
        scene: Scene,
        options: Options,
        device: Device,
        calibration: Calibration | ClassicCalibration | None = None,
    ) -> None:
        self.options, self.device = options, device
        self.record = Record()
        self.watch: LightWatch | None = None
        self._pacer = Pacer.of(options, steps=self.reads_again)
        self._rounds = Rounds(device, scene, self._pacer.size, self.record, self.surface_solver, calibration)
        self._start = time.perf_counter()
        self._earlier_seconds = 0.0
        check_variants(scene)
        self._reader = PointReader(scene, options)
        self._step: Step | None = None
        self._number = 0
        self._accuracies: Accuracies | None = None

    @property
    def scene(self) -> Scene:
        """As it is solved, once its geometry is known."""
        return self._rounds.scene

    @property
    def notes(self) -> tuple[Note, ...]:
        """Remarks of the scene and of its geometry, and those that came to light while running."""
        return self._rounds.notes

    @property
    def cpu_seconds(self) -> float:
        """From the ray structure to the last reading, kernels and checks left out."""
        return self.record.cpu_seconds

    @property
    def replicates(self) -> int:
        """Number of replicates that there is a solution of."""
        return self._reader.count if self._rounds.shown is not None else 0

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
        return self._rounds.geometry.lit

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
        if self._step is None:
            yield from self._replicates()
        while self._step is not None or self._takes_step():
            if self._step is not None:
                yield from self._go_on(self._step)

    def _replicates(self) -> Iterator[State]:
        """Read all points, in as many replicates as are wanted."""
        while self._reader.count < self._wanted():
            with self._taken_back():
                self._replicate(self._prepare())
            self._accuracies = None
            held = self._reader.held()
            price = held.price(np.ones_like(held.times), held.lookup)
            self._pacer.replicated(self._elapsed(), self.record.seconds["readings"], price)
            yield self._state("replicate")
            if self._starts_anew():
                yield self._state("larger replicates")

    def _starts_anew(self) -> bool:
        """Whether the replicates so far were given up for larger ones, or for ones on smaller elements."""
        larger = self._pacer.filling(self._reader.count, self._elapsed())
        if larger is None and not self.reads_again:
            held = self._held(self._found())
            larger = self._pacer.finer(self._found(), self._reader.count, held, self._elapsed())
        if larger is None:
            return False
        self._pacer.begin(larger, self._elapsed(), self._account(readings_kept=0))
        self._begin(larger)
        self._pacer.prepared(self._elapsed())
        return True

    def _elements_by_size(self) -> int:
        """Elements that an accuracy may call for more of."""
        return len(self._prepare().elements)

    def _held(self, found: Accuracies | None) -> Held:
        """What the readings have had, and the elements that they were read on."""
        return self._reader.held(found, self._elements_by_size(), self._prepare().plan.element_size)

    def _takes_step(self) -> bool:
        """Whether there is something to do for readings that are not accurate enough; then the run is in that step."""
        found = self._found()
        held = self._held(found)
        self._reader.learn(held)
        off = self._pacer.need_more_than_samples(found, self._reader.count, held)
        if off.any():
            with self._taken_back(), self.record.timed("readings"):
                self.record.rays += self._reader.try_lookups(off, self._prepared().light(0))
            held = self._held(found)
        step = self._pacer.next_step(found, self._reader.count, held, self._elapsed())
        if step is None or (step.larger and not self._renew(step)):
            return False
        self._step, self._number = step, 0
        self._pacer.deeper += not step.larger
        return True

    def _go_on(self, step: Step) -> Iterator[State]:
        """Read some points again, replicate by replicate."""
        if step.larger and self._number == 0:
            yield self._state("larger replicates")
        share = self._reader.share(step)
        price = step.price(self._reader.held())
        while self._number < self._reader.count:
            with self._taken_back():
                on = self._prepared().light(self._number)
                with self.record.timed("readings"):
                    go = self._pacer.deeper + len(self._pacer.rounds)
                    self.record.rays += self._reader.some_points(self._number, share, on, go)
                self._number += 1
            if step.larger:
                self._rounds.forget_before(readings_too=bool(step.times.all()))
                self._pacer.replicated(self._elapsed(), self.record.seconds["readings"], price)
            else:
                self._pacer.deepened(self.record.seconds["readings"], price)
            late = self._pacer.too_late(self._elapsed())
            if late or self._number == self._reader.count:
                self._step, self._accuracies = None, None
            yield self._state("replicate" if step.larger else "further samples")
            if late:
                break

    @contextmanager
    def _taken_back(self) -> Iterator[None]:
        """Take back the replicate that is broken off, so that what is known is that of those before."""
        before = self.checkpoint()
        cpu = self.device.work_cpu_seconds()
        try:
            yield
        except (KeyboardInterrupt, DeviceError, MemoryError):
            self._load(before)
            raise
        self.record.cpu_seconds += self.device.work_cpu_seconds() - cpu

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
        surfaces = self._rounds.shown
        if surfaces is None or self.replicates == 0:
            raise RuntimeError("nothing was solved yet")
        shared, moments = self._rounds.shared_errors(), self._reader.moments
        return Solution(
            scene=replace(self.scene, notes=(*self.notes, *surfaces.notes())),
            plan=surfaces.plan,
            elements=surfaces.elements,
            surfaces=surfaces.surfaces(),
            readings=moments.readings(shared),
            replicates=self.replicates,
            complete=self._step is None and self.replicates >= self._wanted(),
            record=self._summary(),
            reader=self.read,
            reflector=self.read_reflected,
            variants=moments.variants(shared),
        )

    def read(self, sensor: Sensor) -> Readings:
        """Light at a further sensor, from the kept light of this process's replicates; see `Solution.read_sensor`.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        """
        if not self.keeps_light:
            raise RuntimeError(TOO_FEW)
        return self._reader.further(sensor, self._prepared().kept).readings(self._rounds.shared_errors())[sensor.name]

    @property
    def keeps_light(self) -> bool:
        """Whether there is light to read further points from."""
        return self._rounds.is_begun and len(self._rounds.now.kept) >= 2

    def read_reflected(
        self, position: NDArray[np.float64], normal: NDArray[np.float64], n_paths: int, seed: int
    ) -> ReflectedLux:
        """Reflected light at many points side by side, from the light kept on the last elements.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        """
        on, light = self._prepared().mean_light()
        return reflected_lux(
            on.scene,
            on.elements,
            light,
            self.scene.bands,
            position,
            normal,
            n_paths,
            rules=self._reader.rules,
            seed=seed ^ self.options.seed,
        )

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs, by name; the arrays do not change when the run goes on."""
        surfaces = self._prepare()
        seconds = self._earlier_seconds + self._elapsed()
        return {
            "record": pack_record(self.record, wall_seconds=seconds),
            "pace": pack_pace(self._pacer.size, self._pacer.rounds, self._pacer.deeper, self._step, self._number),
            "shared": pack_numbers(self._rounds.shared),
            **{f"readings/{name}": array for name, array in self._reader.checkpoint().items()},
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
        size, rounds, deeper, step, _ = unpack_pace(kept["pace"])
        if size != self._pacer.size:
            self._begin(size)
        self._pacer, self._step = Pacer(self.options, size, self.reads_again, rounds, deeper), step
        self._rounds.shared = unpack_numbers(kept["shared"])
        numbers = self._load(kept)
        for stage, seconds in geometry.items():
            self.record.seconds[stage] = self.record.seconds.get(stage, 0.0) + seconds
        self._earlier_seconds = numbers["wall_seconds"]

    def _load(self, kept: Mapping[str, NDArray[Any]]) -> Mapping[str, float]:
        """Put readings, surfaces and the record back; returns the other numbers."""
        surfaces = self._prepare()
        self._reader.restore(part_of(kept, "readings"), surfaces.plan.columns)
        self._accuracies = None
        self._rounds.restore(kept)
        *_, self._number = unpack_pace(kept["pace"])
        record, numbers = unpack_record(kept["record"])
        self.record.__dict__.update(record.__dict__)
        return numbers

    def _prepare(self) -> SurfaceSolver:
        """Plan and elements of this round; made on first use."""
        return self._prepared().surfaces

    def _prepared(self) -> Round:
        """The round that goes on; made on first use."""
        found = self._rounds.now
        found.surfaces.watch = self.watch
        return found

    def _begin(self, size: Options) -> None:
        """Start anew with replicates of another size."""
        self._pacer.size = size
        self._reader = PointReader(self.scene, self.options)
        self._accuracies = None
        self._rounds.begin(size)

    def _renew(self, step: Step) -> bool:
        """Other elements, on which the readings that lack accuracy are read anew; False if they don't fit."""
        account = self._account(readings_kept=int((step.times == 0.0).sum()))
        if not self._rounds.renew(step.options):
            return False
        self._pacer.begin(step.options, self._elapsed(), account)
        self._pacer.prepared(self._elapsed())
        self._reader.forget_noise()
        return True

    def _account(self, readings_kept: int) -> dict[str, float]:
        """Of replicates that end here, of whose readings some are kept."""
        found = self._found()
        error = float("inf") if found is None else float(found.total.max(initial=0.0))
        rays = self.record.rays
        return {"replicates": self._reader.count, "error": error, "readings_kept": readings_kept, "rays": rays}

    def _replicate(self, surfaces: SurfaceSolver) -> None:
        """One independent estimate of everything, added to the running moments."""
        on = self._prepared().light(self._reader.count)
        with self.record.timed("readings"):
            self.record.rays += self._reader.all_points(on)

    def _wanted(self) -> int:
        """Replicates of this round, as far as is known by now."""
        self._pacer.steps = self.reads_again and self._reader.reads_again
        return self._pacer.wanted(self._found(), self._reader.count, self._elapsed())

    def _found(self) -> Accuracies | None:
        """How accurate all readings are; None before two replicates. In a step, as they were before it."""
        if self._reader.count < 2:
            return None
        if self._accuracies is None:
            readings = self._reader.illuminances.readings(self._rounds.shared_errors(), illuminance_only=True)
            self._accuracies = Accuracies.of(readings, self._reader.proved_noise(), self._reader.count)
        return self._accuracies

    def _elapsed(self) -> float:
        return time.perf_counter() - self._start

    def _state(self, stage: str) -> State:
        found = self._found()
        errors = np.zeros(0) if found is None else found.total
        history = self.record.convergence[-1].residual if self.record.convergence else (1.0,)
        done = self._number if self._step is not None else self._reader.count
        return State(
            stage=stage,
            replicate=done,
            replicates=self._reader.count if self._step is not None else self._wanted(),
            seconds=self._elapsed(),
            error=float(errors.max()) if len(errors) else float("inf"),
            median_error=float(np.median(errors)) if len(errors) else float("inf"),
            elements=len(self._rounds.now.surfaces.elements) if self._rounds.is_begun else 0,
            rays=self.record.rays,
            unshot=history[-1],
            remaining=self._remaining(found),
        )

    def _remaining(self, found: Accuracies | None) -> float | None:
        """Expected seconds to the end; None while nothing is known."""
        if self._step is not None:
            return self._pacer.remaining_of_steps(self._number, self._elapsed())
        held = self._held(found)
        return self._pacer.remaining(found, self._reader.count, held, self._elapsed())

    def _interval_parts(self) -> list[str]:
        """What the half widths of the readings are made of."""
        readings = self._reader.illuminances.readings(illuminance_only=True).values()
        return list(next(iter(readings)).numbers["illuminance"].parts) if readings else []

    def _summary(self) -> dict[str, Any]:
        shown = self._rounds.shown
        return {
            "options": asdict(self.options),
            "device": self.device.description,
            "replicates": self.replicates,
            "rounds_given_up": self._pacer.rounds,
            "further_samples": self._pacer.deeper + sum(r["readings_kept"] > 0 for r in self._pacer.rounds),
            **self.record.told(),
            "kernel_build_s": self.device.build_time.wall,
            "wall_s": self._earlier_seconds + self._elapsed(),
            "elements": 0 if shown is None else len(shown.elements),
            "interval_parts": self._interval_parts(),
        }
