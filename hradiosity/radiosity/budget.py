"""How a run goes on when an accuracy or a time is asked for: more replicates, or a new round with larger ones.

Pure functions of what the replicates so far say; nothing here looks at a clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import SAMPLING, student_quantile
from hradiosity.options import Options
from hradiosity.solution import Readings

MOST_REPLICATES: Final = 256
ROUND_REPLICATES: Final = 24
"""More replicates than these in one round are dearer than a round with larger ones."""
HOPELESS_REPLICATES: Final = 64
"""The same once a round has gone on beyond its first replicates: what it has is then worth more."""
FIXED_SHARE: Final = 0.7
"""Of the wanted half width, what parts that replicates do not narrow may have."""
FINER_SHARE: Final = 0.5
"""What they are brought down to, when the elements are made smaller."""
MESH_ORDER: Final = 1.5
"""Power of the edge of elements with which the mesh part falls, about."""
MARGIN: Final = 2.0
"""More samples in a new round than the spread of the last one calls for. The spread is itself an estimate from few
replicates: among hundreds of equally sure readings the worst then shows about 1.7 times the spread of the rest."""
MOST_GROWTH: Final = 64.0
"""Of samples or elements, from one round to the next."""
WORTH_A_ROUND: Final = 2.0
"""Growth of all samples from which on a new round pays, since it throws the last one away."""


@dataclass(frozen=True)
class Accuracies:
    """Half widths of all readings over what accuracy refers to (see `Readings.accuracy`), in two parts.

    sampling : (n,) float64, that more replicates narrow
    fixed : (n,) float64, all others in quadrature
    mesh : (n,) float64, that of them which smaller elements narrow
    """

    sampling: NDArray[np.float64]
    fixed: NDArray[np.float64]
    mesh: NDArray[np.float64]

    @classmethod
    def of(cls, readings: dict[str, Readings]) -> Accuracies:
        """Of all readings, in the order of the sensors."""
        parts = [_relative_parts(found) for found in readings.values()]
        joined = [np.concatenate([np.zeros(0), *(part[k] for part in parts)]) for k in range(3)]
        return cls(*joined)

    def foreseen(self, done: int, replicates: int) -> Accuracies:
        """As expected after `replicates` instead of the `done` ≥ 2 that they are from."""
        quantiles = student_quantile(0.95, replicates - 1) / student_quantile(0.95, done - 1)
        return replace(self, sampling=quantiles * (done / replicates) ** 0.5 * self.sampling)

    @property
    def total(self) -> NDArray[np.float64]:
        """(n,) both in quadrature."""
        both: NDArray[np.float64] = np.hypot(self.sampling, self.fixed)
        return both


def _relative_parts(found: Readings) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    estimate = found.numbers["illuminance"]
    base = found.accuracy_base
    share = np.divide(estimate.factor, base, out=np.zeros_like(base), where=base > 0.0)
    parts = estimate.parts
    none = np.zeros_like(base)
    fixed = np.sqrt(np.sum([part**2 for name, part in parts.items() if name != SAMPLING] or [none], axis=0))
    return share * parts[SAMPLING], share * fixed, share * parts.get("mesh", none)


@dataclass(frozen=True)
class Round:
    """How large the replicates of a round are.

    options : of the run, with this round's elements and samples
    focus : (n,) float64, samples of each reading over those that the round's pilot gives it; no entries for 1
    """

    options: Options
    focus: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))


def replicates_needed(found: Accuracies, accuracy: float, done: int) -> int | None:
    """Fewest replicates, of the same size, with which all readings are accurate; None when none would do.

    Parameters
    ----------
    found : Accuracies
        After `done` ≥ 2 replicates.
    """
    room = accuracy**2 - found.fixed**2
    if (room <= 0.0).any():
        return None
    worst = float((found.sampling / np.sqrt(room)).max(initial=0.0)) / student_quantile(0.95, done - 1)
    for count in range(done, MOST_REPLICATES + 1):
        if student_quantile(0.95, count - 1) * worst * (done / count) ** 0.5 <= 1.0:
            return count
    return None


def next_round(found: Accuracies, accuracy: float, last: Round, done: int) -> Round | None:
    """A round whose replicates are expected to be accurate enough; None when more of the same are better.

    Readings that are not sure enough get more samples, in proportion to the variance that is too much.
    Elements follow as the square root of the median reading's samples, and further where the mesh part asks for it.

    Parameters
    ----------
    found : Accuracies
        After `done` replicates of the size `last`.
    """
    needed = replicates_needed(found, accuracy, done)
    most = ROUND_REPLICATES if done <= last.options.replicates else HOPELESS_REPLICATES
    if needed is not None and needed <= most and (found.fixed <= FIXED_SHARE * accuracy).all():
        return None
    fixed = np.minimum(found.fixed, FINER_SHARE * accuracy)
    variance = done / last.options.replicates * found.sampling**2
    need = np.clip(MARGIN * variance / (accuracy**2 - fixed**2), 1.0, MOST_GROWTH)
    finer = float((found.mesh / (FINER_SHARE * accuracy)).max(initial=0.0)) ** (2.0 / MESH_ORDER)
    elements = min(max(float(np.median(need)) ** 0.5, finer, 1.0), MOST_GROWTH)
    rays = min(max(float(np.quantile(need, 0.9)) / elements, 1.0), MOST_GROWTH)
    focus = last.focus if len(last.focus) else np.ones(len(need))
    return Round(grown(last.options, elements=elements, rays=rays), focus * need)


def grown(options: Options, *, elements: float = 1.0, rays: float = 1.0, samples: float = 1.0) -> Options:
    """The same with more elements, with more rays and points on each of them, and more samples of each reading."""
    edge = None if options.element_size is None else options.element_size / elements**0.5
    least = options.replicates
    return replace(
        options,
        elements=max(1, round(options.elements * elements)),
        element_size=edge,
        rays_per_element=max(16, round(options.rays_per_element * rays)),
        light_points=max(1, round(options.light_points * rays)),
        light_samples=max(least, round(options.light_samples * samples)),
        gather_samples=max(least, round(options.gather_samples * samples)),
    )


def scaled(options: Options, growth: float) -> Options:
    """All samples `growth` times as many; elements as their square root, and as many rays a row as before.

    That is how the qualities are made: noise and mesh fall alike.
    """
    return grown(options, elements=growth**0.5, samples=growth)


@dataclass(frozen=True)
class Pace:
    """Wall seconds that a round of some size took.

    start : before its first replicate
    rows : of each replicate, up to the light on the elements
    readings : of each replicate, for the readings
    """

    start: float
    rows: float
    readings: float

    def seconds(self, replicates: int, *, elements: float = 1.0, rays: float = 1.0, samples: float = 1.0) -> float:
        """Expected for a round that is larger by some factors."""
        return elements * self.start + replicates * (elements * rays * self.rows + samples * self.readings)


def growth_to_fill(pace: Pace, replicates: int, seconds: float) -> float:
    """Growth of all samples, see `scaled`, with which so many replicates fill some seconds; at most `MOST_GROWTH`."""
    low, high = 1e-3, MOST_GROWTH
    for _ in range(60):
        middle = (low * high) ** 0.5
        if pace.seconds(replicates, elements=middle**0.5, samples=middle) <= seconds:
            low = middle
        else:
            high = middle
    return low
