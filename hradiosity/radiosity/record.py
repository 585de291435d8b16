"""The account of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

from hradiosity.solvers.result import Convergence
from hradiosity.transport.exchange import Defects


@dataclass
class Record:
    """What happened, for ``run.json``.

    seconds : wall seconds of each stage
    rays : traced so far
    hemicubes, hemicube_seconds : drawn in the replicates of the classic mode so far, and the wall seconds it took
    cpu_seconds : of the run, kernels' building and checks left out
    stage : what is going on, or went on last
    defects, convergence : one a replicate
    """

    seconds: dict[str, float] = field(default_factory=dict)
    rays: int = 0
    hemicubes: int = 0
    hemicube_seconds: float = 0.0
    cpu_seconds: float = 0.0
    stage: str = ""
    defects: list[Defects] = field(default_factory=list)
    convergence: list[Convergence] = field(default_factory=list)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the wall seconds of a block to a stage."""
        start = time.perf_counter()
        self.stage = stage
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start

    def told(self) -> dict[str, Any]:
        """As ``run.json`` has it."""
        return {
            "stage_seconds": dict(self.seconds),
            "solve_cpu_s": self.cpu_seconds,
            "rays": self.rays,
            "hemicubes": {"drawn": self.hemicubes, "seconds": self.hemicube_seconds},
            "defects_before_closure": [asdict(found) for found in self.defects],
            "solver": [asdict(found) for found in self.convergence],
        }
