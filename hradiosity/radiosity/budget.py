"""How a run goes on when an accuracy or a time is asked for: more samples, or a new round on other elements.

Pure functions of what the replicates so far say; nothing here looks at a clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import student_quantile
from hradiosity.options import Options
from hradiosity.radiosity.accuracies import Accuracies

MOST_REPLICATES: Final = 256
FIXED_SHARE: Final = 0.7
"""Of the wanted half width, what parts that samples do not narrow may have before something is done about them."""
MESH_SHARE, EXCHANGE_SHARE, OTHER_SHARE = 0.45, 0.4, 0.4
"""What they are brought down to then: by elements and lookups, by rays from each element, and, for the iteration and
combined columns, by the solver's tolerance."""
SAME_MESH_SHARE: Final = 0.65
"""The same for the mesh part where the elements stay as they are: if that proves too much, little was spent on it."""
WORST_EXCHANGE_SHARE: Final = 0.6
"""The same for the exchange part of the worst reading, mostly noise; the other share is for `MOST_READINGS`."""
MESH_ORDER: Final = 1.5
"""Power of the edge of elements with which the mesh part falls, about."""
DEEP: Final = 3
"""Hit at which readings look the solution up whose mesh part is too large."""
DEEP_GAIN, DEEP_NOISE, DEEP_PRICE = 2.5, 6.0, 2.5
"""What that divides their mesh and exchange parts by, and multiplies their variance and the price of a path by: means
over office and Cornell box, for lookups at the first hit before, and the larger of both for the variance."""
ELEMENT_PATHS: Final = 200.0
"""Price of an element in all replicates, in paths: rays, closing and solution. Measured in the office."""
RAYS_PRICE: Final = 0.5
"""Share of that that grows with the number of its rays."""
MOST_READINGS: Final = 0.9
"""Share of the readings that lack accuracy whose exchange part is brought down to its share; few are off by more."""
NOISE_SHARE: Final = 0.35
"""Of the wanted half width squared, what may for certain come from the noise of the light on the elements."""
NOISE_GOAL: Final = 0.25
"""What it is brought down to then."""
MARGIN: Final = 1.15
"""More samples than the spread so far calls for: it is an estimate from few replicates, and it takes a further step to
mend one that was too low."""
MOST_DEEPER: Final = 4.0
"""Samples of a reading after one step over those before: the spread that calls for more is itself uncertain."""
FIRST_STEPS: Final = 2
"""Steps of more samples that readings have had before anything dearer is done for their sake, see `FIRST_SHARE`."""
MOST_FIRST_STEPS: Final = 4
"""The same for readings that still need more than `SURE_ENOUGH` times the samples they have had."""
SURE_ENOUGH: Final = 2.0
"""Samples that readings need over those they have had, above which their mesh and exchange parts are noise as well."""
FIRST_SHARE: Final = 0.25
"""Of the price of other elements, what samples may cost that are taken first, to be surer whether they are needed."""
MOST_STEPS: Final = 6
"""After so many steps that brought a reading more samples, what is left of its noise is taken to be the elements'."""
LEAST_DEEPER: Final = 0.25
"""Samples of a step over those before, at least."""
MOST_TIMES: Final = 2.0**20
"""Samples of a reading over those of its first go."""
MOST_GROWTH: Final = 256.0
"""Of all samples, elements or rays, from one round to the next."""
MOST_ELEMENTS, MOST_RAYS = 2e6, 2.0**16
"""Elements, and rays from each in all replicates, that no round goes beyond."""
LEAST_MORE_RAYS: Final = 1.5
"""Growth of the rays from each element that a round is begun for: parts in the way are estimates themselves."""
SATURATED: Final = 2.0
"""Elements asked for over those that there are, from which on smaller patches or rooms bound them, and not the wish."""
LEAST_TOLERANCE: Final = 1e-6
"""Of the linear solver: single precision gets no further."""
MOST_FINER: Final = 4.0
"""Growth of the elements from one round to the next where all readings are read anew with them."""
FINER_POWER: Final = 1.5
"""Of the elements, with which the work of the classic mode grows, about."""
WORTH_A_ROUND: Final = 2.0
"""Growth of all samples from which on a new round pays, since it throws the last one away."""


@dataclass(frozen=True)
class Held:
    """What readings have had so far.

    paths : (n,) float64, of each in one go of a replicate
    times : (n,) float64, goes
    lookup : (n,) int64, first hit at which they look the solution up
    steps : (n,) int64, in which they got more samples by the same light on the elements
    one_go : (n,) float64, square of the half width that the samples of one go leave, without what others leave
    elements : that there are, which may be far fewer than were asked for
    """

    paths: NDArray[np.float64]
    times: NDArray[np.float64]
    lookup: NDArray[np.int64]
    steps: NDArray[np.int64]
    one_go: NDArray[np.float64]
    elements: int = 0

    def price(self, times: NDArray[np.float64], lookup: NDArray[np.int64]) -> float:
        """Of so many goes, in paths that look the solution up at the first hit."""
        return float((self.paths * times * DEEP_PRICE ** ((lookup - 1.0) / (DEEP - 1.0))).sum())


