"""How long readings take, from what they have taken."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

MOST_SEEN = 64
"""Goes that are remembered: a machine may be busier now than it was."""


@dataclass
class ReadingPace:
    """Wall seconds of one go of a replicate's readings: so many for each path, and some however few there are.

    seen : price of each go in paths, and the seconds that it took
    """

    seen: list[tuple[float, float]] = field(default_factory=list)

    def learn(self, price: float, seconds: float) -> None:
        """A go of some price has taken so long."""
        if price > 0.0 and seconds > 0.0:
            self.seen = [*self.seen[1 - MOST_SEEN :], (price, seconds)]

    def seconds(self, price: float) -> float:
        """Expected for a go of that price; 0 while nothing is known."""
        start, each = self._line()
        return start + each * price if price > 0.0 else 0.0

    def _line(self) -> tuple[float, float]:
        """Seconds of a go without paths, and of each path: the line of the smallest squares of relative errors."""
        if not self.seen:
            return 0.0, 0.0
        price, seconds = np.array(self.seen).T
        one, path = 1.0 / seconds, price / seconds
        through_origin = 0.0, float(path.sum() / (path**2).sum())
        if np.ptp(price) == 0.0:
            return through_origin
        (start, each), *_ = np.linalg.lstsq(np.column_stack([one, path]), np.ones(len(price)), rcond=None)
        return (float(start), float(each)) if start > 0.0 < each else through_origin
