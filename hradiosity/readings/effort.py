"""How many rays each reading gets: more where few leave it uncertain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import Guides
from hradiosity.readings.guide_trial import guides_that_pay
from hradiosity.readings.interval import part_of
from hradiosity.readings.path_tracing import PathRules, reflected_light, trace_paths, upload_points
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_at_points

PILOT_PATHS = 64
PILOT_LIGHT_SAMPLES, LEAST_LIGHT_SAMPLES, ALL_LIGHT_SAMPLES = 64, 4, 512
"""Shadow rays of the pilot to each emitter; less to each of many, so that there are about so many to all of them."""
DARK_SHARE = 0.05
"""Readings darker than this share of the mean count as that bright: their relative error matters less."""
LEAST, LEAST_LIGHT, MOST = 0.5, 0.125, 32.0
"""Bounds of a reading's share of the paths, and of its shadow rays to an emitter, over an even one."""
FEWEST = 0.125
"""Shadow rays to an emitter, in the mean."""
SHADOW_RAY = 0.2
"""Price of a shadow ray, in paths."""
STRATIFIED = 0.4
"""Error of some hundred shadow rays, which are spread evenly over a lamp, over that of as many drawn at random; of
paths, which differ in more than where they start, much less is gained."""
UNSEEN_RAYS = 0.5
"""Rays of a pilot that count as having seen a lamp when none did, or as having missed it when all saw it."""
UNSEEN_AGAIN = 8
"""More rays to lamps that a pilot's rays all missed and that would outshine all other light, in such rays."""
BISECTIONS = 30
"""Of 24 powers of ten; samples go in steps of a factor 2."""


@dataclass(frozen=True)
class Effort:
    """Samples of each reading in one replicate.

    light : (n, n_emitters) float64, shadow rays; below 1 the probability of one
    seen : (n, n_emitters) bool, emitters that are mostly seen, as far as is known
    gather : (n,) int64, paths
    guide : Guides, of n readings, in which directions paths start
    lookup : (n,) int64, first hit of a path at which the solution may be looked up
    """

    light: NDArray[np.float64]
    seen: NDArray[np.bool_]
    gather: NDArray[np.int64]
    guide: Guides
    lookup: NDArray[np.int64]

    @classmethod
    def even(cls, shape: tuple[int, int], light: int, gather: int, lookup: int) -> Effort:
        """The same for all readings, (n, n_emitters) of them."""
        n = shape[0]
        rays, seen = np.full(shape, float(light)), np.zeros(shape, np.bool_)
        return cls(rays, seen, np.full(n, gather), Guides.even(n), np.full(n, lookup))

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Effort:
        """From `arrays`."""
        guide = Guides(**part_of(arrays, "guide"))
        return cls(arrays["light"], arrays["seen"], arrays["gather"], guide, arrays["lookup"])

    def focused(self, focus: NDArray[np.float64]) -> Effort:
        """So many times the samples (n,), in the steps of `stepped`; the same if there are no entries."""
        if not len(focus):
            return self
        times = stepped(focus)
        gather = np.maximum(np.rint(self.gather * times), self.gather > 0).astype(np.int64)
        return replace(self, light=_whole(self.light * times[:, None]), gather=gather)

    def of_goes(self, times: NDArray[np.float64]) -> Effort:
        """The samples (n,) goes have together."""
        light, gather = _whole(self.light * times[:, None]), np.rint(self.gather * times)
        return replace(self, light=light, gather=gather.astype(np.int64))

    def looking(self, lookup: NDArray[np.int64]) -> Effort:
        """The same with lookups at these hits (n,); the same if there are no entries."""
        return replace(self, lookup=lookup) if len(lookup) else self

    def some(self, chosen: NDArray[np.int64]) -> Effort:
        """That of some of the readings."""
        light, seen = self.light[chosen], self.seen[chosen]
        return Effort(light, seen, self.gather[chosen], self.guide.some(chosen), self.lookup[chosen])

    @property
    def rays(self) -> int:
        """About how many they take: paths that go on send a shadow ray from each hit."""
        return int(self.light.sum() + ((2 * self.lookup - 1) * self.gather).sum())

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """What it is made of, by name."""
        guide = {f"guide/{name}": array for name, array in vars(self.guide).items()}
        own = {"light": self.light, "seen": self.seen, "gather": self.gather, "lookup": self.lookup}
        return {**own, **guide}


