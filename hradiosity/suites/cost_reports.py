"""The reports of ``hradiosity cost`` that README shows: ``python -m hradiosity.suites.cost_reports``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.suites.cost.bench import SceneBench
from hradiosity.suites.cost.files import markdown_lines, write_cost
from hradiosity.suites.cost.reference import SEED
from hradiosity.suites.cost.reporting import report_of
from hradiosity.suites.cost.running import CostRun
from hradiosity.suites.cost.settings import bands_like
from hradiosity.suites.cost.values import Report
from hradiosity.suites.referee_cache import load_samples, save_samples, scene_digest

SCENES: Final = ("office", "cornell_box", "two_rooms")


def measure(path: Path, device: Device, budget: float, kept: Path | None = None) -> Report:
    """The report of one scene.

    Parameters
    ----------
    path : Path
        Of the scene.
    device : Device
    budget : float
        Wall seconds.
    kept : Path, optional
        ``.npz`` file whose paths of the referee count as well, and that keeps all of them.
    """
    scene = load_scene(path)
    digest, bands = scene_digest(scene), scene.bands
    bench = SceneBench(scene, device, load_samples(kept, digest, SEED, 1) if kept else None)
    run = CostRun(bench, budget, lambda count: load_scene(path, bands=bands_like(bands, count)))
    for event in run.events():
        print(f"{run.budget.spent:6.1f} s  {event.kind} {event.values}", flush=True)
    if kept:
        save_samples(kept, digest, SEED, bench.reference.samples())
    return report_of(run, bench, complete=True)


def main() -> None:
    """Write a folder of report for each scene."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--scenes", type=Path, default=Path("scenes"), help="folder with the scenes")
    parser.add_argument("--only", choices=SCENES, nargs="+", default=SCENES, help="not all of them")
    parser.add_argument("--budget", type=float, default=180.0, help="wall seconds of each scene")
    parser.add_argument("--referee", type=Path, help="folder that keeps the referee's paths for the next time")
    parser.add_argument("--out", type=Path, default=Path("examples/reports"), help="folder for the reports")
    options = parser.parse_args()
    device = Device()
    for name in options.only:
        kept = None
        if options.referee:
            options.referee.mkdir(parents=True, exist_ok=True)
            kept = options.referee / f"{name}.npz"
        report = measure(options.scenes / name, device, options.budget, kept)
        folder = options.out / name
        folder.mkdir(parents=True, exist_ok=True)
        write_cost(folder, report)
        print("\n".join(markdown_lines(report)))


if __name__ == "__main__":
    main()
