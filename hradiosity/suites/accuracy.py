"""Errors and cost of the solver on a scene, against unbiased paths: ``python -m hradiosity.suites.accuracy SCENE``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, cast

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.options import QUALITIES, Options, Quality
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.referee import RefereeState
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Readings
from hradiosity.suites.compare import Comparison, compare
from hradiosity.suites.referee_cache import referee_readings


@dataclass(frozen=True)
class Outcome:
    """What one setting gave.

    rays : traced by the solver
    cpu_seconds, wall_seconds : from the ray structure to the last reading
    """

    setting: str
    elements: int
    rays: int
    cpu_seconds: float
    wall_seconds: float
    error: Comparison


def measure(scene: Scene, device: Device, name: str, reference: Mapping[str, Readings], *, seed: int = 0) -> Outcome:
    """Solve with the setting `name`, see `options_of`, and compare with the reference."""
    solver = make_solver(scene, replace(options_of(name), seed=seed), device)
    wall = 0.0
    for state in solver.states():
        wall = state.seconds
    solution = solver.solution()
    return Outcome(
        setting=name,
        elements=len(solution.elements),
        rays=int(solution.record["rays"]),
        cpu_seconds=solver.cpu_seconds,
        wall_seconds=wall,
        error=compare(solution.readings, reference, quantile=student_quantile(0.95, SCRAMBLES - 1)),
    )


def options_of(name: str) -> Options:
    """Of a quality; before a colon there may be the mode, or "hierarchical", or "hierarchical=0.05" with the largest
    form factor of a link.

    Raises
    ------
    ValueError
        For names that are none of these.
    """
    way, _, quality = name.rpartition(":")
    if quality not in QUALITIES:
        raise ValueError(f"{name}: not among {', '.join(QUALITIES)}")
    kind, _, largest = way.partition("=")
    chosen: dict[str, Any] = {"mode": way} if way else {}
    if kind == "hierarchical":
        chosen = {"links": kind} | ({"link_form_factor": float(largest)} if largest else {})
    return Options.of_quality(cast(Quality, quality), **chosen)


HEADER = (
    f"{'setting':>24} {'elements':>8} {'Mrays':>7} {'CPU s':>7} {'wall s':>7} "
    f"{'spectral':>8} {'lx rms':>8} {'lx 95%':>8} {'lx max':>8} {'bias':>8} {'covered':>7}"
)


def line(outcome: Outcome) -> str:
    """One row of the table; errors in percent."""
    error = outcome.error
    percent = (error.spectral_rms, error.illuminance_rms, error.illuminance_p95, error.illuminance_max, error.bias)
    return (
        f"{outcome.setting:>24} {outcome.elements:8d} {outcome.rays / 1e6:7.2f} {outcome.cpu_seconds:7.2f} "
        f"{outcome.wall_seconds:7.2f} " + " ".join(f"{100.0 * p:8.3f}" for p in percent) + f" {error.covered:7.3f}"
    )


def main() -> None:
    """Print the table."""
    options = _arguments()
    scene, device = load_scene(options.scene), Device()
    reference = referee_readings(scene, device, options.paths, cache=options.cache, progress=_show)
    sys.stderr.write("\n")
    measure(scene, device, "draft", reference)
    print(f"{scene.name}: {sum(len(s.position) for s in scene.sensors)} readings; errors in %")
    print(HEADER)
    outcomes = []
    for name in options.settings:
        outcomes.append(measure(scene, device, name, reference))
        print(line(outcomes[-1]), flush=True)
    noise = outcomes[-1].error
    print(
        f"noise of the reference: {100 * noise.reference_spectral_rms:.3f} spectral, "
        f"{100 * noise.reference_illuminance_rms:.3f} illuminance"
    )
    if options.json:
        options.json.write_text(json.dumps([asdict(o) for o in outcomes], indent=2) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", type=Path, help="a scene folder or file")
    parser.add_argument("--paths", type=int, default=16384, help="of the referee, from each reading")
    parser.add_argument("--cache", type=Path, help=".npz file that keeps the referee's readings")
    parser.add_argument(
        "--settings",
        type=_settings,
        default=list(QUALITIES),
        help="draft,normal,fine; classic:draft; hierarchical=0.05:draft",
    )
    parser.add_argument("--json", type=Path, help="write the figures there as well")
    return parser.parse_args()


def _settings(text: str) -> list[str]:
    names = text.split(",")
    for name in names:
        try:
            options_of(name)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from error
    return names


def _show(state: RefereeState) -> None:
    sys.stderr.write(
        f"\rreferee: {state.paths} of {state.wanted} paths, {state.cpu_seconds:.0f} CPU s, "
        f"median half width {100 * state.median_error:.2f} %"
    )


if __name__ == "__main__":
    main()