@dataclass(frozen=True)
class Step:
    """What a run does next to readings that are not accurate enough.

    options : elements and rays of the replicates
    times : (n,) float64, goes of each reading, none where it is left as it is
    lookup : (n,) int64, first hit at which it looks the solution up
    anew : (n,) bool, whether its earlier goes do not count any more
    larger : whether the replicates have to be solved afresh
    """

    options: Options
    times: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    lookup: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    anew: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    larger: bool = False

    def price(self, held: Held) -> float:
        """Of its readings in a replicate, in paths."""
        return held.price(self.times, self.lookup)

    def shortened(self, share: float) -> Step:
        """The same with a share of its samples, for what there is time for."""
        return replace(self, times=share * self.times)


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


def next_step(found: Accuracies, accuracy: float, options: Options, held: Held, *, ahead: bool = False) -> Step | None:
    """What brings the readings that lack it to an accuracy; None where all have it, or where nothing is left to do.

    Readings that are accurate stay as they are. The others get more samples by the same light on the elements, unless
    something else is in their way: where the mesh part is too large, either all elements become smaller or those
    readings look the solution up later, whatever is cheaper; elements send more rays where the exchange part or their
    own noise asks for it, and the solver goes on for longer.

    Parameters
    ----------
    options : Options
        With the elements and rays of the replicates so far.
    ahead : bool
        Leave out samples that are only taken to be surer of what comes then, for a forecast.
    """
    lacking = found.total > accuracy
    if not lacking.any():
        return None
    found = replace(found, common=np.where(held.steps >= MOST_STEPS, found.sampling, found.common))
    off = lacking & ((found.fixed > FIXED_SHARE * accuracy) | _noisy(found, accuracy))
    remedy = _cheapest_remedy(found, accuracy, options, held, lacking, off)
    step = _step(found, accuracy, remedy.options(found, accuracy, options, off), held, lacking, remedy.deep, options)
    if step is None or not step.larger or ahead:
        return step
    needed = goes_needed(found, accuracy, held)
    unsure = lacking & (held.steps < np.where(needed > SURE_ENOUGH * held.times, MOST_FIRST_STEPS, FIRST_STEPS))
    if 2 * np.count_nonzero(unsure & off) < np.count_nonzero(off) or not off.any():
        return step
    first = _step(found.without_fixed(), accuracy, options, held, unsure, np.zeros_like(unsure), options)
    price = _price(remedy, found, accuracy, options, held, lacking)
    cheap = first is not None and options.replicates * first.price(held) < FIRST_SHARE * price
    return first if cheap else step


def _step(
    found: Accuracies,
    accuracy: float,
    options: Options,
    held: Held,
    lacking: NDArray[np.bool_],
    deep: NDArray[np.bool_],
    before: Options,
) -> Step | None:
    """Samples for readings that lack accuracy, some of which look the solution up later; None where none help."""
    larger = options != before
    if options.tolerance != before.tolerance:
        lacking = np.ones_like(lacking)
    total = np.minimum(goes_needed(found, accuracy, held) * np.where(deep, DEEP_NOISE, 1.0), MOST_TIMES)
    anew = lacking & (deep | larger)
    further = np.clip(total - held.times, LEAST_DEEPER * held.times, (MOST_DEEPER - 1.0) * held.times)
    most = MOST_TIMES if larger else MOST_DEEPER * held.times
    times = np.where(anew, np.clip(total, 1.0, most), further)
    of_use = anew | ((found.fixed < accuracy) & (held.times < MOST_TIMES))
    times = np.where(lacking & of_use, times, 0.0)
    if not times.any():
        return None
    return Step(options, times, np.where(deep, DEEP, held.lookup), anew & (times > 0.0), larger)


def goes_needed(found: Accuracies, accuracy: float, held: Held) -> NDArray[np.float64]:
    """(n,) goes in all, with which the readings are accurate.

    Parts that samples do not narrow count as they will be at the most: they are brought down.
    """
    fixed = np.minimum(found.fixed, FIXED_SHARE * accuracy)
    common = np.minimum(found.common, NOISE_SHARE**0.5 * accuracy)
    room = accuracy**2 - fixed**2 - common**2
    return np.asarray(MARGIN * held.one_go / room)


@dataclass(frozen=True)
class _Remedy:
    """What brings down parts that samples leave as they are.

    elements, rays : growth of the number of elements, and of rays from each
    deep : (n,) bool, readings that look the solution up later
    """

    elements: float
    rays: float
    deep: NDArray[np.bool_]

    def options(self, found: Accuracies, accuracy: float, options: Options, off: NDArray[np.bool_]) -> Options:
        """With so many elements and rays, and a tolerance for the readings (n,) in whose way such parts are."""
        larger = grown(options, elements=self.elements, rays=self.rays)
        looser = float(found.other[off].max(initial=0.0)) / (OTHER_SHARE * accuracy)
        if looser <= 1.0:
            return larger
        return replace(larger, tolerance=max(larger.tolerance / looser, LEAST_TOLERANCE))


