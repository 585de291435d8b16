"""Keeps the time of a run, and says how it goes on: the one place where the clock has a say in what is computed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.radiosity.accuracies import Accuracies
from hradiosity.radiosity.budget import (
    FINER_POWER,
    FIRST_STEPS,
    MOST_REPLICATES,
    WORTH_A_ROUND,
    Pace,
    Step,
    finer_elements,
    growth_to_fill,
    next_step,
    replicates_needed,
    scaled,
    with_noise_of_elements,
)
from hradiosity.radiosity.reading_pace import ReadingPace
from hradiosity.radiosity.remedy import Held, goes_needed, in_the_way

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
LEAST_SHARE = 0.05
"""Of a step, for which there is time: less is not begun."""
ROUNDS_SHARE = 0.8
"""Of the time to an accuracy, what a round on other elements takes of it; the rest are samples that still lack then."""


@dataclass
class Pacer:
    """When a run stops, and how it goes on until then.

    asked : as the user asked
    size : elements, rays and samples of the replicates that go on
    steps : whether points can be read again; if not, only more replicates make a run more accurate
    rounds : those whose replicates were given up for larger ones: replicates, seconds, largest error, readings that
        stayed as they were, rays until then
    deeper : steps that read points again, by the same light on the elements
    """

    asked: Options
    size: Options
    steps: bool = True
    rounds: list[dict[str, float]] = field(default_factory=list)
    deeper: int = 0
    _round_start: float = 0.0
    _ready: float = 0.0
    _ends: list[float] = field(default_factory=list)
    _readings_before: float = 0.0
    _reading_seconds: float = 0.0
    _reading_pace: ReadingPace = field(default_factory=ReadingPace)
    _foreseen_end: float = 0.0
    _step_seconds: float = 0.0

    @classmethod
    def of(cls, options: Options, *, steps: bool = True) -> Pacer:
        """At the start of a run; a wanted accuracy lets the solver go on for longer."""
        if options.accuracy is None:
            return cls(options, options, steps)
        tolerance = min(options.tolerance, TOLERANCE_SHARE * options.accuracy)
        return cls(options, replace(options, tolerance=tolerance), steps)

    @property
    def limit(self) -> float | None:
        """Seconds that the replicates have, without those of the audit."""
        if self.asked.time is None:
            return None
        return self.asked.time * (1.0 - AUDIT_SHARE * self.asked.audit)

    def prepared(self, elapsed: float) -> None:
        """The round is ready for its first replicate."""
        self._ready = elapsed

    def replicated(self, elapsed: float, reading_seconds: float, price: float) -> None:
        """A replicate is done.

        Parameters
        ----------
        reading_seconds : float
            The readings' of all replicates of the run.
        price : float
            Of this replicate's readings, see `Held.price`.
        """
        first = not self._ends
        self._ends.append(elapsed)
        self._read(reading_seconds, price, known=not first)

    def deepened(self, reading_seconds: float, price: float) -> None:
        """Points of a replicate were read again; parameters as of `replicated`."""
        self._read(reading_seconds, price, known=True)

    def _read(self, reading_seconds: float, price: float, *, known: bool) -> None:
        """Learn what readings take; not from the first replicate, in which kernels start and samples are planned."""
        spent = reading_seconds - self._readings_before
        self._readings_before = reading_seconds
        if known:
            self._reading_seconds = spent
            self._reading_pace.learn(price, spent)

    def first_round(self, expected: float | None) -> Options | None:
        """A smaller first round where even that would take longer than there is time, by what the plan expects."""
        if self.limit is None or expected is None or expected <= self.limit:
            return None
        return scaled(self.size, FILLED * self.limit / expected)

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
        if self.steps or found is None or bool((found.total <= self.asked.accuracy).all()):
            return done
        needed = replicates_needed(found, self.asked.accuracy, done)
        if needed is None:
            return max(done, self._least_known)
        return max(done + 1, needed)

    @property
    def _least_known(self) -> int:
        """Replicates that tell what is in the way of an accuracy."""
        return max(self.asked.replicates, FORESEEING_REPLICATES)

    def finer(self, found: Accuracies | None, done: int, held: Held, elapsed: float) -> Options | None:
        """Replicates on smaller elements where points can't be read again and the mesh is in the way of an accuracy.

        None as well where there is no time for them.
        """
        if self.steps or found is None or self.asked.accuracy is None or done < self._least_known:
            return None
        following = finer_elements(found, self.asked.accuracy, self.size, held.elements)
        if following is None:
            return None
        options, growth = following
        late = self.limit is not None and elapsed + self._seconds_finer(growth) > self.limit
        return None if late else options

    def _seconds_finer(self, growth: float) -> float:
        """Expected wall seconds of replicates with so many times the elements."""
        return float(self.asked.replicates * growth**FINER_POWER * self._each())

    def filling(self, done: int, elapsed: float) -> Options | None:
        """Larger replicates that fill the time of a run without an accuracy, where they are worth it."""
        if self.limit is None or self.asked.accuracy is not None or done != TIMED_REPLICATES:
            return None
        growth = growth_to_fill(self._pace(), self.asked.replicates, FILLED * (self.limit - elapsed))
        return scaled(self.size, growth) if growth >= WORTH_A_ROUND else None

    def need_more_than_samples(self, found: Accuracies | None, done: int, held: Held) -> NDArray[np.bool_]:
        """(n,) readings for which something else than samples has to be done, when all replicates of a round are."""
        accuracy = self.asked.accuracy
        if not self.steps or found is None or accuracy is None or done < self.asked.replicates:
            return np.zeros(len(held.times), np.bool_)
        return in_the_way(with_noise_of_elements(found, held), accuracy, self.size, held)

    def next_step(self, found: Accuracies | None, done: int, held: Held, elapsed: float) -> Step | None:
        """What to do for readings that lack accuracy, when all replicates of a round are done; None for nothing.

        Where time is short, they get as many samples as there is time for.
        """
        accuracy = self.asked.accuracy
        if not self.steps or found is None or accuracy is None or done < self.asked.replicates:
            return None
        step = next_step(found, accuracy, self.size, held)
        if step is not None and self.limit is not None:
            left = FILLED * (self.limit - elapsed)
            if step.larger and self._expected(step, held) > left:
                step = next_step(found.without_fixed(), accuracy, self.size, held)
            expected = 0.0 if step is None else self._expected(step, held)
            share = left / expected if expected > 0.0 else 0.0
            if step is not None and share < 1.0:
                step = step.shortened(share) if share > LEAST_SHARE else None
        if step is not None:
            self._foreseen_end = elapsed + self._to_accuracy(found, accuracy, held)
            self._step_seconds = self._expected(step, held)
        return step

    def begin(self, following: Options, elapsed: float, given_up: dict[str, float]) -> None:
        """Start replicates of another size; what is given up for them is remembered."""
        self.rounds.append({"seconds": elapsed - self._round_start, **given_up})
        self.size = following
        self._round_start = elapsed
        self._ends = []

    def remaining(self, found: Accuracies | None, done: int, held: Held, elapsed: float) -> float | None:
        """Expected seconds to the end of a run that goes through the replicates of a round; None if nothing is known.

        Parameters
        ----------
        done : int
            Replicates of this round.
        """
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
            if self.steps:
                left += self._to_accuracy(expected, self.asked.accuracy, held)
            else:
                following = finer_elements(expected, self.asked.accuracy, self.size, held.elements)
                left += 0.0 if following is None else self._seconds_finer(following[1])
        return self._within_limit(left, elapsed)

    def remaining_of_steps(self, number: int, elapsed: float) -> float:
        """The same after `number` replicates of a step that reads points again."""
        of_step = (1.0 - number / self.asked.replicates) * self._step_seconds
        return self._within_limit(max(of_step, self._foreseen_end - elapsed), elapsed)

    def too_late(self, elapsed: float) -> bool:
        """Whether one more replicate of a step would end more than half of itself after the limit."""
        return self.limit is not None and elapsed + 0.5 * self._step_seconds / self.asked.replicates > self.limit

    def _within_limit(self, left: float, elapsed: float) -> float:
        if self.limit is None:
            return left
        until = max(0.0, self.limit - elapsed)
        return until if self.asked.accuracy is None else min(left, until)

    def _to_accuracy(self, found: Accuracies, accuracy: float, held: Held) -> float:
        """Expected seconds from readings that are that accurate to the end of the run.

        Before readings had a few steps, much of their mesh and exchange parts is noise: then the geometric mean of what
        it takes to mend them, and of what the samples alone take.
        """
        seconds = self._to_mend(found, accuracy, held)
        known = held.steps[found.total > accuracy] >= FIRST_STEPS
        if 2 * np.count_nonzero(known) >= len(known):
            return seconds
        return float((seconds * self._to_mend(found.without_fixed(), accuracy, held)) ** 0.5)

    def _to_mend(self, found: Accuracies, accuracy: float, held: Held) -> float:
        step = next_step(found, accuracy, self.size, held, ahead=True)
        if step is None:
            return 0.0
        if step.larger:
            return self._expected(step, held) / ROUNDS_SHARE
        further = np.where(found.total > accuracy, goes_needed(found, accuracy, held) - held.times, 0.0)
        whole = replace(step, times=np.where(step.anew, step.times, np.maximum(step.times, further)))
        return self._expected(whole, held)

    def _expected(self, step: Step, held: Held) -> float:
        """Wall seconds of a step."""
        readings = self.asked.replicates * self._reading_pace.seconds(step.price(held))
        if not step.larger:
            return readings
        before, after = self.size, step.options
        elements = after.elements / before.elements
        if before.element_size is not None and after.element_size is not None:
            elements = (before.element_size / after.element_size) ** 2
        rays = after.rays_per_element / before.rays_per_element
        return readings + replace(self._pace(), readings=0.0).seconds(
            self.asked.replicates, elements=elements, rays=rays
        )

    def _each(self) -> float:
        """Wall seconds of a replicate: of the later ones if there are any; 0 where a resumed run has seen none."""
        if len(self._ends) > 1:
            recent = self._ends[-4:]
            return (recent[-1] - recent[0]) / (len(recent) - 1)
        return self._ends[0] - self._ready if self._ends else 0.0

    def _pace(self) -> Pace:
        each = self._each()
        readings = min(self._reading_seconds, each)
        return Pace(start=self._ready - self._round_start, rows=each - readings, readings=readings)

    def _out_of_time(self, elapsed: float) -> bool:
        """Whether one more replicate would end more than half of itself after the limit."""
        if self.limit is None or not self._ends:
            return False
        return elapsed + 0.5 * self._each() > self.limit
