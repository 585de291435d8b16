"""Cost of scenes of growing size at one accuracy: ``python -m hradiosity.suites.growth SMALLEST … LARGEST``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import Estimate, student_quantile
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene, Sensor
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.radiosity.referee import RefereeState
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.show.line_plot import Line, Panel, draw_lines
from hradiosity.solution import Readings
from hradiosity.suites.compare import compare
from hradiosity.suites.cost.memory import PeakMemory
from hradiosity.suites.referee_cache import referee_readings

SAMPLE = "sample"
EQUAL_ERROR = 0.01
"""Spectral rms error, without the reference's noise, at which scenes are compared."""


@dataclass(frozen=True)
class Step:
    """What one scene took.

    faces, emitters, readings, elements, rays : numbers
    cpu_seconds : from the ray structure to the last reading
    stages : wall seconds by stage
    memory_bytes : that the run added at its peak; None where the system can't tell
    spectral_rms, illuminance_rms, bias : of the sampled readings, noise of the reference included
    noise : spectral standard error of the reference
    interval : median half width over illuminance
    covered : share of the sampled readings whose intervals hold the reference
    """

    scene: str
    faces: int
    emitters: int
    readings: int
    elements: int
    rays: int
    cpu_seconds: float
    stages: dict[str, float]
    memory_bytes: int | None
    spectral_rms: float
    illuminance_rms: float
    bias: float
    noise: float
    interval: float
    covered: float

    @property
    def own_rms(self) -> float:
        """Spectral error without the noise of the reference."""
        return float(np.sqrt(max(self.spectral_rms**2 - self.noise**2, 0.0)))

    @property
    def equal_seconds(self) -> float:
        """CPU seconds that `EQUAL_ERROR` would take if all of the error were noise: as its square over the error's."""
        return self.cpu_seconds * (self.own_rms / EQUAL_ERROR) ** 2


def sampled(scene: Scene, count: int, seed: int = 7) -> tuple[Scene, NDArray[np.int64]]:
    """The scene with one sensor, of readings drawn from all sensors; and their numbers over all of them."""
    position = np.concatenate([sensor.position for sensor in scene.sensors])
    normal = np.concatenate([sensor.normal for sensor in scene.sensors])
    drawn = np.sort(np.random.default_rng(seed).permutation(len(position))[:count])
    return replace(scene, sensors=(Sensor(SAMPLE, position[drawn], normal[drawn]),), variants=()), drawn


def measure(path: Path, device: Device, options: Options, count: int, paths: int, cache: Path) -> Step:
    """Solve a scene with all its readings, and compare some of them with unbiased paths."""
    scene = load_scene(path)
    few, drawn = sampled(scene, count)
    cache.mkdir(parents=True, exist_ok=True)
    kept = cache / f"{path.name}_{count}_{paths}.npz"
    reference = referee_readings(few, device, paths, cache=kept, progress=_show)
    memory = PeakMemory()
    solver = make_solver(scene, options, device)
    for _ in solver.states():
        pass
    solution = solver.solution()
    added = memory.added()
    error = compare(of_sample(solution.readings, drawn), reference, quantile=student_quantile(0.95, SCRAMBLES - 1))
    light = solution.readings.values()
    lux, half_width = (
        np.concatenate([getattr(r, n) for r in light]) for n in ("illuminance", "illuminance_half_width")
    )
    return Step(
        scene=path.name,
        faces=len(scene.patches),
        emitters=len(scene.emitters),
        readings=sum(len(sensor.position) for sensor in scene.sensors),
        elements=len(solution.elements),
        rays=int(solution.record["rays"]),
        cpu_seconds=solver.cpu_seconds,
        stages=dict(solver.record.seconds),
        memory_bytes=added,
        spectral_rms=error.spectral_rms,
        illuminance_rms=error.illuminance_rms,
        bias=error.bias,
        noise=error.reference_spectral_rms,
        interval=float(np.median(half_width[lux > 0.0] / lux[lux > 0.0])),
        covered=error.covered,
    )


def of_sample(readings: Mapping[str, Readings], drawn: NDArray[np.int64]) -> dict[str, Readings]:
    """Those readings, by number over all sensors, as one sensor."""
    every = list(readings.values())
    position, normal, enclosed = (
        np.concatenate([getattr(found, name) for found in every])[drawn] for name in ("position", "normal", "enclosed")
    )
    numbers = {name: _joined([found.numbers[name] for found in every], drawn) for name in ("irradiance", "illuminance")}
    return {SAMPLE: Readings(SAMPLE, position, normal, enclosed, numbers)}