def plan_effort(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    *,
    light_samples: int,
    gather_samples: int,
    replicates: float,
    rules: PathRules,
    seed: int,
    response: NDArray[np.float32] | None = None,
) -> Effort:
    """Spread paths and shadow rays over all readings by a pilot's spread, for the smallest rms relative error.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    light_samples, gather_samples : int
        Mean number of samples of a reading in a replicate.
    replicates : float
        That these are planned for; infinite if it may be any number of goes.
    rules : PathRules
        Of the paths that are planned for.
    response : (n, 12) float32, optional
        How directions weigh, see `hradiosity.model.sensor_kinds`.
    """
    n = len(position)
    if n == 0 or gather_samples <= PILOT_PATHS // 2:
        return Effort.even((n, scene.n_emitters), light_samples, gather_samples, rules.lookup)
    weight = scene.device.fetch(light.weight)
    brightness = np.einsum("ec,c->e", light.emission, weight)
    pilot = min(PILOT_LIGHT_SAMPLES, max(LEAST_LIGHT_SAMPLES, ALL_LIGHT_SAMPLES // max(scene.n_emitters, 1)))
    direct = direct_at_points(scene, position, normal, pilot, seed, response=response)
    arriving = direct.astype(np.float64) * brightness
    points = upload_points(scene, position, normal, response)
    other = arriving.sum(axis=1)
    place = scene, elements, light, position, normal
    guide = guides_that_pay(*place, other, gather_samples, replicates, rules=rules, seed=seed, response=response)
    paths = trace_paths(
        scene, elements, light, points, PILOT_PATHS, seed, rules, guide=guide.upload(scene.device), last_chance=True
    )
    _, sums = reflected_light(scene, paths, light)
    mean = sums[:, 0].astype(np.float64) / PILOT_PATHS
    variance = np.maximum(sums[:, 1].astype(np.float64) / PILOT_PATHS - mean**2, 0.0)
    total = other + mean
    total = np.maximum(total, DARK_SHARE * total.mean())
    worth = np.divide(total[:, None], brightness, out=np.full(direct.shape, np.inf), where=brightness > 0.0)
    variance_of_ray, seen = _partial(scene, position, normal, direct, pilot, worth, seed, response)
    penumbra = np.sqrt(variance_of_ray) * brightness
    relative = np.divide(1.0, total, out=np.zeros(n), where=total > 0.0)
    shadow_rays, n_paths = Split(gather_samples, light_samples).shared(
        STRATIFIED * penumbra * relative[:, None], np.sqrt(variance) * relative
    )
    return Effort(shadow_rays, seen > 0.5, n_paths, guide, np.full(n, rules.lookup))


def _partial(
    scene: DeviceScene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    direct: NDArray[np.float32],
    n_rays: int,
    worth: NDArray[np.float64],
    seed: int,
    response: NDArray[np.float32] | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Variance of one shadow ray's factor, F² v (1 − v) with F without obstacles, and the share v; (n, n_emitters).

    A lamp that the pilot's rays all missed may yet be seen by one ray in a hundred, which would be most of the light in
    a deep shadow; and few rays that all met it prove little. Lamps whose factor would be above `worth` are looked for
    by more rays, since what such a doubt calls for would be most of the rays of a dark room's readings.
    """
    samples = 1 if response is None else n_rays
    clear = direct_at_points(scene.without_occlusion(), position, normal, samples, seed, response=response)
    clear = clear.astype(np.float64)
    seen = np.divide(direct, clear, out=np.zeros_like(clear), where=clear > 0.0)
    rays = np.where((seen == 0.0) & (clear > worth), UNSEEN_AGAIN * n_rays, 0)
    some = np.flatnonzero(rays.any(axis=1))
    its_response = None if response is None else response[some]
    again = direct_at_points(
        scene, position[some], normal[some], np.maximum(rays[some], 1.0), seed + 1, response=its_response
    )
    seen[some] = np.where(rays[some] > 0, again / np.maximum(clear[some], np.finfo(np.float64).tiny), seen[some])
    doubt = UNSEEN_RAYS / (n_rays + rays)
    likely = np.clip(seen, doubt, 1.0 - doubt)
    variance: NDArray[np.float64] = clear**2 * likely * (1.0 - likely)
    return variance, seen


@dataclass(frozen=True)
class Split:
    """How paths and shadow rays of readings may be exchanged for one another at one price.

    gather, light : mean number of paths of a reading, and of its shadow rays to each emitter, as asked for
    """

    gather: int
    light: int

    def shared(
        self, penumbra: NDArray[np.float64], gather: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Shadow rays (n, n_emitters) and paths (n,) of each reading, n ∝ σ/√price, in steps of a factor 2.

        Parameters
        ----------
        penumbra : (n, n_emitters) float64
            Relative error of a reading by one shadow ray to an emitter.
        gather : (n,) float64
            The same by one path.
        """
        whole = len(gather) * self.gather + SHADOW_RAY * penumbra.size * self.light
        wanted = (penumbra / SHADOW_RAY**0.5, self.light, LEAST_LIGHT), (gather, self.gather, LEAST)
        low, high = 1e-12, 1e12
        for _ in range(BISECTIONS):
            middle = (low * high) ** 0.5
            light, paths = (_within(middle * some, even, least) for some, even, least in wanted)
            low, high = (middle, high) if paths.sum() + SHADOW_RAY * light.sum() <= whole else (low, middle)
        light, paths = (_within(low * some, even, least) for some, even, least in wanted)
        return light, np.rint(paths).astype(np.int64)


def stepped(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest powers of 2: readings that have one number of samples are read together."""
    nearest: NDArray[np.float64] = 2.0 ** np.rint(np.log2(times))
    return nearest


def _within(samples: NDArray[np.float64], even: int, least: float) -> NDArray[np.float64]:
    """Within bounds about an even share, in steps of a factor 2 from there."""
    share = np.clip(samples / max(even, 1), least, MOST)
    return _whole(np.maximum(stepped(share) * even, min(FEWEST, even)))


def _whole(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Whole numbers from 1 on, and probabilities below."""
    whole: NDArray[np.float64] = np.where(samples < 1.0, samples, np.rint(samples))
    return whole
