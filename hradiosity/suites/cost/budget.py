"""Wall seconds that may be spent."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

MARGIN: Final = 1.25
"""What is begun is expected to end in time even if it takes so much longer than predicted."""


@dataclass
class Budget:
    """A total, and the clock that it is measured with.

    seconds : that may be spent
    clock : seconds from any start
    """

    seconds: float
    clock: Callable[[], float] = time.perf_counter
    _start: float = field(init=False)

    def __post_init__(self) -> None:
        self._start = self.clock()

    @property
    def spent(self) -> float:
        """Seconds so far."""
        return self.clock() - self._start

    def left(self, share: float = 1.0) -> float:
        """Seconds until a share of the budget is spent; below 0 when it was."""
        return share * self.seconds - self.spent

    def holds(self, predicted: float, share: float = 1.0) -> bool:
        """Whether something may begin that must end before a share of the budget is spent."""
        return MARGIN * predicted <= self.left(share)
