"""The weight of the mesh term: chosen on one half of the scenes, judged by the other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import MESH, Estimate
from hradiosity.readings.companions import COMPANIONS
from hradiosity.suites.coverage.figures import Figures, figures_of, over_scenes
from hradiosity.suites.coverage.measure import SceneNumbers

WEIGHTS = (0.0, 0.1, 0.2, 0.33, 0.5, 0.7, 1.0)
KINDS = ("illuminance", "irradiance", "mean_illuminance", "uniformity", "chromaticity")


def width_with(weight: float, estimate: Estimate, level: float) -> NDArray[np.float64]:
    """Half width if the change by a coarser mesh counted with another weight."""
    others = {**estimate.others, MESH: np.asarray(estimate.others[MESH]) * (weight / COMPANIONS[MESH])}
    return replace(estimate, others=others).half_width_at(level)


def weight_table(found: Sequence[SceneNumbers]) -> str:
    """Coverage of 95 % and median half width over rms error by weight: each scene, both halves.

    Raises
    ------
    ValueError
        When the intervals have no mesh term.
    """
    if not all(MESH in numbers.estimates[0].others for scene in found for numbers in scene.kinds.values()):
        raise ValueError("these intervals have no part for the mesh")
    lines = []
    for kind in KINDS:
        lines += [f"{kind}: covered by 95 % intervals, median half width over rms error", _header()]
        rows = {scene.wanted.name: _by_weight(scene, kind) for scene in found}
        lines += [_row(name, row) for name, row in rows.items() if row]
        for title, fits in (("half that fits", True), ("half that tests", False)):
            chosen = [rows[s.wanted.name] for s in found if s.wanted.fits is fits and rows[s.wanted.name]]
            if chosen:
                lines.append(_row(title, [over_scenes(column) for column in zip(*chosen)]))
        lines.append("")
    return "\n".join(lines)


def _by_weight(scene: SceneNumbers, kind: str) -> list[Figures]:
    rows = [figures_of(scene.kinds[kind], partial(width_with, weight)) for weight in WEIGHTS]
    return [row for row in rows if row is not None]


def _header() -> str:
    return f"{'weight':>16}" + "".join(f"{weight:>14g}" for weight in WEIGHTS)


def _row(name: str, row: Iterable[Figures]) -> str:
    return f"{name:>16}" + "".join(f"{100 * part.covered[-1]:>7.1f} %{part.ratio:>5.1f}" for part in row)
