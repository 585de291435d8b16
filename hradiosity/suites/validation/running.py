"""Runs cases and judges them."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.options import Quality
from hradiosity.radiosity import make_solver
from hradiosity.solution import Solution
from hradiosity.suites.validation.values import Case, CaseResult, Job, Measured, Row


@dataclass
class SceneBench:
    """Solves each scene once, from a folder as a user would have it.

    quality : one of the program's, in place of each case's own settings
    """

    device: Device
    quality: Quality | None = None
    _solved: dict[Job, Solution] = field(default_factory=dict)

    def solve(self, job: Job) -> Solution:
        """Write the scene, load it, solve it; the same job is solved once."""
        if job not in self._solved:
            with tempfile.TemporaryDirectory(prefix="hradiosity-validate-") as folder:
                (Path(folder) / "scene.toml").write_text(job.text, encoding="utf-8")
                for name, content in job.files:
                    (Path(folder) / name).write_text(content, encoding="utf-8")
                scene = load_scene(Path(folder))
            solver = make_solver(scene, job.options(self.quality), self.device)
            for _ in solver.states():
                pass
            # Without its reader, which keeps the light of all replicates on the device.
            self._solved[job] = replace(solver.solution(), reader=None, reflector=None)
        return self._solved[job]


def run(cases: Sequence[Case], bench: SceneBench) -> Iterator[CaseResult]:
    """Measure each case in turn."""
    for case in cases:
        start = time.perf_counter()
        rows = judge(case, case.measure(bench))
        settings = tuple(dict.fromkeys(job.settings(bench.quality) for job in case.jobs))
        yield CaseResult(case, rows, time.perf_counter() - start, settings)


def judge(case: Case, found: Sequence[Measured]) -> tuple[Row, ...]:
    """Deviations from the references.

    Raises
    ------
    ValueError
        When there are more or fewer numbers than points.
    """
    if len(found) != len(case.points):
        raise ValueError(f"{case.name}: {len(found)} numbers for {len(case.points)} points")
    mean = sum(abs(point.reference) for point in case.points) / len(case.points)
    rows = []
    for point, ours in zip(case.points, found):
        base = abs(point.reference) or mean or 1.0
        rows.append(Row(point.name, ours.value, point.reference, base, ours.half_width, point.tolerance))
    return tuple(rows)