def _cheapest_remedy(
    found: Accuracies,
    accuracy: float,
    options: Options,
    held: Held,
    lacking: NDArray[np.bool_],
    off: NDArray[np.bool_],
) -> _Remedy:
    """Smaller elements and more rays, or later lookups, or some of both, for the least time in all.

    Only readings that lack accuracy count, and only parts of those in whose way such parts are.
    """
    exchange = np.where(off, found.exchange, 0.0)
    later = off & (held.lookup < DEEP)
    by_rays = later & ((exchange > WORST_EXCHANGE_SHARE * accuracy) | _noisy(found, accuracy))
    best, least = _Remedy(1.0, 1.0, later), np.inf
    for elements in _growths(options, held):
        left = np.where(off, found.mesh, 0.0) / elements ** (MESH_ORDER / 2.0)
        goal = (MESH_SHARE if elements > 1.0 else SAME_MESH_SHARE) * accuracy
        by_mesh = later & (left > goal)
        if (np.where(by_mesh, left / DEEP_GAIN, left) > goal).any():
            continue
        for deep in (by_mesh, by_mesh | by_rays):
            gain = np.where(deep, DEEP_GAIN, 1.0)
            noise = np.where(off & _noisy(found, accuracy), found.common, 0.0) / gain / elements**0.5
            rays = _rays_growth(accuracy, exchange[lacking] / gain[lacking], noise)
            if elements == 1.0 < rays:
                rays = max(rays, LEAST_MORE_RAYS)
            rays = min(rays, MOST_GROWTH, max(1.0, MOST_RAYS / options.rays_per_element))
            remedy = _Remedy(float(elements), rays, deep)
            price = _price(remedy, found, accuracy, options, held, lacking)
            if price < least:
                best, least = remedy, price
    return best


def _growths(options: Options, held: Held) -> NDArray[np.float64]:
    """Of the number of elements, from 1 on: only 1 where more don't come of it."""
    most = min(MOST_GROWTH, MOST_ELEMENTS / max(held.elements, 1))
    if options.element_size is None and options.elements > SATURATED * held.elements > 0:
        most = 1.0
    return np.asarray(2.0 ** np.arange(0.0, np.log2(max(most, 1.0)) + 0.25, 0.25))


def _noisy(found: Accuracies, accuracy: float) -> NDArray[np.bool_]:
    """(n,) readings in whose way the noise of the elements is."""
    return found.common**2 > NOISE_SHARE * accuracy**2


def _rays_growth(accuracy: float, exchange: NDArray[np.float64], noise: NDArray[np.float64]) -> float:
    """Growth of the rays from each element, for exchange parts in the way (n,) and the elements' own noise (n,)."""
    usual = float(np.quantile(exchange, MOST_READINGS)) / (EXCHANGE_SHARE * accuracy)
    worst = float(exchange.max(initial=0.0)) / (WORST_EXCHANGE_SHARE * accuracy)
    own = float(noise.max(initial=0.0)) ** 2 / (NOISE_GOAL * accuracy**2)
    return max(usual, worst, own, 1.0)


def _price(
    remedy: _Remedy,
    found: Accuracies,
    accuracy: float,
    options: Options,
    held: Held,
    lacking: NDArray[np.bool_],
) -> float:
    """Of a remedy and the samples that readings need with it, in paths."""
    needed = goes_needed(found, accuracy, held) * np.where(remedy.deep, DEEP_NOISE, 1.0)
    renewed = remedy.elements * remedy.rays > 1.0
    had = 0.0 if renewed else np.where(remedy.deep, 0.0, held.times)
    times = np.where(lacking, np.maximum(needed - had, 0.0), 0.0)
    readings = options.replicates * held.price(times, np.where(remedy.deep, DEEP, held.lookup))
    per_element = (1.0 - RAYS_PRICE + RAYS_PRICE * remedy.rays) * ELEMENT_PATHS
    return readings + (per_element * remedy.elements * (held.elements or options.elements) if renewed else 0.0)


def finer_elements(found: Accuracies, accuracy: float, options: Options, elements: int) -> tuple[Options, float] | None:
    """More elements for all readings, and their growth; None unless the mesh is in the way and more come of asking.

    For modes that can't read single points again.

    Parameters
    ----------
    elements : int
        As many as their size gives, without what small patches add.
    """
    worst = float(found.mesh[found.total > accuracy].max(initial=0.0)) / accuracy
    by_size = options.element_size is not None
    most = MOST_ELEMENTS / max(elements, 1) if by_size or options.elements <= SATURATED * elements else 1.0
    growth = min((worst / MESH_SHARE) ** (2.0 / MESH_ORDER), MOST_FINER, most)
    if worst <= FIXED_SHARE or growth <= 1.0:
        return None
    if by_size:
        return grown(options, elements=growth), growth
    return replace(options, elements=round(growth * elements)), growth


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
        rows = elements * (1.0 - RAYS_PRICE + RAYS_PRICE * rays) * self.rows
        return elements * self.start + replicates * (rows + samples * self.readings)


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