def _joined(estimates: Sequence[Estimate], drawn: NDArray[np.int64]) -> Estimate:
    others = {name: np.concatenate([e.others[name] for e in estimates])[drawn] for name in estimates[0].others}
    return replace(
        estimates[0],
        value=np.concatenate([e.value for e in estimates])[drawn],
        standard_error=np.concatenate([e.standard_error for e in estimates])[drawn],
        others=others,
    )


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of the straight line through logarithms; NaN with fewer than two points."""
    if len(x) < 2:
        return float("nan")
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


HEADER = (
    f"{'scene':>12} {'faces':>8} {'lamps':>5} {'readings':>8} {'elements':>8} {'Mrays':>7} {'CPU s':>7} {'MiB':>6} "
    f"{'spectral':>8} {'noise':>6} {'own':>6} {'lx rms':>7} {'bias':>7} {'interval':>8} {'covered':>7} {'s at 1 %':>8}"
)


def line(step: Step) -> str:
    """One row of the table; errors in percent."""
    memory = "-" if step.memory_bytes is None else f"{step.memory_bytes / 2**20:.0f}"
    percent = [100.0 * p for p in (step.spectral_rms, step.noise, step.own_rms, step.illuminance_rms, step.bias)]
    return (
        f"{step.scene:>12} {step.faces:8d} {step.emitters:5d} {step.readings:8d} {step.elements:8d} "
        f"{step.rays / 1e6:7.1f} {step.cpu_seconds:7.1f} {memory:>6} {percent[0]:8.3f} {percent[1]:6.3f} "
        f"{percent[2]:6.3f} {percent[3]:7.3f} {percent[4]:7.3f} {100.0 * step.interval:8.2f} {step.covered:7.3f} "
        f"{step.equal_seconds:8.1f}"
    )


def stage_lines(steps: Sequence[Step]) -> list[str]:
    """Wall seconds of each stage, and how they grow with the faces."""
    names = sorted({name for step in steps for name in step.stages}, key=lambda name: -steps[-1].stages.get(name, 0.0))
    faces = [step.faces for step in steps]
    texts = []
    for name in names:
        seconds = [step.stages.get(name, 0.0) for step in steps]
        power = f"{exponent(faces, seconds):6.2f}" if min(seconds) > 0.0 else "     -"
        texts.append(f"{name:>16} {power}  " + " ".join(f"{value:8.2f}" for value in seconds))
    return texts


def summary(steps: Sequence[Step]) -> list[str]:
    """Exponents of what grows."""
    faces = [step.faces for step in steps]
    known = {
        "CPU seconds": [step.cpu_seconds for step in steps],
        "CPU seconds at 1 % (× error²)": [step.equal_seconds for step in steps],
        "rays": [float(step.rays) for step in steps],
        "elements": [float(step.elements) for step in steps],
    }
    if all(step.memory_bytes for step in steps):
        known["memory"] = [float(step.memory_bytes or 0) for step in steps]
    fits = [f"{name} ∝ faces^{exponent(faces, values):.2f}" for name, values in known.items()]
    linear = exponent(faces, [n * np.log(n) for n in faces])
    return ["; ".join(fits), f"linear × log would be faces^{linear:.2f}"]


def plot(steps: Sequence[Step]) -> str:
    """SVG: seconds of the run and at one error, error, and memory against faces."""
    faces = [step.faces for step in steps]
    first = steps[0]
    guide = [first.cpu_seconds * n * np.log(n) / (first.faces * np.log(first.faces)) for n in faces]
    seconds = [
        Line("whole run, CPU s", faces, [step.cpu_seconds for step in steps]),
        Line("the same at 1 % error, CPU s", faces, [max(step.equal_seconds, 1e-3) for step in steps]),
    ]
    seconds.append(Line("linear × log", faces, guide, guide=True))
    errors = [
        Line("spectral rms", faces, [100.0 * step.spectral_rms for step in steps]),
        Line("without the reference's noise", faces, [100.0 * max(step.own_rms, 1e-5) for step in steps]),
        Line("median half width, lx", faces, [100.0 * step.interval for step in steps]),
    ]
    panels = [Panel("seconds", "faces", "s", seconds), Panel("accuracy", "faces", "%", errors)]
    if all(step.memory_bytes for step in steps):
        sizes = [(step.memory_bytes or 0) / 2**20 for step in steps]
        panels.append(Panel("peak memory that a run adds", "faces", "MiB", [Line("memory", faces, sizes)]))
    return draw_lines(panels, "A hall that grows")


def main() -> None:
    """Print the tables, and write them and a plot."""
    asked = _arguments()
    device = Device()
    options = Options.of_quality("draft", element_size=asked.element_size, replicates=asked.replicates)
    steps = []
    print(HEADER)
    for path in asked.scenes:
        steps.append(measure(path, device, options, asked.sample, asked.paths, asked.cache))
        print(line(steps[-1]), flush=True)
    table = [HEADER, *map(line, steps), "", *stage_lines(steps), "", *summary(steps)]
    print("\n".join(table[len(steps) + 1 :]))
    if asked.out:
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / "growth.txt").write_text("\n".join(table) + "\n", encoding="utf-8")
        (asked.out / "growth.svg").write_text(plot(steps), encoding="utf-8")
        kept = json.dumps([asdict(step) for step in steps], indent=2)
        (asked.out / "growth.json").write_text(kept + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scenes", type=Path, nargs="+", help="scene folders, the smallest first")
    parser.add_argument("--element-size", type=float, default=0.35, help="edge of row elements [m], in all scenes")
    parser.add_argument("--replicates", type=int, default=8, help="that share the samples of a draft")
    parser.add_argument("--sample", type=int, default=150, help="readings that are compared with unbiased paths")
    parser.add_argument("--paths", type=int, default=8192, help="of the referee, from each of them")
    parser.add_argument("--cache", type=Path, default=Path("out/growth"), help="folder that keeps the referee's light")
    parser.add_argument("--out", type=Path, help="folder for table, plot and figures")
    return parser.parse_args()


def _show(state: RefereeState) -> None:
    sys.stderr.write(f"\rreferee: {state.paths} of {state.wanted} paths, {state.cpu_seconds:.0f} CPU s ")


if __name__ == "__main__":
    main()
