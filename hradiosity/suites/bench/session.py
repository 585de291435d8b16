"""What every section of a run is given: the device, how much to do, and where to say what was left out."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec

from hradiosity.device import Device


@dataclass(frozen=True)
class Session:
    """One run.

    quick : few repeats and small cases, so that all sections take less than two minutes on two cores
    notes : what was skipped, and why; grows
    """

    device: Device
    quick: bool = False
    notes: list[str] = field(default_factory=list)

    @property
    def turns(self) -> int:
        """Repeats of what is short."""
        return 3 if self.quick else 7

    def has_peer(self, module: str) -> bool:
        """Whether another program can be imported; if not, a note names the extra that brings it."""
        if find_spec(module) is not None:
            return True
        note = f"{module} is not installed and was skipped: pip install 'hradiosity[bench]' brings it"
        if note not in self.notes:
            self.notes.append(note)
        return False


def cpu_seconds(works: Sequence[Callable[[], object]], turns: int) -> list[list[float]]:
    """CPU seconds of the process, all threads added, of each of `works` in each turn.

    They take turns, after one turn that is not counted, so that what else the machine does meets all alike.
    """
    seconds: list[list[float]] = [[] for _ in works]
    for turn in range(turns + 1):
        for spent, work in zip(seconds, works):
            start = time.process_time()
            work()
            if turn > 0:
                spent.append(time.process_time() - start)
    return seconds


def cpu_and_wall(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds that one call took: of the process, all threads added, and of the clock."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall
