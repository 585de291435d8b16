"""What an accuracy takes, and how well that was foreseen: ``python -m hradiosity.suites.within SCENE 2% 1% 0.5%``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.referee import RefereeState
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Readings
from hradiosity.suites.compare import compare
from hradiosity.suites.referee_cache import referee_readings

QUARTERS: Final = (0.25, 0.5, 0.75)
"""Shares of a run at which its forecast is held against what it took."""


@dataclass(frozen=True)
class Reached:
    """One run to an accuracy, from the qualities' draft.

    accuracy : asked for, of each reading
    reached : whether all readings have it
    cpu_seconds, wall_seconds : without an audit
    median, worst : accuracies of the readings
    steps, rounds : of further samples, and of replicates that others followed
    foreseen : seconds of the whole run over those it took, as it was said at `QUARTERS`; NaN where nothing was said
    rms, held : root mean square error of illuminance over unbiased paths, and share of the 95 % intervals that hold;
        NaN without a reference
    """

    accuracy: float
    reached: bool
    cpu_seconds: float
    wall_seconds: float
    median: float
    worst: float
    steps: int
    rounds: int
    foreseen: tuple[float, ...]
    rms: float = float("nan")
    held: float = float("nan")


def measure(
    scene: Scene, device: Device, accuracy: float, *, seed: int = 0, reference: Mapping[str, Readings] | None = None
) -> Reached:
    """Solve to an accuracy."""
    solver = make_solver(scene, Options.of_quality("draft", accuracy=accuracy, seed=seed), device)
    said = [(state.seconds, state.remaining) for state in solver.states()]
    solution = solver.solution()
    accuracies = np.concatenate([readings.accuracy for readings in solution.readings.values()])
    found = None
    if reference is not None:
        found = compare(solution.readings, reference, quantile=student_quantile(0.95, SCRAMBLES - 1))
    return Reached(
        accuracy=accuracy,
        reached=solver.accuracy_reached,
        cpu_seconds=solver.cpu_seconds,
        wall_seconds=said[-1][0],
        median=float(np.median(accuracies)),
        worst=float(accuracies.max()),
        steps=int(solution.record["further_samples"]),
        rounds=len(solution.record["rounds_given_up"]),
        foreseen=foreseen(said),
        **({} if found is None else {"rms": found.illuminance_rms, "held": found.covered}),
    )


def foreseen(said: Sequence[tuple[float, float | None]]) -> tuple[float, ...]:
    """Seconds that a run was said to take in all over those it took, at `QUARTERS` of them.

    Parameters
    ----------
    said : sequence of (float, float or None)
        Seconds so far, and what was said to be left then; the last is the end.
    """
    end = said[-1][0]
    shares = []
    for quarter in QUARTERS:
        known = [so_far + left for so_far, left in said if left is not None and so_far <= quarter * end]
        shares.append(known[-1] / end if known else float("nan"))
    return tuple(shares)


HEADER: Final = (
    f"{'accuracy':>8} {'CPU s':>7} {'wall s':>7} {'median':>7} {'worst':>7} {'steps':>5} {'rounds':>6} "
    f"{'foreseen at 1/4, 1/2, 3/4':>26} {'lx rms':>7} {'held':>6}"
)


def line(found: Reached) -> str:
    """One row of the table; accuracies and errors in percent."""
    forecasts = " ".join(f"{share:8.2f}" for share in found.foreseen)
    percent = [f"{100.0 * value:6.2f}%" for value in (found.median, found.worst)]
    late = "" if found.reached else "  not reached"
    return (
        f"{100.0 * found.accuracy:7g}% {found.cpu_seconds:7.1f} {found.wall_seconds:7.1f} {' '.join(percent)} "
        f"{found.steps:5d} {found.rounds:6d} {forecasts} {100.0 * found.rms:6.2f}% {found.held:6.3f}{late}"
    )


def main() -> None:
    """Print the table."""
    options = _arguments()
    scene, device = load_scene(options.scene), Device()
    reference = None
    if options.paths:
        reference = referee_readings(scene, device, options.paths, cache=options.cache, progress=_show)
        sys.stderr.write("\n")
    measure(scene, device, 1.0, seed=options.seed)
    print(f"{scene.name}: {sum(len(s.position) for s in scene.sensors)} readings, each within the accuracy")
    print(HEADER)
    found = []
    for accuracy in options.accuracies:
        found.append(measure(scene, device, accuracy, seed=options.seed, reference=reference))
        print(line(found[-1]), flush=True)
    if options.json:
        options.json.write_text(json.dumps([asdict(some) for some in found], indent=2) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", type=Path, help="a scene folder or file")
    parser.add_argument("accuracies", type=_share, nargs="+", help="such as 1%% or 0.01")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--paths", type=int, default=0, help="of the referee, from each reading; none by default")
    parser.add_argument("--cache", type=Path, help=".npz file that keeps the referee's readings")
    parser.add_argument("--json", type=Path, help="file for the figures")
    return parser.parse_args()


def _share(text: str) -> float:
    """A share above 0, in percent or as a number."""
    try:
        share = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        share = 0.0
    if not 0.0 < share < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is no accuracy such as 1% or 0.01".replace("%", "%%"))
    return share


def _show(state: RefereeState) -> None:
    sys.stderr.write(f"\rreferee: {state.paths} of {state.wanted} paths, {state.cpu_seconds:.0f} CPU s")


if __name__ == "__main__":
    main()
