"""One render from the scene file to the folder of results."""

from __future__ import annotations

import shlex
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from hradiosity.cli import GOOD, INACCURATE, INTERRUPTED
from hradiosity.cli.auditing import audit_lines, missed_accuracy_lines, run_audit
from hradiosity.cli.comparing import DIFFERENCES_TITLE, variant_lines
from hradiosity.cli.display import Display, open_display
from hradiosity.cli.expected import accuracy_lines
from hradiosity.cli.interrupts import held_back, let_through, termination_interrupts
from hradiosity.cli.live_files import LiveFiles, draw_first_picture
from hradiosity.cli.refereeing import comparison, comparison_lines, trace_referee, write_referee
from hradiosity.cli.sensing import NOT_COVERED, SENSITIVITY_TITLE, run_sensitivity, sensitivity_lines
from hradiosity.cli.text import account_line, note_lines, parts_lines, sensor_lines, time_lines
from hradiosity.device import Device
from hradiosity.errors import DeviceError, OutputError
from hradiosity.io import calibration
from hradiosity.io.checkpoint import CHECKPOINT_FILE, load_checkpoint, run_digest, save_checkpoint
from hradiosity.io.output_folder import close_partial, open_partial, partial_of, publish
from hradiosity.io.output_lock import locked
from hradiosity.io.results import write_results, write_run
from hradiosity.io.results_sensitivity import sensitivity_record, write_sensitivity
from hradiosity.io.results_variants import variants_record
from hradiosity.io.run_record import plan_record, sensor_record
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.auditing import not_audited
from hradiosity.radiosity.referee import Referee
from hradiosity.show.white import WhiteName
from hradiosity.solution import Solution


@dataclass(frozen=True, kw_only=True)
class Request:
    """What the command line asked for; see ``hradiosity render --help``."""

    scene: Path
    out: Path
    options: Options
    device: str | None
    resume: bool
    referee: int | None
    pictures: bool
    white: WhiteName
    sensitivity: bool
    interval_parts: bool
    quiet: bool
    json: bool


def run(request: Request) -> int:
    """Do it; returns the exit status.

    Raises
    ------
    HradiosityError
        For mistakes of the user, an output that can't be written and devices that fail.
    """
    start = time.perf_counter()
    scene = load_scene(request.scene)
    reading = time.perf_counter() - start
    out = request.out.resolve()
    with locked(out):
        partial = open_partial(out, keep=request.resume)
        taken_up = request.resume and (partial / CHECKPOINT_FILE).exists()
        session: _Session | None = None
        try:
            with termination_interrupts():
                session = _Session(request, scene, out, partial)
                session.seconds["reading the scene"] = reading
                return session.run()
        finally:
            if not taken_up and (session is None or session.nothing_known):
                close_partial(out)


