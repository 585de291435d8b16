"""How a run goes on when an accuracy or a time is asked for: more replicates, or a new round with larger ones.

Pure functions of what the replicates so far say; nothing here looks at a clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import EXCHANGE, MESH, SAMPLING, student_quantile
from hradiosity.options import Options
from hradiosity.solution import Readings

MOST_REPLICATES: Final = 256
ROUND_REPLICATES: Final = 24
"""More replicates than these in one round are dearer than a round with larger ones."""
HOPELESS_REPLICATES: Final = 64
"""The same once a round has gone on beyond its first replicates: what it has is then worth more."""
FIXED_SHARE: Final = 0.7
"""Of the wanted half width, what parts that replicates do not narrow may have."""
MESH_SHARE, EXCHANGE_SHARE, OTHER_SHARE = 0.45, 0.25, 0.4
"""What they are brought down to in a new round: by elements and lookups, by rays from each element, and, for the
iteration and combined columns, by the solver's tolerance."""
MESH_ORDER: Final = 1.5
"""Power of the edge of elements with which the mesh part falls, about."""
DEEP: Final = 3
"""Hit at which readings look the solution up whose mesh part is too large."""
DEEP_GAIN, DEEP_NOISE, DEEP_PRICE = 2.5, 6.0, 2.5
"""What that divides their mesh and exchange parts by, and multiplies their variance and the price of a path by: means
over office and Cornell box, for lookups at the first hit before, and the larger of both for the variance."""
ELEMENT_PATHS: Final = 200.0
"""Price of an element in all replicates, in paths: rays, closing and solution. Measured in the office."""
MOST_READINGS: Final = 0.9
"""Share of the readings whose exchange part a new round brings down to that; of the others it is mostly noise, and only
brought down to the accuracy."""
SURFACES_ROOM: Final = 0.25
"""Of the variance that a new round may have, what may come from the light on the elements."""
SAMPLES_ORDER: Final = 1.2
"""Power of the number of samples with which the variance of a reading falls, at least: stratified ones do better than
independent ones; 1.36 was measured in the office, from 512 to 8192."""
MARGIN: Final = 2.0
"""More samples in a new round than the spread of the last one calls for. The spread is itself an estimate from few
replicates: among hundreds of equally sure readings the worst then shows about 1.7 times the spread of the rest."""
LATER_MARGIN: Final = 2.0
"""The same once more in later rounds, in which few readings lack anything and the others would only be repeated."""
MOST_GROWTH: Final = 256.0
"""Of samples or elements, from one round to the next."""
LEAST_TOLERANCE: Final = 1e-6
"""Of the linear solver: single precision gets no further."""
WORTH_A_ROUND: Final = 2.0
"""Growth of all samples from which on a new round pays, since it throws the last one away."""


@dataclass(frozen=True)
class Accuracies:
    """Half widths of all readings over what accuracy refers to (see `Readings.accuracy`), part by part.

    sampling : (n,) float64, that more replicates narrow
    mesh : (n,) float64, that smaller elements narrow
    exchange : (n,) float64, that more rays from each element narrow
    other : (n,) float64, all others in quadrature
    surfaces : share of the variance between replicates that comes from the light on the elements, which samples of
        the readings leave as it is
    """

    sampling: NDArray[np.float64]
    mesh: NDArray[np.float64]
    exchange: NDArray[np.float64]
    other: NDArray[np.float64]
    surfaces: float = 0.0

    @classmethod
    def of(cls, readings: dict[str, Readings], surfaces: float = 0.0) -> Accuracies:
        """Of all readings, in the order of the sensors."""
        parts = [_relative_parts(found) for found in readings.values()]
        joined = [np.concatenate([np.zeros(0), *(part[k] for part in parts)]) for k in range(4)]
        sampling, mesh, exchange, other = joined
        return cls(sampling, mesh, exchange, other, surfaces)

    def foreseen(self, done: int, replicates: int) -> Accuracies:
        """As expected after `replicates` instead of the `done` ≥ 2 that they are from."""
        quantiles = student_quantile(0.95, replicates - 1) / student_quantile(0.95, done - 1)
        return replace(self, sampling=quantiles * (done / replicates) ** 0.5 * self.sampling)

    @property
    def fixed(self) -> NDArray[np.float64]:
        """(n,) all but sampling, in quadrature."""
        return np.asarray(np.sqrt(self.mesh**2 + self.exchange**2 + self.other**2))

    @property
    def total(self) -> NDArray[np.float64]:
        """(n,) all in quadrature."""
        return np.asarray(np.hypot(self.sampling, self.fixed))


