"""The end of a render: results written and put in place, and a report of what came out."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hradiosity.cli import GOOD, INACCURATE, INTERRUPTED
from hradiosity.cli.auditing import audit_lines, missed_accuracy_lines
from hradiosity.cli.comparing import DIFFERENCES_TITLE, variant_lines
from hradiosity.cli.imaging import remember_images
from hradiosity.cli.interrupts import held_back, let_through
from hradiosity.cli.live_files import rescue
from hradiosity.cli.mapping import write_maps
from hradiosity.cli.request import PREVIEW, Run, command, short
from hradiosity.cli.sensing import NOT_COVERED
from hradiosity.cli.text import (
    account_line,
    glare_lines,
    image_lines,
    maintained_lines,
    note_lines,
    outside_lines,
    parts_lines,
    sensor_lines,
    time_lines,
)
from hradiosity.errors import OutputError
from hradiosity.io import calibration
from hradiosity.io.live_light import remove_live
from hradiosity.io.output_folder import publish
from hradiosity.io.results import write_glare, write_results, write_run
from hradiosity.io.results_variants import variants_record
from hradiosity.io.run_record import sensor_record
from hradiosity.radiosity import RadiositySolver
from hradiosity.readings.glare import glare_of
from hradiosity.solution import Solution

if TYPE_CHECKING:
    from hradiosity.show.pictures import PictureOptions, PictureSet

GLARE_TITLE = "Glare of observers: UGR (CIE 117) with half widths; glare_sources.csv has the luminaires that count"
MAINTAINED_TITLE = (
    "Maintained illuminance: with what the lamps' light has left before maintenance; the sky keeps its own"
)


def finish(run: Run, solver: RadiositySolver, solution: Solution, digest: str, interrupted: bool) -> int:
    """Write the results, put them in place, and say what came out; returns the exit status."""
    start = time.perf_counter()
    run.display.stage("writing the results")
    with held_back() as came:
        try:
            parts = run.request.outputs.interval_parts
            write_results(run.partial, solution, solver.checkpoint(), digest, parts=parts)
            _rate_glare(run, solver, solution)
            if run.request.outputs.mapped and not interrupted and not came:
                interrupted = write_maps(run, solver, solution)
            if run.request.outputs.pictures and not interrupted and not came:
                interrupted = _draw(run, solver, solution)
        except OutputError as error:
            raise OutputError(f"{error}; {rescue(run, solver, digest)}") from error
        interrupted = interrupted or bool(came)
        others = sum(run.seconds.get(name, 0.0) for name in ("maps", "pictures"))
        run.seconds["writing"] = time.perf_counter() - start - others
        state, code = _outcome(solver, solution, interrupted)
        seconds = _stage_seconds(run, solution)
        if solution.variants:
            run.more["variants"] = variants_record(solution)
        run.more["intervals_do_not_cover"] = NOT_COVERED
        write_run(run.partial, solution, state, {"stage_seconds": seconds, "command": command(), **run.more})
        publish(run.out)
        remove_live(run.out)
    run.keep_partial = False
    _remember(run, solution)
    run.display.close()
    _report(run, solution, seconds, state)
    return code


def _rate_glare(run: Run, solver: RadiositySolver, solution: Solution) -> None:
    """UGR of the observers that the scene asks for, written and told."""
    glare = glare_of(solution.scene, solution.readings, solver.on_device.bvh)
    if glare:
        write_glare(run.partial, solution.scene, glare)
        run.closing.append((GLARE_TITLE, glare_lines(glare)))


def _draw(run: Run, solver: RadiositySolver, solution: Solution) -> bool:
    """Draw the pictures; returns whether that was interrupted."""
    from hradiosity.show.pictures import PictureOptions, write_pictures

    start = time.perf_counter()
    wanted = run.request.outputs
    options = PictureOptions(
        white=wanted.white.value,
        quantity=wanted.false_color,
        logarithmic=wanted.false_color_scale == "log",
        scale_range=wanted.false_color_range,
    )
    run.display.stage("drawing pictures")
    folder, interrupted = run.partial / "pictures", False
    try:
        with let_through():
            if run.request.images:
                drawn, interrupted = _gather(run, solver, solution, options)
            else:
                drawn = write_pictures(solution, folder, run.device, options, on_device=solver.on_device)
    except KeyboardInterrupt:
        return True
    (run.partial / PREVIEW).unlink(missing_ok=True)
    run.seconds["pictures"] = time.perf_counter() - start
    run.more["pictures"] = drawn.record
    run.closing.append(("", note_lines(drawn.notes)))
    return interrupted


def _gather(run: Run, solver: RadiositySolver, solution: Solution, options: PictureOptions) -> tuple[PictureSet, bool]:
    """Compute the images; returns whether that was interrupted too."""
    from hradiosity.show.image_pictures import ImageOptions, write_images

    wanted = run.request.outputs
    asked = ImageOptions(
        samples=wanted.image_samples,
        noise=wanted.image_noise,
        size=wanted.image_size,
        spectra=wanted.image_spectra,
    )
    cpu = time.process_time()
    drawn, interrupted = write_images(
        solution,
        run.partial / "pictures",
        run.device,
        options,
        asked,
        on_device=solver.on_device,
        progress=run.display.stage,
    )
    remember_images(run.device.description, drawn.record, len(solution.scene.bands))
    run.closing.append(("Images", image_lines(drawn.record, time.process_time() - cpu)))
    return drawn, interrupted


def _stage_seconds(run: Run, solution: Solution) -> dict[str, float]:
    """Of the program's stages and the solver's, in the order in which they ran."""
    first = {name: run.seconds[name] for name in ("reading the scene", "first picture") if name in run.seconds}
    return {**first, **solution.record["stage_seconds"], **run.seconds}


def _outcome(solver: RadiositySolver, solution: Solution, interrupted: bool) -> tuple[str, int]:
    if interrupted:
        return "interrupted", INTERRUPTED
    if not solver.accuracy_reached or missed_accuracy_lines(solution):
        return "accuracy not reached", INACCURATE
    return "complete", GOOD


def _remember(run: Run, solution: Solution) -> None:
    """Keep what was built and, unless building took part of the time, how fast the device was."""
    fresh = [build for build in run.device.builds if build not in run.known_builds]
    measured = None if fresh or run.request.outputs.resume else calibration.measure(solution)
    if fresh or measured is not None:
        calibration.store(run.device.description, fresh, measured)


def _report(run: Run, solution: Solution, seconds: dict[str, float], state: str) -> None:
    display = run.display
    if solution.readings:
        title = "Illuminance with 95 % intervals; accuracy is that of the worst reading"
        told = [*parts_lines(solution.readings), *audit_lines(solution.record), *outside_lines(solution.scene.bands)]
        told.append(f"intervals do not cover {NOT_COVERED}; --sensitivity tells what wrong ones would change")
        display.lines([*sensor_lines(solution.readings), *told], title=title)
    for lines, title in (
        (maintained_lines(solution), MAINTAINED_TITLE),
        (variant_lines(solution), DIFFERENCES_TITLE),
    ):
        if lines:
            display.lines(lines, title=title)
    for title, lines in run.closing:
        display.lines(lines, title=title)
    display.lines(time_lines(seconds), title="Where the time went")
    display.lines(["", account_line(solution), f"results are in {short(run.out)}: {_listing(run.out)}"])
    if state == "interrupted":
        display.lines([f"interrupted; to go on: {command()} --resume"])
    if state == "accuracy not reached":
        missed = [f"warning: the accuracy asked for was not reached; to go on: {command()} --resume"]
        display.lines(missed_accuracy_lines(solution) or missed)
    result: dict[str, Any] = {
        "state": state,
        "out": str(run.out),
        "sensors": {name: sensor_record(found) for name, found in solution.readings.items()},
        "audit": solution.record["audit"],
        **run.more,
    }
    display.data("result", result)


def _listing(out: Path) -> str:
    """What the folder holds."""
    return ", ".join(sorted(f"{path.name}/" if path.is_dir() else path.name for path in out.iterdir()))