class _Session:
    """The run of one request, once its scene is read and its output folder is proved to be writable."""

    def __init__(self, request: Request, scene: Scene, out: Path, partial: Path) -> None:
        self.request, self.scene, self.out, self.partial = request, scene, out, partial
        self.seconds: dict[str, float] = {}
        self._device = Device(request.device)
        measured = calibration.load_calibration(self._device.description, request.options.mode)
        self._known_builds = calibration.load_builds(self._device.description)
        self._solver = make_solver(scene, request.options, self._device, measured)
        self._display: Display = open_display(
            quiet=request.quiet, json=request.json, doing=lambda: self._solver.record.stage
        )
        self._keep_partial = True
        self._more: dict[str, Any] = {}
        self._closing: list[tuple[str, list[str]]] = []

    @property
    def nothing_known(self) -> bool:
        """Whether the partial folder holds nothing worth keeping."""
        return not self._keep_partial or self._solver.replicates == 0

    def run(self) -> int:
        """All of it."""
        with self._display as display:
            self._announce_builds()
            if self.request.pictures and not self.request.resume:
                start = time.perf_counter()
                draw_first_picture(self.scene, self._device, self.partial, self.request.white)
                self.seconds["first picture"] = time.perf_counter() - start
            plan = self._solver.plan
            display.lines(note_lines(self._solver.notes))
            expected = accuracy_lines(self.scene, self.request.options, self._device.description)
            display.lines([*plan.lines(), *expected], title="Plan")
            display.data("plan", plan_record(plan))
            digest = run_digest(self.scene, plan, self.request.options, self._device.description)
            if self.request.resume:
                self._take_up(digest)
            interrupted = self._solve(digest)
            if interrupted and self._solver.replicates == 0:
                raise KeyboardInterrupt
            solution, interrupted = self._audit(self._solver.solution(), interrupted)
            if self.request.sensitivity and self.scene.sensors and not interrupted:
                interrupted = self._sensitivity()
            if self.request.referee and self.scene.sensors and not interrupted:
                interrupted = self._referee(solution, self.request.referee)
            return self._finish(solution, digest, interrupted)

    def _announce_builds(self) -> None:
        """Say so when a kernel is built that no earlier run had built."""
        said = False

        def listen(build: str) -> None:
            nonlocal said
            if build not in self._known_builds and not said:
                said = True
                self._display.building()

        self._device.on_build = listen

    def _take_up(self, digest: str) -> None:
        """Restore what an earlier run knew."""
        kept, belongs, path = load_checkpoint(self.out, partial_of(self.out))
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
            self._live = LiveFiles(
                self.partial, self._solver, digest, preview=self.request.pictures, white=self.request.white
            )
            for state in self._solver.states():
                self._display.state(state)
                self._live.update()
        except KeyboardInterrupt:
            return True
        except (DeviceError, MemoryError) as error:
            if self._solver.replicates == 0:
                raise
            raise DeviceError(f"{error}; {self._rescue(digest)}") from error
        return False

    def _audit(self, solution: Solution, interrupted: bool) -> tuple[Solution, bool]:
        """The solution with audited intervals, or why they are not; and whether the run was interrupted by now."""
        if not self.request.options.audit:
            return not_audited(solution, "--no-audit"), interrupted
        if interrupted:
            return not_audited(solution, "interrupted"), interrupted
        start = time.perf_counter()
        solution, interrupted = run_audit(self.scene, solution, self._device, self._display)
        self.seconds["audit"] = time.perf_counter() - start
        return solution, interrupted

    def _sensitivity(self) -> bool:
        """Find what reflectances and lamps change; returns whether that was interrupted."""
        start = time.perf_counter()
        found, reason, interrupted = run_sensitivity(self.scene, self.request.options, self._device, self._display)
        self.seconds["sensitivities"] = time.perf_counter() - start
        if found is None:
            self._more["sensitivity"] = {"skipped": reason}
            self._closing.append(("", [f"no sensitivities: {reason}"]))
            return interrupted
        with held_back():
            write_sensitivity(self.partial, found)
        self._more["sensitivity"] = sensitivity_record(found)
        self._closing.append((SENSITIVITY_TITLE, sensitivity_lines(found)))
        return False

    def _referee(self, solution: Solution, paths: int) -> bool:
        """Trace unbiased paths and compare; returns whether that was interrupted."""
        start = time.perf_counter()
        referee = Referee(self.scene, self._device, paths, self.request.options.seed)
        state, interrupted = trace_referee(referee, self._display)
        self.seconds["referee"] = time.perf_counter() - start
        if state is None:
            return interrupted
        reference = referee.readings()
        with held_back():
            write_referee(self.partial, reference, self.scene.bands)
        found = comparison(solution.readings, reference)
        self._more["referee"] = asdict(state)
        if found is not None:
            self._more["referee"] |= {"comparison": asdict(found)}
            self._closing.append(("Against the referee's unbiased paths", comparison_lines(found)))
        return interrupted

    def _finish(self, solution: Solution, digest: str, interrupted: bool) -> int:
        """Write the results, put them in place, and say what came out."""
        start = time.perf_counter()
        self._display.stage("writing the results")
        with held_back() as came:
            try:
                write_results(
                    self.partial,
                    solution,
                    self._solver.checkpoint(),
                    digest,
                    parts=self.request.interval_parts,
                )
                if self.request.pictures and not interrupted and not came:
                    interrupted = self._draw(solution)
            except OutputError as error:
                raise OutputError(f"{error}; {self._rescue(digest)}") from error
            interrupted = interrupted or bool(came)
            self.seconds["writing"] = time.perf_counter() - start - self.seconds.get("pictures", 0.0)
            state, code = self._outcome(solution, interrupted)
            seconds = self._stage_seconds(solution)
            if solution.variants:
                self._more["variants"] = variants_record(solution)
            self._more["intervals_do_not_cover"] = NOT_COVERED
            write_run(self.partial, solution, state, {"stage_seconds": seconds, "command": _command(), **self._more})
            publish(self.out)
        self._keep_partial = False
        self._remember(solution)
        self._display.close()
        self._report(solution, seconds, state)
        return code

    def _draw(self, solution: Solution) -> bool:
        """Draw the pictures; returns whether that was interrupted."""
        from hradiosity.show.pictures import PictureOptions, write_pictures

        start = time.perf_counter()
        self._display.stage("drawing pictures")
        try:
            with let_through():
                drawn = write_pictures(
                    solution,
                    self.partial / "pictures",
                    self._device,
                    PictureOptions(white=self.request.white),
                    on_device=self._solver.on_device,
                )
        except KeyboardInterrupt:
            return True
        self._live.remove_preview()
        self.seconds["pictures"] = time.perf_counter() - start
        self._more["pictures"] = drawn.record
        self._closing.append(("", note_lines(drawn.notes)))
        return False

    def _rescue(self, digest: str) -> str:
        """Keep a checkpoint where there is no room for the results; says what became of it."""
        close_partial(self.out)
        try:
            save_checkpoint(open_partial(self.out), self._solver.checkpoint(), digest)
        except OutputError:
            self._keep_partial = False
            return f"nor is there room to keep what was computed; {_short(self.out)} is as it was"
        return f"what was computed is kept in {_short(self.partial)}: make room, then go on with {_command()} --resume"

    def _stage_seconds(self, solution: Solution) -> dict[str, float]:
        """Of the program's stages and the solver's, in the order in which they ran."""
        first = {name: self.seconds[name] for name in ("reading the scene", "first picture") if name in self.seconds}
        return {**first, **solution.record["stage_seconds"], **self.seconds}

    def _outcome(self, solution: Solution, interrupted: bool) -> tuple[str, int]:
        if interrupted:
            return "interrupted", INTERRUPTED
        if not self._solver.accuracy_reached or missed_accuracy_lines(solution):
            return "accuracy not reached", INACCURATE
        return "complete", GOOD

    def _remember(self, solution: Solution) -> None:
        """Keep what was built and, unless building took part of the time, how fast the device was."""
        fresh = [build for build in self._device.builds if build not in self._known_builds]
        measured = None if fresh or self.request.resume else calibration.measure(solution)
        if fresh or measured is not None:
            calibration.store(self._device.description, fresh, measured)

    def _report(self, solution: Solution, seconds: dict[str, float], state: str) -> None:
        display = self._display
        if solution.readings:
            title = "Illuminance with 95 % intervals; accuracy is that of the worst reading"
            told = [*parts_lines(solution.readings), *audit_lines(solution.record)]
            told.append(f"intervals do not cover {NOT_COVERED}; --sensitivity tells what wrong ones would change")
            display.lines([*sensor_lines(solution.readings), *told], title=title)
        if solution.variants:
            display.lines(variant_lines(solution), title=DIFFERENCES_TITLE)
        for title, lines in self._closing:
            display.lines(lines, title=title)
        display.lines(time_lines(seconds), title="Where the time went")
        display.lines(["", account_line(solution), f"results are in {_short(self.out)}: {_listing(self.out)}"])
        if state == "interrupted":
            display.lines([f"interrupted; to go on: {_command()} --resume"])
        if state == "accuracy not reached":
            missed = [f"warning: the accuracy asked for was not reached; to go on: {_command()} --resume"]
            display.lines(missed_accuracy_lines(solution) or missed)
        result: dict[str, Any] = {
            "state": state,
            "out": str(self.out),
            "sensors": {name: sensor_record(found) for name, found in solution.readings.items()},
            "audit": solution.record["audit"],
            **self._more,
        }
        display.data("result", result)


def _command() -> str:
    """The command line of this process, without ``--resume``."""
    return shlex.join(["hradiosity", *(word for word in sys.argv[1:] if word != "--resume")])


def _listing(out: Path) -> str:
    """What the folder holds."""
    return ", ".join(sorted(f"{path.name}/" if path.is_dir() else path.name for path in out.iterdir()))


def _short(path: Path) -> str:
    """Relative to the working folder when it lies inside."""
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)
