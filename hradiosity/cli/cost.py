"""``hradiosity cost``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from hradiosity.cli import GOOD, INTERRUPTED
from hradiosity.cli.values import seconds
from hradiosity.errors import Fault, SceneError

if TYPE_CHECKING:
    from hradiosity.cli.display import Display
    from hradiosity.device import Device
    from hradiosity.model.scene import Scene
    from hradiosity.suites.cost.bench import SceneBench
    from hradiosity.suites.cost.protocols import Event
    from hradiosity.suites.cost.running import CostRun
    from hradiosity.suites.cost.values import Report

BUDGET = 120.0
REFEREE_FILE = "referee.npz"
"""Keeps the referee's paths in the folder of results; another run of the same scene goes on from there."""


def cost(
    scene: Path,
    /,
    *,
    budget: Annotated[float, Parameter(converter=seconds)] = BUDGET,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    device: str | None = None,
    quiet: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    json: Annotated[bool, Parameter(negative="", show_default=False)] = False,
) -> int:
    """Show what accuracy costs in time on a scene: settings, solvers, effects and bands against unbiased paths.

    Writes tables (cost.csv, bands.csv, cost.json, cost.md) and a picture (cost.png), and recommends settings. Ctrl-C
    writes what is known. Plan and render --accuracy use what was learnt. Once more into the same folder, the
    referee's paths of before count as well.

    Exit status: 0 good, 2 bad input, 130 interrupted.

    Parameters
    ----------
    scene
        Folder with scene.toml, or the file; it needs sensors.
    budget
        Wall time of everything, like 30s or 2min; the longer, the more settings and the less noise.
    out
        Folder for the results, replaced as a whole at the end; results/NAME-cost if left out.
    device
        Number from `hradiosity devices`, or a part of the device's name.
    quiet
        Show nothing but errors.
    json
        One JSON object a line on standard output in place of words.
    """
    from hradiosity.cli.display import JsonDisplay
    from hradiosity.cli.interrupts import held_back, termination_interrupts
    from hradiosity.cli.render import name_of
    from hradiosity.device import Device
    from hradiosity.io.output_folder import close_partial, open_partial
    from hradiosity.io.output_lock import locked
    from hradiosity.io.scene_toml import load_scene
    from hradiosity.suites.cost.bench import SceneBench
    from hradiosity.suites.cost.reference import SEED
    from hradiosity.suites.referee_cache import load_samples, save_samples, scene_digest

    loaded = load_scene(scene)
    _check(loaded, scene)
    folder = (out if out is not None else Path("results") / f"{name_of(scene)}-cost").resolve()
    opened, display = Device(device), JsonDisplay() if json else _plain(quiet=quiet)
    with locked(folder):
        with held_back() as came:
            partial = open_partial(folder)
        try:
            if came:
                raise KeyboardInterrupt
            with termination_interrupts(), display:
                kept = load_samples(folder / REFEREE_FILE, scene_digest(loaded), SEED, 1)
                bench = SceneBench(replace(loaded, variants=()), opened, kept)
                report, learnt = _measure(bench, scene, budget, display)
                save_samples(partial / REFEREE_FILE, scene_digest(loaded), SEED, bench.reference.samples())
                _finish(report, folder, partial, display)
        finally:
            close_partial(folder)
    _remember(loaded, opened, learnt)
    return GOOD if report.complete else INTERRUPTED


def _check(scene: Scene, path: Path) -> None:
    """A scene without readings has no error."""
    if not any(len(sensor.position) for sensor in scene.sensors):
        raise SceneError([Fault(str(path), "sensor", "the scene has no sensor", "one: cost compares readings")])


def _measure(bench: SceneBench, path: Path, budget: float, display: Display) -> tuple[Report, CostRun]:
    """Run everything; an interruption ends it early."""
    from hradiosity.io.scene_toml import load_scene
    from hradiosity.suites.cost.reporting import report_of
    from hradiosity.suites.cost.running import CostRun
    from hradiosity.suites.cost.settings import bands_like

    usual = bench.scene.bands
    run = CostRun(bench, budget, lambda count: replace(load_scene(path, bands=bands_like(usual, count)), variants=()))
    complete = True
    try:
        for event in run.events():
            display.data(event.kind, event.values)
            display.lines(_words(event))
    except KeyboardInterrupt:
        complete = False
    _check_known(run, bench, budget, complete=complete)
    return report_of(run, bench, complete=complete), run


