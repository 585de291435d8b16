"""The account of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from hradiosity.solvers.result import Convergence
from hradiosity.transport.exchange import Defects


@dataclass
class Record:
    """What happened, for ``run.json``.

    seconds : wall seconds of each stage
    rays : traced so far
    hemicubes, hemicube_seconds : drawn in the replicates of the classic mode so far, and the wall seconds it took
    stage : what is going on, or went on last
    defects, convergence : one a replicate
    """

    seconds: dict[str, float] = field(default_factory=dict)
    rays: int = 0
    hemicubes: int = 0
    hemicube_seconds: float = 0.0
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
