"""Runs settings on a scene and says what they took."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Final

from hradiosity.device import Device
from hradiosity.io.calibration import load_calibration, measure
from hradiosity.model.scene import Scene
from hradiosity.options import FormFactorName
from hradiosity.plan import ClassicCalibration, Plan
from hradiosity.planning_classic import pixels_drawn
from hradiosity.radiosity import RadiositySolver, make_solver
from hradiosity.readings.paths import RefereeSamples
from hradiosity.suites.cost.memory import PeakMemory
from hradiosity.suites.cost.reference import GrowingReference
from hradiosity.suites.cost.settings import Setting
from hradiosity.suites.cost.values import Run
from hradiosity.suites.cost.work import Measured, predict, work_of, work_of_plan

UNMEASURED = ClassicCalibration(seconds_per_pixel=5e-8, seconds_per_product=1.5e-9)
"""Of the classic mode on two cores, for devices on which it never ran; the first run of it replaces them."""

PAIR_SECONDS: Final[dict[FormFactorName, float]] = {
    "point": 3e-6,
    "point-disk": 3e-6,
    "auto": 4e-6,
    "contour": 6e-6,
    "quasi-hemisphere": 6e-6,
    "hemisphere": 1.2e-5,
    "monte-carlo": 3e-5,
    "hemicube": 5e-5,
}
"""What a pair of elements takes at most on two cores, with its visibility."""
LINKS_OVER_ROWS: Final = 4.0
"""Seconds of hierarchical links over those of rows."""


@dataclass
class Started:
    """A setting whose geometry and plan are ready.

    predicted : wall seconds of all of it; None when nothing of its mode was measured
    begun : by the clock of the bench
    busy_before : CPU seconds of the process when it began
    """

    setting: Setting
    seed: int
    solver: RadiositySolver
    plan: Plan
    predicted: float | None
    memory: PeakMemory
    begun: float
    busy_before: float


class SceneBench:
    """Everything that is run on one scene, and the clock that it is measured with.

    Parameters
    ----------
    scene : Scene
    device : Device
    kept : RefereeSamples, optional
        See `GrowingReference`.
    """

    def __init__(self, scene: Scene, device: Device, kept: RefereeSamples | None = None) -> None:
        self.scene, self.device = scene, device
        self.reference = GrowingReference(scene, device, kept)
        self._base: Run | None = None
        self._measured: list[Measured] = []
        self._pairs: dict[int, int] = {}
        self._wall, self._busy = 0.0, 0.0
        speed = load_calibration(device.description, "classic")
        self._classic = speed if isinstance(speed, ClassicCalibration) else UNMEASURED
        self._classic_plan: Plan | None = None
        self._classic_ran = False

    def clock(self) -> float:
        """Wall seconds, those for building kernels left out, which no later run takes."""
        return time.perf_counter() - self.device.build_time.wall

    def guess(self, setting: Setting) -> float | None:
        """Wall seconds that a setting will take, before its geometry is made; None when nothing is known."""
        options = setting.options
        if options.mode == "classic":
            return None if self._classic_plan is None else self._classic_seconds(self._classic_plan, setting)
        pairs = 0 if options.form_factors == "rays" else self._pairs.get(options.elements)
        if self._base is None or pairs is None:
            return None
        elements = self._base.elements * options.elements / self._base.setting.options.elements
        seconds = self._predict(work_of(elements, options, **self._sizes))
        seconds += pairs * PAIR_SECONDS.get(options.form_factors, 0.0)
        return seconds * LINKS_OVER_ROWS if options.links == "hierarchical" else seconds

    def start(self, setting: Setting, seed: int = 0, scene: Scene | None = None) -> Started:
        """Make geometry and plan.

        Raises
        ------
        SceneError
            When the setting is impossible for the scene.
        """
        memory, begun, busy = PeakMemory(), self.clock(), self.device.work_cpu_seconds()
        solver = make_solver(scene or self.scene, replace(setting.options, seed=seed), self.device)
        plan = solver.plan
        predicted: float | None = None
        if setting.options.mode == "classic":
            self._classic_plan = plan
            predicted = self._classic_seconds(plan, setting)
        elif self._base is not None:
            if plan.pairs:
                self._pairs.setdefault(setting.options.elements, plan.pairs)
            predicted = self._predict(work_of_plan(plan, setting.options))
            predicted += plan.pairs * PAIR_SECONDS.get(setting.options.form_factors, 0.0)
            predicted *= LINKS_OVER_ROWS if setting.options.links == "hierarchical" else 1.0
        return Started(setting, seed, solver, plan, predicted, memory, begun, busy)

    def finish(self, started: Started) -> Run:
        """Run what was started."""
        solver, setting = started.solver, started.setting
        for _ in solver.states():
            pass
        solution = solver.solution()
        record = solution.record
        if setting.options.mode == "classic":
            measured = measure(solution)
            if isinstance(measured, ClassicCalibration):
                self._classic, self._classic_ran = measured, True
        work = {} if setting.options.mode == "classic" else work_of_plan(started.plan, setting.options)
        of_host = "CPU" in self.device.info.kind.upper()
        run = Run(
            setting=setting,
            seed=started.seed,
            elements=len(solution.elements),
            replicates=solution.replicates,
            cpu_seconds=solver.cpu_seconds,
            busy_seconds=self.device.work_cpu_seconds() - started.busy_before,
            wall_seconds=self.clock() - started.begun,
            memory_bytes=started.memory.added() if of_host else started.plan.memory_bytes,
            stage_seconds=dict(record["stage_seconds"]),
            work=work,
            readings=solution.readings,
            convergence=record["solver"][-1] if record["solver"] else {},
        )
        self._wall, self._busy = self._wall + run.wall_seconds, self._busy + run.busy_seconds
        return run

    def learn(self, run: Run, plan: Plan) -> None:
        """Predict further runs from this one, and from the one before."""
        self._base = run
        share = run.busy_seconds / run.wall_seconds
        stages = {stage: share * seconds for stage, seconds in run.stage_seconds.items()}
        self._measured.append(Measured(run.busy_seconds, stages, run.work))
        self._sizes = {
            "n_readings": plan.n_readings,
            "n_emitters": plan.n_emitters,
            "columns": plan.columns.n_columns,
        }

    def _predict(self, work: dict[str, float]) -> float:
        """CPU seconds times the pace of all runs so far, of which one alone may have been held up."""
        if not self._measured:
            raise RuntimeError("nothing was measured yet")
        *before, base = self._measured
        return self._pace() * predict(base, work, before[-1] if before else None)

    def _pace(self) -> float:
        """Wall over CPU seconds of all runs so far."""
        return self._wall / max(self._busy, 1e-3)

    def _classic_seconds(self, plan: Plan, setting: Setting) -> float:
        """From the hemicubes and products of a plan, which hardly depend on the resolution."""
        options = setting.options
        drawing = plan.hemicubes * pixels_drawn(options.hemicube_resolution, plan.n_patches)
        moved = (plan.shots + plan.hemicubes) * plan.shooters * max(plan.columns.n_columns, 1)
        seconds = drawing * self._classic.seconds_per_pixel + moved * self._classic.seconds_per_product
        # Speeds of other times know nothing of what else the machine does now.
        return seconds if self._classic_ran else seconds * max(self._pace(), 1.0)
