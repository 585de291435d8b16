"""What coverage found, in tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from hradiosity.suites.coverage.figures import LEVELS, Figures, covered, figures_of, over_scenes
from hradiosity.suites.coverage.measure import SceneNumbers

HEADER = (
    f"{'scene':>12} {'count':>7} "
    + " ".join(f"{100 * level:>5.0f} %" for level in LEVELS)
    + f" {'±':>5} {'rms':>8} {'bias':>8} {'common':>8} {'width/rms':>9} {'truth':>6} {'CPU s':>6}"
)
WORST_HEADER = (
    f"{'reading':>32} {'covered':>7} {'lx':>9} {'mean error':>10} {'spread':>8} {'width':>8} {'truth':>8}  place"
)


def kinds_of(found: Sequence[SceneNumbers]) -> list[str]:
    """Names of all kinds of numbers, in the order in which the readings have them."""
    return list(dict.fromkeys(name for scene in found for name in scene.kinds))


def table(found: Sequence[SceneNumbers]) -> str:
    """Coverage, errors and widths of each kind of number in each scene, errors and truth in % of the value."""
    lines = [
        "errors in %; ±: of the coverage before it, by the spread of the seeds; common: error that all seeds share;",
        "width/rms: median half width over rms error; truth: half width of the truth's own interval over it, median",
    ]
    for kind in kinds_of(found):
        rows = {scene.wanted.name: figures_of(scene.kinds[kind]) for scene in found if kind in scene.kinds}
        kept = {name: row for name, row in rows.items() if row is not None}
        if not kept:
            continue
        cpu = {scene.wanted.name: scene.cpu_seconds for scene in found}
        lines += ["", kind, HEADER, *(_row(name, row, cpu[name]) for name, row in kept.items())]
        lines.append(_row("all", over_scenes(list(kept.values())), float(np.mean(list(cpu.values())))))
    return "\n".join(lines)


def worst_table(scene: SceneNumbers, count: int) -> str:
    """The readings whose illuminance is held least often, with what seeds have in common and how they differ."""
    numbers = scene.kinds["illuminance"]
    held = covered(numbers, LEVELS[-1]).mean(axis=0)
    error = np.array([e.value - numbers.truth for e in numbers.estimates]) / numbers.scale
    width = np.median([e.half_width for e in numbers.estimates], axis=0) / numbers.scale
    names = [f"{sensor.name} {i}" for sensor in scene.scene.sensors for i in range(len(sensor.position))]
    places = np.concatenate([sensor.position for sensor in scene.scene.sensors])
    lines = [f"{scene.wanted.name}: worst readings", WORST_HEADER]
    for i in np.lexsort((-np.abs(error).mean(axis=0), held))[:count]:
        place = ", ".join(f"{c:.3g}" for c in places[numbers.reading[i]])
        lines.append(
            f"{names[numbers.reading[i]]:>32} {100 * held[i]:>5.0f} % {numbers.truth[i]:>9.3g} "
            f"{100 * error[:, i].mean():>8.2f} % {100 * error[:, i].std(ddof=1):>6.2f} % {100 * width[i]:>6.2f} % "
            f"{100 * (numbers.truth_error / numbers.scale)[i]:>6.2f} %  {place}"
        )
    return "\n".join(lines)


def as_json(found: Sequence[SceneNumbers]) -> dict[str, Any]:
    """The figures of `table`, by kind and scene."""
    return {
        "levels": list(LEVELS),
        "scenes": {
            scene.wanted.name: {
                "about": scene.wanted.about,
                "replicates": scene.replicates,
                "cpu_seconds": scene.cpu_seconds,
                "numbers": {name: _plain(figures_of(numbers)) for name, numbers in scene.kinds.items()},
            }
            for scene in found
        },
    }


def _plain(figures: Figures | None) -> dict[str, Any] | None:
    return None if figures is None else asdict(figures)


def _row(name: str, row: Figures, cpu: float) -> str:
    shares = " ".join(f"{100 * share:>5.1f} %" for share in row.covered)
    errors = " ".join(f"{100 * value:>8.3f}" for value in (row.rms, row.bias, row.common))
    widths = f"{row.ratio:>9.1f} {row.truth_ratio:>6.2f} {cpu:>6.1f}"
    return f"{name:>12} {row.count:>7} {shares} {100 * row.uncertain:>5.1f} {errors} {widths}"
