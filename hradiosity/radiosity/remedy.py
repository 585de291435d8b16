"""What brings readings to an accuracy for the least time: elements, their rays, later lookups, and samples.

Pure functions of what the replicates so far say.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.radiosity.accuracies import Accuracies
from hradiosity.readings.later_lookups import Lookups

MARGIN: Final = 1.15
"""More samples than the spread so far calls for: it is an estimate from few replicates, and it takes a further step to
mend one that was too low."""
LEAST_ROOM: Final = 0.3
"""Of the wanted half width squared, what is left at least to the readings' own samples: else something is done about
the other parts."""
DOUBT: Final = 1.3
"""Mesh and exchange parts count that much more where they are expected and were not yet seen: a second round on other
elements is dearer than a first one that was larger than it had to be."""
OTHER_SHARE: Final = 0.4
"""Of the wanted half width, what the iteration and combined columns are brought down to by the solver's tolerance."""
LEAST_TOLERANCE: Final = 1e-6
"""Of the linear solver: single precision gets no further."""
LEAST_DEEPER: Final = 0.25
"""Samples of a step over those before, at least."""
MESH_ORDER: Final = 1.5
"""Power of the edge of elements with which the mesh part falls, about."""
ELEMENT_PATHS: Final = 400.0
"""Price of an element in all replicates, in paths: rays, closing and solution. Measured in the office."""
RAYS_PRICE: Final = 0.5
"""Share of that that grows with the number of its rays."""
MOST_GROWTH: Final = 256.0
"""Of all samples, elements or rays, from one round to the next."""
MOST_ELEMENTS, MOST_RAYS = 2e6, 2.0**16
"""Elements, and rays from each in all replicates, that no round goes beyond."""
SATURATED: Final = 2.0
"""Elements asked for over those that there are, from which on smaller patches or rooms bound them, and not the wish."""


@dataclass(frozen=True)
class Held:
    """What readings have had so far.

    paths : (n,) float64, of each in one go of a replicate
    times : (n,) float64, goes
    lookup : (n,) int64, first hit at which they look the solution up
    steps : (n,) int64, in which they got more samples by the same light on the elements
    one_go : (n,) float64, square of the half width that the samples of one go leave, without what others leave
    lookups : Lookups
        What later lookups would do to them.
    elements : that there are, which may be far fewer than were asked for
    edge : of an element [m]; 0 where it is not known
    """

    paths: NDArray[np.float64]
    times: NDArray[np.float64]
    lookup: NDArray[np.int64]
    steps: NDArray[np.int64]
    one_go: NDArray[np.float64]
    lookups: Lookups
    elements: int = 0
    edge: float = 0.0

    def some(self, chosen: NDArray[np.int64]) -> Held:
        """That of some of the readings."""
        return Held(
            paths=self.paths[chosen],
            times=self.times[chosen],
            lookup=self.lookup[chosen],
            steps=self.steps[chosen],
            one_go=self.one_go[chosen],
            lookups=self.lookups.some(chosen),
            elements=self.elements,
            edge=self.edge,
        )

    def price(self, times: NDArray[np.float64], lookup: NDArray[np.int64]) -> float:
        """Of so many goes, in paths that look the solution up where all did at first."""
        return float((self.paths * times * self.lookups.price[self.lookups.level(lookup)]).sum())


@dataclass(frozen=True)
class Remedy:
    """What to do for readings that are not accurate enough.

    elements, rays : growth of the number of elements, and of rays from each
    lookup : (n,) int64, first hit at which readings look the solution up
    goes : (n,) float64, that they need in all then; 0 where they are accurate
    price : of all that, in paths
    """

    elements: float
    rays: float
    lookup: NDArray[np.int64]
    goes: NDArray[np.float64]
    price: float


def cheapest_remedy(
    found: Accuracies, accuracy: float, options: Options, held: Held, lacking: NDArray[np.bool_]
) -> Remedy:
    """Smaller elements, more rays from each, later lookups of single readings, or none of it, for the least time.

    Each of the readings that lack accuracy takes the lookup that is cheapest for it. Where nothing brings all of them
    to the accuracy, what brings most.
    """
    chosen = np.flatnonzero(lacking)
    some = _Lacking.of(found, accuracy, options, held, chosen)
    trials = [
        some.trial(elements, rays) for elements in _element_growths(options, held) for rays in _rays_growths(options)
    ]
    best = min(trials, key=lambda trial: (trial.out_of_reach, trial.price))
    goes, lookup = np.zeros(len(held.times)), held.lookup.copy()
    goes[chosen], lookup[chosen] = best.goes, held.lookups.hits[best.level]
    return Remedy(best.elements, best.rays, lookup, goes, best.price)


def in_the_way(found: Accuracies, accuracy: float, options: Options, held: Held) -> NDArray[np.bool_]:
    """(n,) readings that samples alone do not bring to an accuracy."""
    lacking = np.flatnonzero(found.total > accuracy)
    some = _Lacking.of(found, accuracy, options, held, lacking)
    off = np.zeros(len(held.times), np.bool_)
    off[lacking] = ~some.reached(1.0, 1.0)[0][some.level, np.arange(len(lacking))]
    return off


