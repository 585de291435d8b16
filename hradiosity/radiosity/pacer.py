"""Keeps the time of a run, and says how it goes on: the one place where the clock has a say in what is computed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.radiosity.budget import (
    MOST_REPLICATES,
    WORTH_A_ROUND,
    Accuracies,
    Pace,
    Round,
    growth_to_fill,
    next_round,
    replicates_needed,
    scaled,
)

TOLERANCE_SHARE = 0.1
"""Of a wanted accuracy, what the solver's iteration may leave."""
AUDIT_SHARE = 0.2
"""Of the time, what the audit after the run takes."""
TIMED_REPLICATES = 2
"""After these a run with a time limit is scaled to fill it: the first one knows less, since kernels start in it."""
FORESEEING_REPLICATES = 4
"""Before these, nobody knows how many an accuracy will take."""
FILLED = 0.95
"""Share of the time left that a round is made to fill."""


@dataclass
class Pacer:
    """When a run stops, and when it starts a larger round.

    asked : as the user asked
    size : replicates of what size go on
    rounds : those that were given up for larger ones: replicates, seconds, largest error, rays of all until then
    """

    asked: Options
    size: Round
    rounds: list[dict[str, float]] = field(default_factory=list)
    _round_start: float = 0.0
    _ready: float = 0.0
    _ends: list[float] = field(default_factory=list)
    _reading_seconds: float = 0.0
    _readings_before: float = 0.0

    @classmethod
    def of(cls, options: Options) -> Pacer:
        """At the start of a run; a wanted accuracy lets the solver go on for longer."""
        if options.accuracy is None:
            return cls(options, Round(options))
        tolerance = min(options.tolerance, TOLERANCE_SHARE * options.accuracy)
        return cls(options, Round(replace(options, tolerance=tolerance)))

    @property
    def limit(self) -> float | None:
        """Seconds that the replicates have, without those of the audit."""
        if self.asked.time is None:
            return None
        return self.asked.time * (1.0 - AUDIT_SHARE * self.asked.audit)

    def prepared(self, elapsed: float) -> None:
        """The round is ready for its first replicate."""
        self._ready = elapsed

    def replicated(self, elapsed: float, reading_seconds: float) -> None:
        """A replicate is done; `reading_seconds` are the readings' of all replicates of the run."""
        self._ends.append(elapsed)
        if len(self._ends) > 1:
            self._reading_seconds = reading_seconds - self._readings_before
        self._readings_before = reading_seconds

    def first_round(self, expected: float | None) -> Round | None:
        """A smaller first round where even that would take longer than there is time, by what the plan expects."""
        if self.limit is None or expected is None or expected <= self.limit:
            return None
        return Round(scaled(self.size.options, FILLED * self.limit / expected))

    def wanted(self, found: Accuracies | None, done: int, elapsed: float) -> int:
        """Replicates of this size, as far as is known by now.

        Parameters
        ----------
        found : Accuracies, optional
            None before two replicates.
        """
        least = self.asked.replicates
        if done >= MOST_REPLICATES or (done >= 2 and self._out_of_time(elapsed)):
            return done
        if done < least:
            return least
        if self.asked.accuracy is None:
            return done if self.limit is None else done + 1
        if found is None or bool((found.total <= self.asked.accuracy).all()):
            return done
        return max(done + 1, replicates_needed(found, self.asked.accuracy, done) or 0)

    def larger(self, found: Accuracies | None, done: int, samples: NDArray[np.int64], elapsed: float) -> Round | None:
        """The next round, where a larger one is better than more replicates; call it after each replicate.

        Parameters
        ----------
        samples : (n,) int64
            Of each reading in this round.
        """
        if found is None or (self.asked.accuracy is None and self.limit is None):
            return None
        if self.asked.accuracy is None:
            return self._filling(elapsed) if done == TIMED_REPLICATES else None
        if done < self.asked.replicates or bool((found.total <= self.asked.accuracy).all()):
            return None
        following = next_round(found, self.asked.accuracy, self.size, done)
        if following is None or self.limit is None:
            return following
        if elapsed + self._expected(following, samples) <= self.limit:
            return following
        return self._filling(elapsed)

    def begin(self, following: Round, found: Accuracies | None, done: int, elapsed: float, rays: int) -> None:
        """Give the replicates so far up for a larger round."""
        error = float("inf") if found is None else float(found.total.max(initial=0.0))
        seconds = elapsed - self._round_start
        self.rounds.append({"replicates": done, "seconds": seconds, "error": error, "rays": rays})
        self.size = following
        self._round_start = elapsed
        self._ends = []

    def remaining(
        self, found: Accuracies | None, done: int, samples: NDArray[np.int64], elapsed: float
    ) -> float | None:
        """Expected seconds to the end; None while nothing is known."""
        if not self._ends:
            return None
        each, least = self._each(), self.asked.replicates
        if self.asked.accuracy is None or found is None:
            left = (self.wanted(found, done, elapsed) - done) * each
        elif done < FORESEEING_REPLICATES:
            return None
        else:
            expected = found.foreseen(done, max(done, least))
            left = (self.wanted(expected, max(done, least), elapsed) - done) * each
            missing = next_round(expected, self.asked.accuracy, self.size, max(done, least))
            if missing is not None and bool((expected.total > self.asked.accuracy).any()):
                left = max(least - done, 0) * each + self._expected(missing, samples)
        if self.limit is None:
            return left
        until = max(0.0, self.limit - elapsed)
        return until if self.asked.accuracy is None else min(left, until)

    def _filling(self, elapsed: float) -> Round | None:
        """The same scaled to fill the time that is left; None when that is not worth a round."""
        if self.limit is None:
            return None
        growth = growth_to_fill(self._pace(), self.asked.replicates, FILLED * (self.limit - elapsed))
        if growth < WORTH_A_ROUND:
            return None
        return replace(self.size, options=scaled(self.size.options, growth))

    def _expected(self, following: Round, samples: NDArray[np.int64]) -> float:
        """Wall seconds of a round."""
        before, after = self.size, following
        focus = after.of_readings(len(samples))[0] / before.of_readings(len(samples))[0]
        total = before.price(samples)
        elements = after.options.elements / before.options.elements
        if before.options.element_size is not None and after.options.element_size is not None:
            elements = (before.options.element_size / after.options.element_size) ** 2
        return self._pace().seconds(
            self.asked.replicates,
            elements=elements,
            rays=after.options.rays_per_element / before.options.rays_per_element,
            samples=after.price(focus * samples) / total if total > 0.0 else 1.0,
        )

    def _each(self) -> float:
        """Wall seconds of a replicate: of the later ones if there are any."""
        if len(self._ends) > 1:
            recent = self._ends[-4:]
            return (recent[-1] - recent[0]) / (len(recent) - 1)
        return self._ends[0] - self._ready

    def _pace(self) -> Pace:
        each = self._each()
        readings = min(self._reading_seconds, each)
        return Pace(start=self._ready - self._round_start, rows=each - readings, readings=readings)

    def _out_of_time(self, elapsed: float) -> bool:
        """Whether one more replicate would end more than half of itself after the limit."""
        if self.limit is None or not self._ends:
            return False
        return elapsed + 0.5 * self._each() > self.limit
