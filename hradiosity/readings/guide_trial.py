"""Whether guides are worth their rays: a trial with some of the readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import SIDE, DeviceGuides, Guides
from hradiosity.readings.guide_pilot import make_guides
from hradiosity.readings.guide_seeds import parts_towards
from hradiosity.readings.path_tracing import PathRules, reflected_light, trace_paths, upload_points
from hradiosity.readings.pilot_light import PilotLight, brightness_met
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

GUIDED_AT_ONCE: Final = 1024
"""Readings whose guides are made at a time."""
TRIED: Final = (64, 128)
"""Readings of the trial, evenly from first to last: one in `ONE_IN`, the second at most. All are guided where these are
fewer than the first: a trial would take as long as it might save, and few readings tell little."""
ONE_IN: Final = 16
SETS: Final = 8
"""Independent sets of paths in the trial, each as large as a replicate's: well spread paths gain most where nothing
guides them, which the variance of single paths does not tell."""
GUIDE_RAY: Final = 0.28
"""Price of a ray that a guide is made of, in paths, with what is made of it."""
_SEED: Final = 0x632BE5AB


def guides_that_pay(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    other: NDArray[np.float64],
    n_paths: int,
    replicates: float,
    *,
    rules: PathRules,
    seed: int,
    response: NDArray[np.float32] | None = None,
) -> Guides:
    """Guides of all readings, or even ones where paths in place of the guides' rays would bring more.

    Where much of the light passes few spots, no trial is needed.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    other : (n,) float64
        Brightness that does not come over paths.
    n_paths : int
        Of a reading in a replicate.
    replicates : float
        That are planned; infinite if guides may serve any number of paths.
    rules, seed, response
        As in `hradiosity.readings.effort.plan_effort`.
    """
    n = len(position)
    bright = brightness_met(scene, elements, light)

    def made(some: NDArray[np.int64], its_seed: int) -> Guides:
        points = upload_points(scene, position[some], normal[some])
        place = scene.bvh.to_local(position[some]).astype(np.float64)
        known = parts_towards(place, normal[some], light.spots)
        return make_guides(PilotLight(scene, elements, points, bright, its_seed, known), other[some], n_paths)

    def tried_paths(some: NDArray[np.int64], guide: DeviceGuides | None) -> Tried:
        points = upload_points(scene, position[some], normal[some], None if response is None else response[some])
        sums = np.zeros((SETS, 2, len(some)))
        for number in range(SETS):
            its_seed = (seed + _SEED * (number + 1)) & 0xFFFFFFFF
            paths = trace_paths(scene, elements, light, points, n_paths, its_seed, rules, guide=guide, last_chance=True)
            sums[number] = reflected_light(scene, paths, light)[1].T / n_paths
        return Tried.of(sums)

    if n >= ONE_IN * TRIED[0] and replicates < np.inf and not len(light.spots):
        some = np.linspace(0, n - 1, min(n // ONE_IN, TRIED[1])).astype(np.int64)
        guided, even = tried_paths(some, made(some, seed).upload(scene.device)), tried_paths(some, None)
        points = upload_points(scene, position[some], normal[some])
        seen = PilotLight(scene, elements, points, bright, seed ^ _SEED).everywhere().reshape(len(some), -1)
        if not pays(guided, even, seen.var(axis=1), other[some], n_paths * replicates):
            return Guides.even(n)
    starts = range(0, n, GUIDED_AT_ONCE)
    return Guides.joined([made(np.arange(first, min(first + GUIDED_AT_ONCE, n)), seed + first) for first in starts])


@dataclass(frozen=True)
class Tried:
    """Paths of some readings, (m,) float64 each: their mean, the variance of one, and that of the mean of a set."""

    mean: NDArray[np.float64]
    of_path: NDArray[np.float64]
    of_set: NDArray[np.float64]

    @classmethod
    def of(cls, sums: NDArray[np.float64]) -> Tried:
        """From means of the brightness and of its square in each set, (SETS, 2, m)."""
        mean, square = sums.mean(axis=0)
        return cls(mean, np.maximum(square - mean**2, 0.0), sums[:, 0].var(axis=0, ddof=1))


def pays(guided: Tried, even: Tried, seen: NDArray[np.float64], other: NDArray[np.float64], n_paths: float) -> bool:
    """Whether guides leave less noise than as many even paths as have the same price, each shared out by the readings'
    spreads: then the noise goes as the square of their sum.

    Parameters
    ----------
    seen : (m,) float64
        Variance of what rays to all parts of the hemispheres meet: more of it than even paths have is rare light that
        they missed.
    other : (m,) float64
        Brightness of the readings that does not come over paths.
    n_paths : float
        Of a reading in all.
    """
    total = guided.mean + other
    weight = np.divide(1.0, total**2, out=np.zeros_like(total), where=total > 0.0)
    of_guided, of_even, of_path, of_seen = (
        float(np.sqrt(some * weight).mean()) ** 2 for some in (guided.of_set, even.of_set, even.of_path, seen)
    )
    if of_path == 0.0:
        return of_seen > 0.0
    missed = max(of_seen / of_path, 1.0)
    return of_guided * (1.0 + GUIDE_RAY * SIDE**2 / n_paths) < of_even * missed
