"""What a render computes: the solution, and beside it the audit, sensitivities and the referee."""

from __future__ import annotations

import time
from dataclasses import asdict

from hradiosity.cli.auditing import run_audit
from hradiosity.cli.closing import finish
from hradiosity.cli.expected import accuracy_lines
from hradiosity.cli.imaging import image_plan_lines
from hradiosity.cli.interrupts import held_back
from hradiosity.cli.live_files import LiveFiles, rescue
from hradiosity.cli.mapping import map_plan_lines
from hradiosity.cli.refereeing import comparison, comparison_lines, trace_referee, write_referee
from hradiosity.cli.request import Run
from hradiosity.cli.sensing import SENSITIVITY_TITLE, run_sensitivity, sensitivity_lines
from hradiosity.cli.text import note_lines, percent
from hradiosity.cli.watching import LiveLight
from hradiosity.errors import DeviceError, OutputError
from hradiosity.io import calibration
from hradiosity.io.checkpoint import load_checkpoint, run_digest
from hradiosity.io.output_folder import partial_of
from hradiosity.io.results_sensitivity import sensitivity_record, write_sensitivity
from hradiosity.io.run_record import plan_record
from hradiosity.metrics.truncation import truncation_lines
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.auditing import MOST_AUDITS, accuracy_before_factor, not_audited
from hradiosity.radiosity.referee import Referee
from hradiosity.solution import Solution


class Computation:
    """The work of one run."""

    def __init__(self, run: Run) -> None:
        self._about = run
        self._request, self._scene, self._display, self._device = run.request, run.scene, run.display, run.device
        measured = calibration.load_calibration(run.device.description, run.request.options.mode)
        self._solver = make_solver(run.scene, run.request.options, run.device, measured)
        run.display.follow(lambda: self._solver.record.stage)

    @property
    def nothing_known(self) -> bool:
        """Whether the partial folder holds nothing worth keeping."""
        return not self._about.keep_partial or self._solver.replicates == 0

    def run(self) -> int:
        """All of it, with the results written and told; returns the exit status."""
        self._tell_plan()
        digest = run_digest(self._scene, self._solver.plan, self._request.options, self._device.description)
        if self._request.outputs.resume:
            self._take_up(digest)
        interrupted = self._solve(digest)
        if interrupted and self._solver.replicates == 0:
            raise KeyboardInterrupt
        solution, interrupted = self._audited(digest, interrupted)
        if self._request.outputs.sensitivity and self._scene.sensors and not interrupted:
            interrupted = self._sensitivity()
        if self._request.referee and self._scene.sensors and not interrupted:
            interrupted = self._referee(solution, self._request.referee)
        return finish(self._about, self._solver, solution, digest, interrupted)

    def _tell_plan(self) -> None:
        plan = self._solver.plan
        self._display.lines(note_lines(self._solver.notes))
        expected = accuracy_lines(self._scene, self._request.options, self._device.description)
        outputs = self._request.outputs
        drawn = map_plan_lines(outputs.mapped, outputs.map_error)
        if self._request.images and outputs.pictures:
            drawn += image_plan_lines(
                self._scene,
                self._device.description,
                size=outputs.image_size,
                samples=outputs.image_samples if outputs.image_noise is None else None,
                noise=outputs.image_noise,
                spectra=outputs.image_spectra,
            )
        self._display.lines([*plan.lines(), *truncation_lines(self._scene.bands), *drawn, *expected], title="Plan")
        self._display.data("plan", {**plan_record(plan, self._scene.bands), **({"drawn": drawn} if drawn else {})})

    def _take_up(self, digest: str) -> None:
        """Restore what an earlier run knew."""
        kept, belongs, path = load_checkpoint(self._about.out, partial_of(self._about.out))
        if belongs != digest:
            raise OutputError(
                f"{path} is of another scene, device, version or sampling and can't be resumed; "
                "start without --resume, or with the settings of that run"
            )
        self._solver.restore(kept)
        self._display.lines([f"going on from replicate {self._solver.replicates} in {path}"])

    def _solve(self, digest: str) -> bool:
        """Run the solver; returns whether it was interrupted."""
        try:
            live = LiveFiles(
                self._about.partial,
                self._solver,
                digest,
                preview=self._request.outputs.pictures,
                white=self._request.outputs.white.value,
            )
            light = LiveLight(self._about.partial, self._solver)
            for state in self._solver.states():
                self._display.state(state)
                live.update()
                light.update()
        except KeyboardInterrupt:
            return True
        except (DeviceError, MemoryError) as error:
            if self._solver.replicates == 0:
                raise
            raise DeviceError(f"{error}; {rescue(self._about, self._solver, digest)}") from error
        return False

    def _audited(self, digest: str, interrupted: bool) -> tuple[Solution, bool]:
        """As `_audit`; the run goes on where only the audit's factor keeps readings from the accuracy asked for."""
        solution, interrupted = self._audit(self._solver.solution(), interrupted)
        for _ in range(MOST_AUDITS - 1):
            accuracy = accuracy_before_factor(solution)
            if accuracy is None or interrupted:
                break
            factor = solution.record["audit"]["factor"]
            self._display.lines([f"intervals were too narrow by {factor:.2f}: going on to {percent(accuracy)}"])
            self._solver.ask_for(accuracy)
            interrupted = self._solve(digest)
            solution, interrupted = self._audit(self._solver.solution(), interrupted)
        return solution, interrupted

    def _audit(self, solution: Solution, interrupted: bool) -> tuple[Solution, bool]:
        """The solution with audited intervals, or why they are not; and whether the run was interrupted by now."""
        if not self._request.options.audit:
            return not_audited(solution, "--no-audit"), interrupted
        if interrupted:
            return not_audited(solution, "interrupted"), interrupted
        start = time.perf_counter()
        solution, interrupted = run_audit(self._scene, solution, self._device, self._display)
        spent = self._about.seconds.get("audit", 0.0)
        self._about.seconds["audit"] = spent + time.perf_counter() - start
        return solution, interrupted

    def _sensitivity(self) -> bool:
        """Find what reflectances and lamps change; returns whether that was interrupted."""
        run, start = self._about, time.perf_counter()
        found, reason, interrupted = run_sensitivity(self._scene, self._request.options, self._device, self._display)
        run.seconds["sensitivities"] = time.perf_counter() - start
        if found is None:
            run.more["sensitivity"] = {"skipped": reason}
            run.closing.append(("", [f"no sensitivities: {reason}"]))
            return interrupted
        with held_back():
            write_sensitivity(run.partial, found)
        run.more["sensitivity"] = sensitivity_record(found)
        run.closing.append((SENSITIVITY_TITLE, sensitivity_lines(found)))
        return False

    def _referee(self, solution: Solution, paths: int) -> bool:
        """Trace unbiased paths and compare; returns whether that was interrupted."""
        run, start = self._about, time.perf_counter()
        referee = Referee(self._scene, self._device, paths, self._request.options.seed)
        state, interrupted = trace_referee(referee, self._display)
        run.seconds["referee"] = time.perf_counter() - start
        if state is None:
            return interrupted
        reference = referee.readings()
        with held_back():
            write_referee(run.partial, reference, self._scene.bands)
        found = comparison(solution.readings, reference)
        run.more["referee"] = asdict(state)
        if found is not None:
            run.more["referee"] |= {"comparison": asdict(found)}
            run.closing.append(("Against the referee's unbiased paths", comparison_lines(found)))
        return interrupted