def goes_needed(found: Accuracies, accuracy: float, held: Held) -> NDArray[np.float64]:
    """(n,) goes in all, with which the readings are accurate.

    Parts that samples do not narrow count as they will be at the most: they are brought down.
    """
    room = np.maximum(accuracy**2 - found.fixed**2 - found.common**2, LEAST_ROOM * accuracy**2)
    return np.asarray(MARGIN * held.one_go / room)


@dataclass(frozen=True)
class _Trial:
    """Growths, and for each reading the level of its lookups and the goes it needs then."""

    elements: float
    rays: float
    out_of_reach: int
    price: float
    level: NDArray[np.int64]
    goes: NDArray[np.float64]


@dataclass(frozen=True)
class _Lacking:
    """The m readings that lack accuracy; arrays (m,), or (k, m) for lookups at k hits over what they are now."""

    accuracy: float
    mesh: NDArray[np.float64]
    exchange: NDArray[np.float64]
    other: NDArray[np.float64]
    common: NDArray[np.float64]
    held: Held
    replicates: int
    level: NDArray[np.int64]
    gain: NDArray[np.float64]
    noise: NDArray[np.float64]

    @classmethod
    def of(
        cls, found: Accuracies, accuracy: float, options: Options, held: Held, chosen: NDArray[np.int64]
    ) -> _Lacking:
        """Of some of the readings."""
        kept = held.some(chosen)
        level = kept.lookups.level(kept.lookup)
        gain, noise = (
            some / np.take_along_axis(some, level[:, None], 1) for some in (kept.lookups.gain, kept.lookups.noise)
        )
        other = found.other[chosen]
        if options.tolerance > LEAST_TOLERANCE:
            other = np.minimum(other, OTHER_SHARE * accuracy)
        mesh, exchange, common = (some[chosen] for some in (found.mesh, found.exchange, found.common))
        return cls(accuracy, mesh, exchange, other, common, kept, options.replicates, level, gain.T, noise.T)

    def reached(self, elements: float, rays: float) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Whether a lookup, at each hit, brings a reading to the accuracy, and the square that is left for samples."""
        later = np.arange(len(self.gain))[:, None] - self.level
        unseen = (later > 0) | (elements * rays > 1.0)
        elements_error = (self.mesh / elements ** (MESH_ORDER / 2.0)) ** 2 + (self.exchange / rays) ** 2
        looked_up = np.where(unseen, DOUBT**2, 1.0) * elements_error + self.common**2 / (elements * rays)
        room = self.accuracy**2 - self.other**2 - looked_up / self.gain**2
        least = LEAST_ROOM * self.accuracy**2
        return (room >= least) & (later >= 0), np.maximum(room, least)

    def trial(self, elements: float, rays: float) -> _Trial:
        """The cheapest lookups on elements that are grown like that."""
        within, room = self.reached(elements, rays)
        goes = MARGIN * self.held.one_go * self.noise / room
        anew = np.ones_like(within) if elements * rays > 1.0 else np.arange(len(room))[:, None] > self.level
        further = np.maximum(goes - self.held.times, LEAST_DEEPER * self.held.times)
        price = np.where(anew, np.maximum(goes, 1.0), further) * self.held.lookups.price[:, None]
        index = np.arange(len(self.level))
        level = np.where(within.any(axis=0), np.where(within, price, np.inf).argmin(axis=0), self.level)
        paths = float((self.held.paths * price[level, index]).sum())
        total = self.replicates * paths + _elements_price(elements, rays, self.held.elements)
        lost = int(np.count_nonzero(~within.any(axis=0)))
        return _Trial(elements, rays, lost, total, level, goes[level, index])


def _elements_price(elements: float, rays: float, before: int) -> float:
    """Of new elements, in paths; none where they stay as they are."""
    if elements * rays <= 1.0:
        return 0.0
    return (1.0 - RAYS_PRICE + RAYS_PRICE * rays) * ELEMENT_PATHS * elements * before


def _element_growths(options: Options, held: Held) -> list[float]:
    """Of the number of elements, from 1 on: only 1 where more don't come of it."""
    most = min(MOST_GROWTH, MOST_ELEMENTS / max(held.elements, 1))
    by_edge = options.element_size is not None or held.edge > 0.0
    if not by_edge and options.elements > SATURATED * held.elements > 0:
        most = 1.0
    return [float(growth) for growth in 2.0 ** np.arange(0.0, 8.25, 0.5) if growth <= max(most, 1.0)]


def _rays_growths(options: Options) -> list[float]:
    """Of the rays from each element, from 1 on.

    Parts that are in the way are estimates: less than half as many more are not worth a round.
    """
    most = min(MOST_GROWTH, MOST_RAYS / options.rays_per_element)
    growths = np.sort(np.concatenate([2.0 ** np.arange(9), 1.5 * 2.0 ** np.arange(8)]))
    return [float(growth) for growth in growths if growth <= max(most, 1.0)]
