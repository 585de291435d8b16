"""Errors of illuminance maps against elements and time: ``python -m hradiosity.suites.maps SCENE …``."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.referee import RefereeState
from hradiosity.show.line_plot import Line, Panel, draw_lines
from hradiosity.suites.cost.settings import bands_like
from hradiosity.suites.maps.measure import MapBench, MapOutcome, elements_ratio
from hradiosity.suites.maps.points import floor_sides, spread_points, unbiased_map

BANDS = 20
"""Illuminance needs no more, and the reference then takes a third of the time."""
HEADER = (
    f"{'leaves':>10} {'wanted':>7} {'number':>8} {'read':>7} {'direct':>7} {'refl.':>7} {'all':>7} {'flat':>7} "
    f"{'interval':>8} {'CPU s':>7}"
)


def line(outcome: MapOutcome) -> str:
    """One row of the table; errors in percent of the mean."""
    shares = (outcome.direct, outcome.reflected, outcome.total, outcome.flat)
    percent = " ".join(_number(100.0 * s, 7, 3) for s in shares)
    return (
        f"{outcome.kind:>10} {_number(100.0 * outcome.wanted, 7, 1)} {outcome.leaves:8d} {outcome.read:7d} "
        f"{percent} {_number(100.0 * outcome.half_width, 8, 2)} {outcome.seconds:7.2f}"
    )


def measure(path: Path, device: Device, options: argparse.Namespace) -> tuple[list[MapOutcome], str]:
    """Outcomes of one scene, and what was measured in words."""
    scene = _scene(path)
    asked = Options(elements=options.elements, gather_samples=options.gather_samples, light_samples=256)
    solver = make_solver(scene, asked, device)
    start = time.process_time()
    for _ in solver.states():
        pass
    seconds = time.process_time() - start
    solution = solver.solution()
    lit = (solver.lit.space >= 0).ravel()
    sides = floor_sides(solution.scene, lit) if options.part == "floor" else np.flatnonzero(lit)
    points = spread_points(solution.scene, sides, options.points)
    options.cache.mkdir(parents=True, exist_ok=True)
    kept = options.cache / f"{path.name}_{options.part}_{options.points}_{options.paths}.npz"
    truth = unbiased_map(solution.scene, device, points, options.paths, cache=kept, progress=_show)
    noise = float(np.sqrt((truth.noise**2).mean()) / truth.lux.mean())
    words = (
        f"{scene.name}, {options.part}: {len(truth.lux)} points, mean {truth.lux.mean():.1f} lx; "
        f"{len(solution.elements)} elements solved in {seconds:.1f} CPU s; noise of the reference {100 * noise:.2f} %"
    )
    print(words, HEADER, sep="\n", flush=True)
    bench = MapBench.of(solution, solver.on_device, sides, truth)
    outcomes = [bench.elements(seconds)]
    print(line(outcomes[0]), flush=True)
    for outcome in bench.adaptive(options.errors):
        outcomes.append(outcome)
        print(line(outcome), flush=True)
    for outcome in bench.uniform(options.levels, options.most_read, min(options.errors)):
        outcomes.append(outcome)
        print(line(outcome), flush=True)
    for text in _ratios(outcomes):
        print(text)
    return outcomes, words


def _scene(path: Path) -> Scene:
    """Without sensors and in few bands."""
    bands = load_scene(path).bands
    return replace(load_scene(path, bands=bands_like(bands, min(BANDS, len(bands)))), sensors=(), variants=())


def _ratios(outcomes: Sequence[MapOutcome]) -> list[str]:
    """Uniform over adaptive leaves at errors that both reach."""
    few, many = ([o for o in outcomes if o.kind == kind] for kind in ("adaptive", "uniform"))
    texts = []
    for part, word in (("direct", "direct light"), ("total", "all light")):
        found = [(error, elements_ratio(few, many, error, part)) for error in (0.05, 0.03, 0.02, 0.015, 0.01, 0.007)]
        told = ", ".join(f"{ratio:.1f} at {100 * error:g} %" for error, ratio in found if math.isfinite(ratio))
        texts.append(f"uniform over adaptive leaves, {word}: {told or 'no common error'}")
    return texts


def _panels(outcomes: Sequence[MapOutcome]) -> list[Panel]:
    panels = []
    for part, word in (("direct", "direct light"), ("total", "all light")):
        lines = []
        for kind in ("adaptive", "uniform"):
            known = sorted((o.leaves, 100.0 * getattr(o, part)) for o in outcomes if o.kind == kind)
            known = [(n, e) for n, e in known if e > 0.0]
            if known:
                lines.append(Line(f"{kind} leaves", [n for n, _ in known], [e for _, e in known]))
        label = "rms error over mean illuminance, %"
        panels.append(Panel(word, "leaves", label, lines, [("1 %", 1.0)]))
    return panels


def main() -> None:
    """Print the tables, and write plots."""
    options = _arguments()
    device = Device()
    kept = {}
    for path in options.scenes:
        outcomes, words = measure(path, device, options)
        kept[path.name] = [asdict(o) for o in outcomes]
        if options.out:
            options.out.mkdir(parents=True, exist_ok=True)
            title = f"Illuminance map of {path.name.replace('_', ' ')}, {options.part}"
            plot = draw_lines(_panels(outcomes), title)
            (options.out / f"{path.name}_{options.part}.svg").write_text(plot, encoding="utf-8")
            table = "\n".join([words, "", HEADER, *map(line, outcomes), "", *_ratios(outcomes)])
            (options.out / f"{path.name}_{options.part}.txt").write_text(table + "\n", encoding="utf-8")
    if options.json:
        options.json.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scenes", type=Path, nargs="+", help="scene folders")
    parser.add_argument("--part", choices=("floor", "all"), default="floor", help="surfaces of the map")
    parser.add_argument("--points", type=int, default=4096, help="of the reference")
    parser.add_argument("--paths", type=int, default=4096, help="of the referee, from each point")
    parser.add_argument("--cache", type=Path, default=Path("out/maps"), help="folder that keeps the referee's light")
    parser.add_argument("--elements", type=int, default=3000, help="row elements")
    parser.add_argument(
        "--gather-samples", type=int, default=512, help="of a reading, which maps multiply as their error asks for"
    )
    parser.add_argument(
        "--errors", type=_errors, default=[0.05, 0.03, 0.02, 0.01], help="that are asked for, 0.05,0.01"
    )
    parser.add_argument("--levels", type=int, default=4, help="sizes of uniform leaves, each half of the one before")
    parser.add_argument(
        "--most-read", type=int, default=60000, help="vertices of leaves of one size at which reflected light is read"
    )
    parser.add_argument("--out", type=Path, help="folder for plots and tables")
    parser.add_argument("--json", type=Path, help="write the figures there as well")
    return parser.parse_args()


def _errors(text: str) -> list[float]:
    return [float(part) for part in text.split(",")]


def _number(value: float, width: int, digits: int) -> str:
    return f"{value:{width}.{digits}f}" if math.isfinite(value) else " " * (width - 1) + "-"


def _show(state: RefereeState) -> None:
    sys.stderr.write(f"\rreferee: {state.paths} of {state.wanted} paths, {state.cpu_seconds:.0f} CPU s ")


if __name__ == "__main__":
    main()