def _relative_parts(found: Readings) -> tuple[NDArray[np.float64], ...]:
    estimate = found.numbers["illuminance"]
    base = found.accuracy_base
    share = np.divide(estimate.factor, base, out=np.zeros_like(base), where=base > 0.0)
    parts, none = estimate.parts, np.zeros_like(base)
    named = (SAMPLING, MESH, EXCHANGE)
    other = np.sqrt(np.sum([part**2 for name, part in parts.items() if name not in named] or [none], axis=0))
    return *(share * parts.get(name, none) for name in named), share * other


@dataclass(frozen=True)
class Round:
    """How large the replicates of a round are.

    options : of the run, with this round's elements and samples
    focus : (n,) float64, samples of each reading over those that the round's pilot gives it; no entries for 1
    lookup : (n,) int64, first hit at which paths of each reading may look the solution up; no entries for that of the
        options
    """

    options: Options
    focus: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    lookup: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def of_readings(self, n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Focus and lookup of n readings."""
        focus = self.focus if len(self.focus) else np.ones(n)
        return focus, self.lookup if len(self.lookup) else np.full(n, self.options.lookup)

    def price(self, samples: NDArray[np.floating] | NDArray[np.int64]) -> float:
        """Of the paths of the readings, `samples` (n,) of them, in paths that look the solution up at the first hit."""
        _, lookup = self.of_readings(len(samples))
        return float((samples * DEEP_PRICE ** ((lookup - 1.0) / (DEEP - 1.0))).sum())


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

    Readings that are not sure enough get more samples. A first round leaves room for all parts; later ones mend what
    is off. Where the mesh part is too large, either all elements become
    smaller or those readings look the solution up later, whatever is cheaper. Elements send more rays where the
    exchange part, or the share of the noise that comes from the elements, asks for it.

    Parameters
    ----------
    found : Accuracies
        After `done` replicates of the size `last`.
    """
    needed = replicates_needed(found, accuracy, done)
    most = ROUND_REPLICATES if done <= last.options.replicates else HOPELESS_REPLICATES
    if needed is not None and needed <= most and (found.fixed <= FIXED_SHARE * accuracy).all():
        return None
    focus, lookup = last.of_readings(len(found.sampling))
    again = len(last.focus) > 0
    shares = FIXED_SHARE if again else MESH_SHARE, EXCHANGE_SHARE, OTHER_SHARE
    targets = [share * accuracy for share in shares]
    fixed = [np.minimum(part, most) for part, most in zip((found.mesh, found.exchange, found.other), targets)]
    room = accuracy**2 - np.sum(np.square(fixed), axis=0)
    excess = MARGIN * done / last.options.replicates * found.sampling**2 / room
    elements, deep = _finer(found, targets[0], last, excess)
    wanted = excess * np.where(deep, DEEP_NOISE, 1.0)
    need = np.where(wanted > 1.0, (wanted * (LATER_MARGIN if again else 1.0)) ** (1.0 / SAMPLES_ORDER), 1.0)
    need = np.minimum(need, MOST_GROWTH)
    exchange = np.where(deep, found.exchange / DEEP_GAIN, found.exchange)
    noise = found.surfaces * float(np.median(excess)) / SURFACES_ROOM / elements
    usual = float(np.quantile(exchange, MOST_READINGS)) if len(exchange) else 0.0
    worst = float(exchange.max(initial=0.0)) / accuracy
    rays = min(max(usual / targets[1], worst, noise, 1.0), MOST_GROWTH)
    options = grown(last.options, elements=elements, rays=rays)
    looser = float(found.other.max(initial=0.0)) / targets[2]
    if looser > 1.0:
        options = replace(options, tolerance=max(options.tolerance / looser, LEAST_TOLERANCE))
    return Round(options, focus * need, np.where(deep, DEEP, lookup))


def _finer(
    found: Accuracies, target: float, last: Round, excess: NDArray[np.float64]
) -> tuple[float, NDArray[np.bool_]]:
    """Growth of the number of elements, and which readings look the solution up later: the cheapest way to a mesh part.

    Parameters
    ----------
    target : float
        Largest mesh part of any reading.
    excess : (n,) float64
        Variances over what they may be.
    """
    focus, lookup = last.of_readings(len(excess))
    paths = last.options.gather_samples * focus
    best = np.inf, MOST_GROWTH, found.mesh > target
    for elements in 2.0 ** np.arange(0.0, np.log2(MOST_GROWTH) + 0.25, 0.25):
        left = found.mesh / elements ** (MESH_ORDER / 2.0)
        deep = (left > target) & (lookup < DEEP)
        if (np.where(deep, left / DEEP_GAIN, left) > target).any():
            continue
        need = np.maximum(excess * np.where(deep, DEEP_NOISE, 1.0), 1.0) ** (1.0 / SAMPLES_ORDER)
        price = ELEMENT_PATHS * elements * last.options.elements
        price += float((paths * need * np.where(deep | (lookup == DEEP), DEEP_PRICE, 1.0)).sum())
        if price < best[0]:
            best = price, float(elements), deep
    return best[1], best[2] & (lookup < DEEP)


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