def _check_known(run: CostRun, bench: SceneBench, budget: float, *, complete: bool) -> None:
    """Something must have been measured.

    Raises
    ------
    KeyboardInterrupt
        When nothing was known yet.
    SceneError
        When the budget did not suffice for anything.
    """
    if run.runs and bench.reference.paths:
        if not any(found.illuminance.any() for found in bench.reference.readings().values()):
            raise SceneError([Fault("sensors", "", "no reading has any light", "sensors where light comes")])
        return
    if not complete:
        raise KeyboardInterrupt
    least = min((item.predicted for item in run.skipped if item.predicted is not None), default=budget)
    wanted = f"more: the cheapest setting takes about {least:.1f} s, and everything else comes on top"
    raise SceneError([Fault("command line", "--budget", f"{budget:g} s suffice for nothing", wanted)])


def _finish(report: Report, folder: Path, partial: Path, display: Display) -> None:
    """Write the files, put them in place, and say what came out."""
    from hradiosity.cli.interrupts import held_back
    from hradiosity.io.output_folder import PROGRAM, RUN_FILE, publish, write_file
    from hradiosity.io.run_record import to_json, versions
    from hradiosity.suites.cost.files import cost_record, markdown_lines, write_cost

    with held_back():
        write_cost(partial, report)
        state = "complete" if report.complete else "interrupted"
        record = {"program": PROGRAM, "state": state, "kind": "cost", "versions": versions()}
        write_file(partial / RUN_FILE, (to_json(record, indent=1) + "\n").encode())
        publish(folder)
    display.lines(["", *markdown_lines(report), ""])
    display.lines([f"results are in {folder}: cost.png, cost.csv, bands.csv, cost.json, cost.md"])
    display.data("result", {"state": state, "out": str(folder), **cost_record(report)})


def _remember(scene: Scene, device: Device, run: CostRun) -> None:
    """Keep what plan and render can use."""
    from hradiosity.io.learnt import store_learnt
    from hradiosity.suites.cost.reporting import learnt_of
    from hradiosity.suites.referee_cache import scene_digest

    store_learnt(device.description, scene_digest(scene), learnt_of(run))


def _words(event: Event) -> list[str]:
    """An event as a line."""
    from hradiosity.suites.cost.words import seconds_text, share_text

    values: dict[str, Any] = event.values
    at = f"{values.get('spent', 0.0):6.1f} s "
    if event.kind == "run":
        error = values.get("illuminance_rms")
        found = "" if error is None else f", illuminance {share_text(error)}"
        again = f" (seed {values['seed']})" if values["seed"] else ""
        return [f"{at} {values['setting']}{again}: {seconds_text(values['cpu_seconds'])} of CPU{found}"]
    if event.kind == "skipped":
        # Those that are too long are many, and told together at the end.
        return [] if values["predicted"] is not None else [f"{at} not run: {values['name']}: {values['reason']}"]
    if event.kind == "reference":
        return [f"{at} referee: {values['paths']} paths from each reading, noise {share_text(values['noise'])}"]
    if event.kind == "solver":
        spent, residual = seconds_text(values["cpu_seconds"]), values["residual"]
        return [f"{at} solver {values['name']}: {spent} of CPU, residual {residual:.1e}"]
    if event.kind == "effect":
        return [f"{at} {values['name']}: {seconds_text(values['forced_seconds'])} of CPU"]
    return [f"{at} {values['bands']} bands: {seconds_text(values['cpu_seconds'])} of CPU"]


def _plain(*, quiet: bool) -> Display:
    """Lines, or nothing."""
    from hradiosity.cli.display import Display, PlainDisplay

    return Display() if quiet else PlainDisplay()
