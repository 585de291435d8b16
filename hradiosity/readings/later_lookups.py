"""What it would do to readings if their paths looked the solution up later: more noise, less error of the elements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import Guides
from hradiosity.readings.path_tracing import (
    PathRules,
    PathSamples,
    Points,
    changed_light,
    lit_hits_of,
    reflected_light,
    trace_paths,
)
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

LATER: Final = (3, 5, 7)
"""Hits at which paths may look the solution up instead."""
TRIED_PATHS: Final = 128
"""Paths of a reading by which that is tried."""
MOST_TRIED: Final = 256
"""Readings that are tried at a time; others are taken to be like their median."""
PATH_RAYS: Final = 1.0
"""What a path takes beside its rays, in rays: measured in the office."""
USUAL_NOISE, USUAL_GAIN, USUAL_PRICE = (5.0, 6.0, 6.0), (2.8, 8.0, 25.0), (2.6, 4.0, 5.0)
"""What lookups at these hits do over those at the first: between the office and the Cornell box."""


@dataclass(frozen=True)
class Lookups:
    """What lookups at some hits do to readings, all over the first of these hits.

    hits : (k,) int64, ascending
    noise : (n, k) float64, variance of a path
    gain : (n, k) float64, what errors of the light on the elements are divided by
    price : (k,) float64, of a path
    """

    hits: NDArray[np.int64]
    noise: NDArray[np.float64]
    gain: NDArray[np.float64]
    price: NDArray[np.float64]

    @classmethod
    def usual(cls, first: int, n: int) -> Lookups:
        """Of n readings of which nothing is known, whose paths look the solution up at that hit up to now."""
        usual = np.array([(1.0, 1.0, 1.0), *zip(USUAL_NOISE, USUAL_GAIN, USUAL_PRICE)])
        reached = int(np.searchsorted((1, *LATER), first, side="right")) - 1
        noise, gain, price = (usual[reached:] / usual[reached]).T
        hits = np.array([first, *LATER[reached:]], np.int64)
        return cls(hits, np.tile(noise, (n, 1)), np.tile(gain, (n, 1)), price)

    def level(self, lookup: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n,) which of the hits these lookups (n,) are at."""
        return np.asarray(np.searchsorted(self.hits, lookup))

    def gain_at(self, lookup: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n,) of each reading with its lookup (n,)."""
        return np.take_along_axis(self.gain, self.level(lookup)[:, None], 1)[:, 0]

    def some(self, chosen: NDArray[np.int64]) -> Lookups:
        """That of some of the readings."""
        return replace(self, noise=self.noise[chosen], gain=self.gain[chosen])


@dataclass(frozen=True)
class TriedLookups:
    """What is known of later lookups so far.

    known : (n,) bool, readings that were tried
    lookups : Lookups
        Of all n; those that were not tried are like the median of the others.
    """

    known: NDArray[np.bool_]
    lookups: Lookups

    @classmethod
    def none(cls, first: int, n: int) -> TriedLookups:
        """Before any was tried, of n readings whose paths look the solution up at that hit up to now."""
        return cls(np.zeros(n, np.bool_), Lookups.usual(first, n))

    def with_more(self, chosen: NDArray[np.int64], found: Lookups) -> TriedLookups:
        """The same after some of the readings (m,) were tried.

        Where few paths find the light, those of a single reading tell too little noise: it has that of the median, at
        least.
        """
        known = self.known.copy()
        known[chosen] = True
        before = self.lookups
        noise, gain = (
            _filled(old, chosen, new, known) for old, new in ((before.noise, found.noise), (before.gain, found.gain))
        )
        noise = np.maximum(noise, np.median(noise[known], axis=0))
        share = len(chosen) / np.count_nonzero(known)
        price = (1.0 - share) * before.price + share * found.price
        return TriedLookups(known, Lookups(before.hits, noise, gain, price))

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """What it is made of, by name."""
        return {"known": self.known, **vars(self.lookups)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> TriedLookups:
        """From `arrays`."""
        of_lookups = {name: array for name, array in arrays.items() if name != "known"}
        return cls(arrays["known"].astype(np.bool_), Lookups(**of_lookups))


def _filled(
    old: NDArray[np.float64], chosen: NDArray[np.int64], new: NDArray[np.float64], known: NDArray[np.bool_]
) -> NDArray[np.float64]:
    filled = old.copy()
    filled[chosen] = new
    filled[~known] = np.median(filled[known], axis=0)
    return filled


def some_of(readings: NDArray[np.int64]) -> NDArray[np.int64]:
    """So many of these readings (n,) as are tried at a time, evenly from first to last."""
    n = len(readings)
    return readings[np.unique(np.linspace(0, n - 1, min(MOST_TRIED, n)).astype(np.int64))] if n else readings


def try_lookups(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    points: Points,
    guides: Guides,
    rules: PathRules,
    seed: int,
) -> Lookups:
    """Trace a few paths from each point with lookups at the rules' hit and at later ones.

    Errors of the elements' light reach a reading through what its paths look up, and shrink with that.
    """
    hits = np.array([rules.lookup, *(hit for hit in LATER if hit > rules.lookup)], np.int64)
    guide = guides.upload(scene.device)
    found = []
    for hit in hits:
        its_rules = replace(rules, lookup=int(hit))
        paths = trace_paths(scene, elements, light, points, TRIED_PATHS, seed, its_rules, guide=guide, last_chance=True)
        found.append(_said_by(scene, paths, light))
    variance, looked_up, price = (np.stack(part, axis=-1) for part in zip(*found))
    return Lookups(
        hits,
        np.maximum(_over_first(variance), 1.0),
        np.maximum(1.0 / _over_first(looked_up, least=np.finfo(np.float64).tiny), 1.0),
        price / price[0],
    )


def _said_by(
    scene: DeviceScene, paths: PathSamples, light: SurfaceLight
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Variance of a path's brightness (n,), brightness that is looked up (n,), price of a path in rays."""
    sums = reflected_light(scene, paths, light)[1]
    mean = sums[:, 0] / paths.n_samples
    weight = scene.device.fetch(light.weight).astype(np.float64)
    looked_up = changed_light(scene, paths, light, light.reflected) @ weight
    price = 1.0 + PATH_RAYS + 2.0 * float(lit_hits_of(scene.device, paths).mean())
    return np.maximum(sums[:, 1] / paths.n_samples - mean**2, 0.0), looked_up, price


def _over_first(some: NDArray[np.float64], least: float = 0.0) -> NDArray[np.float64]:
    """(n, k) over the first of each row; 1 where that is none."""
    first = some[:, :1]
    return np.maximum(np.divide(some, first, out=np.ones_like(some), where=first > 0.0), least)
