"""Readings of a run: of all points in each replicate, and again of those that are not sure enough."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene, Sensor
from hradiosity.options import Options
from hradiosity.plan import Plan, SpectralColumns
from hradiosity.planning_memory import KEPT_SAMPLE_BYTES
from hradiosity.radiosity.accuracies import Accuracies
from hradiosity.radiosity.budget import Step
from hradiosity.radiosity.remedy import Held
from hradiosity.readings.differences import VariantMoments, replicate_readings
from hradiosity.readings.effort import Effort, plan_effort, stepped
from hradiosity.readings.gathered import Gathered
from hradiosity.readings.interval import part_of
from hradiosity.readings.later_lookups import TRIED_PATHS, TriedLookups, some_of, try_lookups
from hradiosity.readings.moments import ReadingMoments
from hradiosity.readings.path_tracing import PathRules, upload_points
from hradiosity.readings.sensors import ReadingSamples, read_points
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.readings.twins import CommonNoise, proved_variance, twin_points
from hradiosity.readings.unseen import brightest_unseen
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

NEAR_FACTOR, FIRST_NEAR_FACTOR = 0.5, 3.0
"""The solution is never looked up at a hit nearer than so many sizes of its element; the second is for first hits."""
_EFFORT_SEED, _READING_SEED, _TWIN_SEED, _TRIAL_SEED = 0x3C6EF372, 0x5BD1E995, 0x2545F491, 0x1B873593


@dataclass(frozen=True)
class ReplicateLight:
    """What readings of one replicate are taken from.

    scene, elements, light : on the device
    plan : of the run
    seed : of the replicate
    """

    scene: DeviceScene
    elements: DeviceElements
    light: SurfaceLight
    plan: Plan
    seed: int


@dataclass(frozen=True)
class Share:
    """What some points are read with.

    chosen : (m,) int64, the points
    times : (m,) float64, samples over those that are planned for one go
    lookup : (m,) int64, first hit at which paths may look the solution up
    anew : (m,) bool, whether earlier goes do not count any more
    """

    chosen: NDArray[np.int64]
    times: NDArray[np.float64]
    lookup: NDArray[np.int64]
    anew: NDArray[np.bool_]


class PointReader:
    """Reads the sensors of a scene, replicate by replicate.

    Parameters
    ----------
    scene : Scene
    options : Options

    Attributes
    ----------
    effort : samples of each point in one go of a replicate; None before the first
    """

    def __init__(self, scene: Scene, options: Options) -> None:
        self.effort: Effort | None = None
        self._scene, self._options = scene, options
        self._moments = VariantMoments(scene, full=options.full_metrics)
        self._gathered: list[Gathered] = []
        self._stale = False
        self._columns: SpectralColumns | None = None
        n = len(self._moments.position)
        self._lookup = np.full(n, options.lookup, np.int64)
        self._tried = TriedLookups.none(options.lookup, n)
        self._twins = twin_points(n)
        self._pairs = np.zeros((0, 2, len(self._twins)))
        self._again: list[NDArray[np.float64]] = []
        self._noise = CommonNoise()
        self._point_noise = np.zeros(n)
        self._steps = np.zeros(n, np.int64)
        self._one_go = np.zeros(len(self._moments.planes.count))

    @property
    def moments(self) -> VariantMoments:
        """What all replicates say so far."""
        if self._stale and self._columns is not None:
            self._moments = VariantMoments(self._scene, full=self._options.full_metrics)
            for some in self._gathered:
                self._moments.add(replicate_readings(self._columns, some.samples, some.unseen))
            self._moments.taken(self._moments.planes.mean(self._gathered[-1].times))
            self._stale = False
        return self._moments

    @property
    def illuminances(self) -> ReadingMoments:
        """The same of the illuminances alone, which takes far less time after further samples."""
        if not self._stale or self._columns is None:
            return self._moments
        own = replace(self._columns, variants=())
        moments = ReadingMoments(self._scene.sensors, self._scene.bands, scene=self._scene, illuminance_only=True)
        for some in self._gathered:
            moments.add(replicate_readings(own, some.samples, some.unseen))
        moments.times = moments.planes.mean(self._gathered[-1].times)
        return moments

    @property
    def count(self) -> int:
        """Replicates that there are readings of."""
        return self._moments.count if not self._gathered else len(self._gathered)

    @property
    def reads_again(self) -> bool:
        """Whether the samples of all replicates are kept."""
        return len(self._gathered) == self.count

    @property
    def noise(self) -> CommonNoise:
        """Of the elements, as far as points that were read twice tell."""
        return self._noise.surer(CommonNoise.of(self._pairs[:, 0], self._pairs[:, 1]))

    def proved_noise(self) -> NDArray[np.float64]:
        """(n_readings,) variance of a replicate, over the square of the mean, that surely comes from the elements."""
        of_all = self.noise.proved / self._tried.lookups.gain_at(self._lookup) ** 2
        of_points = np.maximum(self._point_noise, of_all)
        return self._moments.planes.mean(of_points)

    def held(self, found: Accuracies | None = None, elements: int = 0, edge: float = 0.0) -> Held:
        """What the readings have had in each replicate, all of them or all but those of a step.

        Parameters
        ----------
        found : Accuracies, optional
            Of the readings as they are, which tells what samples are worth.
        elements, edge : int, float
            That there are, and their edge [m].
        """
        planes = self._moments.planes
        n = len(planes.count)
        first = np.cumsum(planes.count) - planes.count
        times = self._gathered[-1].times[first] if self._gathered else np.ones(n)
        paths = np.zeros(n) if self.effort is None else planes.total(self.effort.gather).astype(np.float64)
        steps = self._steps[first]
        one_go = self._one_go
        if found is not None:
            one_go = np.where(steps == 0, found.own**2 * times, one_go)
        lookups = self._tried.lookups.some(first)
        return Held(paths, times, self._lookup[first], steps, one_go, lookups, elements, edge)

    def try_lookups(self, readings: NDArray[np.bool_], on: ReplicateLight) -> int:
        """Find out what later lookups would do to some of the readings (n_readings,); returns the number of rays."""
        planes = self._moments.planes
        first = (np.cumsum(planes.count) - planes.count)[readings]
        if self.effort is None:
            return 0
        chosen = some_of(first[~self._tried.known[first] & (self.effort.gather[first] > 0)])
        if not len(chosen):
            return 0
        moments, response = self._moments, planes.response
        points = upload_points(
            on.scene,
            moments.position[chosen],
            moments.normal[chosen],
            None if response is None else response[chosen],
        )
        guides = self.effort.guide.some(chosen)
        found = try_lookups(on.scene, on.elements, on.light, points, guides, self.rules, on.seed ^ _TRIAL_SEED)
        self._tried = self._tried.with_more(chosen, found)
        return int(TRIED_PATHS * len(chosen) * (2 * found.hits - 1).sum())

    def learn(self, held: Held) -> None:
        """Remember what samples are worth, as it was found before the first step of each reading."""
        self._one_go = held.one_go

    def share(self, step: Step) -> Share:
        """What single planes are read with in a step."""
        spread = self._moments.planes.spread
        times = spread(step.times)
        chosen = np.flatnonzero(times > 0.0)
        anew = spread(step.anew.astype(np.int64))[chosen] > 0
        return Share(chosen, times[chosen], spread(step.lookup)[chosen], anew)

    def all_points(self, on: ReplicateLight) -> int:
        """Read all points in a further replicate; returns the number of rays."""
        moments = self.moments
        if self.effort is None:
            self.effort = self._plan_effort(moments, on)
        self._columns = on.plan.columns
        everywhere = np.arange(len(moments.position))
        samples = self._samples(moments, everywhere, self.effort, on, on.seed ^ _READING_SEED)
        unseen = _unseen(moments, samples, self.effort, on)
        moments.add(replicate_readings(self._columns, samples, unseen))
        gathered = Gathered(samples, np.ones(len(everywhere)), unseen)
        kept = len(self._gathered) == moments.count - 1 and moments.count * gathered.nbytes <= KEPT_SAMPLE_BYTES
        self._gathered = [*self._gathered, gathered] if kept else []
        if self._options.accuracy is None:
            return self.effort.rays
        twin_effort = self.effort.some(self._twins)
        second = self._samples(moments, self._twins, twin_effort, on, on.seed ^ _TWIN_SEED)
        pair = [_brightness(some, on) for some in (samples.irradiance[self._twins], second.irradiance)]
        self._pairs = np.concatenate([self._pairs, np.stack(pair)[None]])
        return self.effort.rays + twin_effort.rays

    def some_points(self, replicate: int, share: Share, on: ReplicateLight, go: int) -> int:
        """Read some points of a replicate again; returns the number of rays.

        Parameters
        ----------
        replicate : int
            Its number, from 0.
        go : int
            Number of this go in the run: no two have the same rays.

        Raises
        ------
        RuntimeError
            Before all points were read in that replicate.
        """
        if self.effort is None or replicate >= len(self._gathered):
            raise RuntimeError(f"replicate {replicate} was not read yet")
        chosen, times = share.chosen, stepped(share.times)
        effort = self.effort.some(chosen).focused(times).looking(share.lookup)
        seed = int(np.random.SeedSequence((on.seed, go)).generate_state(1)[0])
        more = self._samples(self._moments, chosen, effort, on, seed)
        before = self._gathered[replicate]
        self._compare(replicate, before.samples.irradiance[chosen], more.irradiance, on, share)
        after = before.with_more(chosen, more, times, share.anew)
        unseen = _unseen(self._moments, after.samples, self.effort.of_goes(after.times), on)
        self._gathered[replicate] = replace(after, unseen=unseen)
        self._lookup[chosen] = share.lookup
        self._columns, self._stale = on.plan.columns, True
        return effort.rays

    def _compare(
        self,
        replicate: int,
        before: NDArray[np.float64],
        more: NDArray[np.float64],
        on: ReplicateLight,
        share: Share,
    ) -> None:
        """Find out what goes have in common: the noise of the elements. The first replicate starts, the last ends."""
        pair = np.stack([_brightness(some, on) for some in (before, more)])
        self._again = [pair] if replicate == 0 else [*self._again, pair]
        if replicate == len(self._gathered) - 1:
            first, second = np.moveaxis(np.stack(self._again), 1, 0)
            same = ~share.anew
            early = same & (share.lookup == self._options.lookup)
            self._noise = CommonNoise.of(first[:, early], second[:, early]).surer(self._noise)
            self._point_noise[share.chosen] = np.where(same, proved_variance(first, second), 0.0)
            self._again = []
            self._steps[share.chosen] = np.where(same, self._steps[share.chosen] + 1, 0)

    def forget_noise(self) -> None:
        """The elements are about to be others."""
        self._noise, self._again, self._pairs = CommonNoise(), [], self._pairs[:0]
        self._point_noise = np.zeros_like(self._point_noise)

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs; the arrays do not change when the run goes on."""
        kept: dict[str, NDArray[Any]] = {
            "lookup": self._lookup.copy(),
            "pairs": self._pairs,
            "point_noise": self._point_noise.copy(),
            "steps": self._steps.copy(),
            "one_go": self._one_go,
            "noise": np.array([self._noise.variance, self._noise.uncertainty]),
        }
        if self.effort is not None:
            kept |= {f"effort/{name}": array for name, array in self.effort.arrays.items()}
        kept |= {f"tried/{name}": array for name, array in self._tried.arrays.items()}
        if self._again:
            kept["again"] = np.stack(self._again)
        for number, some in enumerate(self._gathered):
            kept |= {f"gathered/{number}/{name}": array for name, array in some.checkpoint().items()}
        if not self._gathered:
            kept |= {f"moments/{name}": array for name, array in self._moments.checkpoint().items()}
        return kept

    def restore(self, kept: Mapping[str, NDArray[Any]], columns: SpectralColumns) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it is of other sensors or bands.
        """
        if kept["lookup"].shape != self._lookup.shape:
            raise ValueError(f"{len(self._lookup)} planes are read, the checkpoint has {len(kept['lookup'])}")
        effort = part_of(kept, "effort")
        self.effort = Effort.of_arrays(effort) if effort else None
        self._lookup, self._pairs = kept["lookup"].astype(np.int64), kept["pairs"]
        self._tried = TriedLookups.of_arrays(part_of(kept, "tried"))
        self._noise = CommonNoise(*(float(number) for number in kept["noise"]))
        self._point_noise, self._steps = kept["point_noise"].copy(), kept["steps"].astype(np.int64)
        self._one_go = kept["one_go"]
        self._again = list(kept["again"]) if "again" in kept else []
        gathered = part_of(kept, "gathered")
        count = len({name.partition("/")[0] for name in gathered})
        self._gathered = [Gathered.restored(part_of(gathered, str(number))) for number in range(count)]
        self._columns, self._stale = columns, True
        if not self._gathered:
            self._stale = False
            self._moments.restore(part_of(kept, "moments"))

    def further(self, sensor: Sensor, lights: list[ReplicateLight]) -> ReadingMoments:
        """What the light of some replicates says of a further sensor."""
        moments = ReadingMoments((sensor,), self._scene.bands, full=self._options.full_metrics, scene=self._scene)
        everywhere = np.arange(len(moments.position))
        effort = self._plan_effort(moments, lights[0])
        for on in lights:
            samples = self._samples(moments, everywhere, effort, on, on.seed ^ _READING_SEED)
            moments.add(replicate_readings(on.plan.columns, samples, _unseen(moments, samples, effort, on)))
        return moments

    def _plan_effort(self, moments: ReadingMoments, on: ReplicateLight) -> Effort:
        """Samples of each point in one go of a replicate."""
        plan = on.plan
        effort = plan_effort(
            on.scene,
            on.elements,
            on.light,
            moments.position,
            moments.normal,
            light_samples=plan.light_samples,
            gather_samples=plan.gather_samples if plan.gathers or self._scene.sky is not None else 0,
            replicates=self._options.replicates if self._options.accuracy is None else np.inf,
            rules=self.rules,
            seed=on.seed ^ _EFFORT_SEED,
            response=moments.planes.response,
        )
        share = moments.planes.share
        return effort if (share == 1.0).all() else effort.focused(share)

    def _samples(
        self, moments: ReadingMoments, chosen: NDArray[np.int64], effort: Effort, on: ReplicateLight, seed: int
    ) -> ReadingSamples:
        """Light at some of the points, with an effort for each of them."""
        response = moments.planes.response
        return read_points(
            on.scene,
            on.elements,
            on.light,
            moments.position[chosen],
            moments.normal[chosen],
            effort,
            response=None if response is None else response[chosen],
            rules=self.rules,
            seed=seed,
        )

    @property
    def rules(self) -> PathRules:
        """Where paths end."""
        return PathRules(self._options.lookup, NEAR_FACTOR, FIRST_NEAR_FACTOR)


def _unseen(
    moments: ReadingMoments, samples: ReadingSamples, effort: Effort, on: ReplicateLight
) -> NDArray[np.float64] | None:
    """Light that points may have though their samples found none."""
    return brightest_unseen(
        on.scene,
        on.light,
        moments.position,
        moments.normal,
        samples,
        light_samples=effort.light,
        gather_samples=effort.gather,
    )


def _brightness(irradiance: NDArray[np.float64], on: ReplicateLight) -> NDArray[np.float64]:
    """(n,) brightness of columns of light (n, n_columns)."""
    weight = on.scene.device.fetch(on.light.weight)[: irradiance.shape[1]].astype(np.float64)
    return np.asarray(np.einsum("xc,c->x", irradiance, weight))
