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
from hradiosity.radiosity.remedy import (
    LEAST_DEEPER,
    LEAST_TOLERANCE,
    MESH_ORDER,
    MOST_ELEMENTS,
    MOST_GROWTH,
    OTHER_SHARE,
    RAYS_PRICE,
    SATURATED,
    Held,
    Remedy,
    cheapest_remedy,
    goes_needed,
    in_the_way,
)

MOST_REPLICATES: Final = 256
FIXED_SHARE: Final = 0.7
"""Of the wanted half width, what parts that samples do not narrow may have before the solver goes on for longer."""
MOST_DEEPER, MOST_ANEW = 4.0, 16.0
"""Samples of a reading after one step over those before: the spread that calls for more is itself uncertain. The second
is for readings that are begun again with later lookups."""
FIRST_STEPS: Final = 2
"""Steps of more samples that readings have had before anything dearer is done for their sake, see `FIRST_SHARE`."""
MOST_FIRST_STEPS: Final = 4
"""The same for readings that still need more than `SURE_ENOUGH` times the samples they have had."""
SURE_ENOUGH: Final = 2.0
"""Samples that readings need over those they have had, above which their mesh and exchange parts are noise as well."""
FIRST_SHARE: Final = 0.25
"""Of the price of other elements, what all samples may cost that are taken first, to be surer whether they are needed,
and that are given up if they are."""
MOST_STEPS: Final = 6
"""After so many steps that brought a reading more samples, what is left of its noise is taken to be the elements'."""
MOST_TIMES: Final = 2.0**20
"""Samples of a reading over those of its first go."""
MOST_FINER: Final = 4.0
"""Growth of the elements from one round to the next where all readings are read anew with them."""
MESH_SHARE: Final = 0.45
"""Of the wanted half width, what the mesh part is brought down to by them."""
FINER_POWER: Final = 1.5
"""Of the elements, with which the work of the classic mode grows, about."""
WORTH_A_ROUND: Final = 2.0
"""Growth of all samples from which on a new round pays, since it throws the last one away."""


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
    something else is in their way: then all elements become smaller or send more rays, or those readings look the
    solution up later, whatever is cheapest (`remedy`); the solver goes on for longer where that is what is left.

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
    found = with_noise_of_elements(found, held)
    off = in_the_way(found, accuracy, options, held)
    remedy = cheapest_remedy(found, accuracy, options, held, lacking)
    following = _with_remedy(remedy, found, accuracy, options, held.edge)
    step = _step(found, accuracy, following, remedy, held, lacking, options)
    if step is None or ahead or not (step.larger or (step.lookup != held.lookup).any()):
        return step
    needed = goes_needed(found, accuracy, held)
    unsure = lacking & (held.steps < np.where(needed > SURE_ENOUGH * held.times, MOST_FIRST_STEPS, FIRST_STEPS))
    if 2 * np.count_nonzero(unsure & off) < np.count_nonzero(off) or not off.any():
        return step
    noise = found.without_fixed()
    alone = Remedy(1.0, 1.0, held.lookup, goes_needed(noise, accuracy, held), 0.0)
    first = _step(noise, accuracy, options, alone, held, unsure, options)
    if first is None:
        return step
    given_up = held.price(np.where(lacking & off, held.times - 1.0, 0.0), held.lookup)
    cheap = options.replicates * (given_up + first.price(held)) < FIRST_SHARE * remedy.price
    return first if cheap else step


def with_noise_of_elements(found: Accuracies, held: Held) -> Accuracies:
    """The same where noise that many steps of samples have left counts as that of the elements."""
    return replace(found, common=np.where(held.steps >= MOST_STEPS, found.sampling, found.common))


def _with_remedy(remedy: Remedy, found: Accuracies, accuracy: float, options: Options, edge: float) -> Options:
    """Elements and rays as a remedy says, and a tolerance for the readings in whose way that is.

    Smaller elements are asked for by their edge: a number of them only counts down to a share of the mean free path,
    which is too coarse for readings beside a gap.
    """
    if remedy.elements > 1.0 and options.element_size is None and edge > 0.0:
        options = replace(options, element_size=edge)
    larger = grown(options, elements=remedy.elements, rays=remedy.rays)
    off = (found.total > accuracy) & (found.fixed > FIXED_SHARE * accuracy)
    looser = float(found.other[off].max(initial=0.0)) / (OTHER_SHARE * accuracy)
    if looser <= 1.0:
        return larger
    return replace(larger, tolerance=max(larger.tolerance / looser, LEAST_TOLERANCE))


def _step(
    found: Accuracies,
    accuracy: float,
    options: Options,
    remedy: Remedy,
    held: Held,
    lacking: NDArray[np.bool_],
    before: Options,
) -> Step | None:
    """Samples for readings that lack accuracy, some of which look the solution up later; None where none help."""
    larger = options != before
    if options.tolerance != before.tolerance:
        remedy = replace(remedy, goes=np.where(lacking, remedy.goes, goes_needed(found, accuracy, held)))
        lacking = np.ones_like(lacking)
    anew = lacking & (larger | (remedy.lookup != held.lookup))
    further = np.clip(remedy.goes - held.times, LEAST_DEEPER * held.times, (MOST_DEEPER - 1.0) * held.times)
    most = MOST_TIMES if larger else MOST_ANEW * held.times
    times = np.where(anew, np.clip(remedy.goes, 1.0, most), further)
    of_use = anew | ((found.fixed < accuracy) & (held.times < MOST_TIMES))
    times = np.where(lacking & of_use, times, 0.0)
    if not times.any():
        return None
    return Step(options, times, np.where(lacking, remedy.lookup, held.lookup), anew & (times > 0.0), larger)


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
