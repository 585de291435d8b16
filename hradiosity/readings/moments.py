"""What the replicates say of the readings: spectra and the numbers derived from them, each with its own interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import MESH, UNSEEN, Estimate
from hradiosity.model.scene import Scene, Sensor
from hradiosity.model.spectrum import Bands
from hradiosity.readings.companions import COMPANIONS, companion_parts, likely_parts
from hradiosity.readings.composition import Composition
from hradiosity.readings.interval import RunningMean, RunningMoments, part_of
from hradiosity.readings.numbers import OF_SENSORS, ReadingNumbers, is_power
from hradiosity.readings.pooling import alike, pooled
from hradiosity.solution import Readings

UNSEEN_PATHS = 3.0
"""Paths that may lead to light, of all, when none of them was found to: at most 3/N with 95 % (Hanley 1983)."""


@dataclass(frozen=True)
class ReplicateReadings:
    """Light of one replicate on the planes that readings are made of.

    spectra : (n, n_bands) float64 [W m⁻² per band]
    enclosed : (n,) float64, share of the view that ends inside a solid
    change : (n, n_bands) float64, what a companion with coarser settings would add; None without one
    changed_by : part of the intervals that the change tells about, see `hradiosity.readings.companions`
    brightest_unseen : (n, n_bands) float64, most that a path could have brought over the number of paths, where light
        may come though no path found any; None for certain
    unlike : (n, n_bands) float64, for variants: see `hradiosity.plan.SpectralColumns.unlike`; None for the scene
    variants : the same of the scene's variants
    """

    spectra: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    change: NDArray[np.float64] | None = None
    changed_by: str = MESH
    brightest_unseen: NDArray[np.float64] | None = None
    unlike: NDArray[np.float64] | None = None
    variants: tuple[ReplicateReadings, ...] = ()


class ReplicateNumbers(NamedTuple):
    """The numbers of a replicate by name, and those of its companion with coarser settings, if it has one."""

    fine: dict[str, NDArray[np.float64]]
    coarse: dict[str, NDArray[np.float64]] | None
    changed_by: str


class ReadingMoments:
    """Running means and spreads of all readings of some sensors.

    Parameters
    ----------
    sensors : sequence of Sensor
    bands : Bands
    full : bool
        With the numbers that take longer, see `hradiosity.metrics.derived`.
    scene : Scene, optional
        That luminance sensors look at, and whose action spectra weigh light.
    illuminance_only : bool
        Without all numbers but spectra and illuminances: what tells how accurate readings are.

    Attributes
    ----------
    planes : of all sensors, one after another
    times : (n,) float64, samples of each reading over those of one go; None for one go each
    """

    def __init__(
        self,
        sensors: Sequence[Sensor],
        bands: Bands,
        *,
        full: bool = False,
        scene: Scene | None = None,
        illuminance_only: bool = False,
    ) -> None:
        self.planes = Composition(sensors, scene)
        self.times: NDArray[np.float64] | None = None
        self._sensors = tuple(sensors)
        self._numbers = ReadingNumbers(
            sensors,
            bands,
            full=full,
            actions=() if scene is None else scene.actions,
            illuminance_only=illuminance_only,
        )
        n = len(self.planes.count)
        empty = self._numbers.of(np.zeros((n, len(bands))))
        self._values = {name: RunningMoments(array.shape) for name, array in empty.items()}
        self._changes = {
            part: {name: RunningMoments(array.shape) for name, array in empty.items()} for part in COMPANIONS
        }
        self._shares = RunningMoments((n,))
        self._enclosed = RunningMean((n,))
        self._unseen = RunningMean((n, len(bands)))

    @property
    def position(self) -> NDArray[np.float64]:
        """(n_planes, 3) [m]."""
        return self.planes.position

    @property
    def normal(self) -> NDArray[np.float64]:
        """(n_planes, 3) unit."""
        return self.planes.normal

    @property
    def count(self) -> int:
        """Number of replicates."""
        return self._enclosed.count

    def add(self, replicate: ReplicateReadings) -> ReplicateNumbers:
        """Take one more replicate into account; returns its numbers."""
        spectra = self.planes.readings(replicate.spectra)
        numbers, coarse = self._numbers.of(spectra), None
        for name, value in numbers.items():
            self._values[name].add(value)
        self._shares.add(self._numbers.shares_of_mean(numbers["illuminance"], numbers["mean_illuminance"]))
        if replicate.change is not None:
            coarse = self._numbers.of(spectra + self.planes.changes(replicate.change))
            for name, value in numbers.items():
                self._changes[replicate.changed_by][name].add(coarse[name] - value)
        self._enclosed.add(self.planes.mean(replicate.enclosed))
        unseen = replicate.brightest_unseen
        self._unseen.add(np.zeros_like(spectra) if unseen is None else self.planes.changes(unseen))
        return ReplicateNumbers(numbers, coarse, replicate.changed_by)

    def readings(
        self, relative: Mapping[str, float] | None = None, *, illuminance_only: bool = False
    ) -> dict[str, Readings]:
        """Means so far and their intervals, by sensor name.

        Parameters
        ----------
        relative : mapping, optional
            By part of the intervals: share of each band that all replicates may be off by alike.
        illuminance_only : bool
            Leave all other numbers out, which takes far less time.
        """
        estimates = self._estimates(relative or {}, illuminance_only)
        return {name: self._readings(index, name, estimates) for index, name in enumerate(self._numbers.parts)}

    def errors(self, relative: Mapping[str, float] | None = None) -> NDArray[np.float64]:
        """(n,) accuracy of every reading, see `Readings.accuracy`; empty before two replicates."""
        if self.count < 2:
            return np.zeros(0)
        return np.concatenate(
            [np.zeros(0), *(r.accuracy for r in self.readings(relative, illuminance_only=True).values())]
        )

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """Everything that `restore` needs."""
        return {
            f"{name}/{key}": array for name, kept in self._all().items() for key, array in kept.checkpoint().items()
        }

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it is of other sensors or bands.
        """
        for name, moments in self._all().items():
            moments.restore(part_of(kept, name))

    def _all(self) -> dict[str, RunningMean]:
        return {
            **{f"value/{name}": moments for name, moments in self._values.items()},
            **{f"{part}/{name}": kept for part, means in self._changes.items() for name, kept in means.items()},
            "shares": self._shares,
            "enclosed": self._enclosed,
            "unseen": self._unseen,
        }

    def _estimates(self, relative: Mapping[str, float], illuminance_only: bool) -> dict[str, Estimate]:
        """Every number of all readings and sensors. Numbers that are no powers are those of the mean spectrum."""
        spectra = self._values["irradiance"].mean
        numbers = self._numbers.illuminances(spectra) if illuminance_only else self._numbers.of(spectra)
        effects = {part: self._numbers.effect_of(spectra, numbers, share) for part, share in relative.items()}
        count = self.count
        group = alike(list(self._numbers.parts.values()), numbers["illuminance"], self.times)
        estimates = {}
        for name, value in numbers.items():
            changes = {part: means[name] for part, means in self._changes.items()}
            error = self._values[name].standard_error
            if name in OF_SENSORS:
                others = companion_parts(changes)
            else:
                error = pooled(error, value, group, count - 1, relative=is_power(name))
                others = likely_parts(changes, value, group, relative=is_power(name))
            others |= {part: effect[name] for part, effect in effects.items()}
            estimates[name] = Estimate(value, error, count - 1, others)
        return self._with_unseen(self._with_extremes(estimates))

    def _with_extremes(self, estimates: dict[str, Estimate]) -> dict[str, Estimate]:
        """Extremes and their ratios with the spread of the readings that are lowest and highest in the mean.

        The lowest of each replicate is another reading every time, and varies less than any of them.
        """
        mean, error, parts = self._shares.mean, self._shares.standard_error, self._numbers.parts.values()
        lowest = np.array([part.start + int(np.argmin(mean[part])) for part in parts], np.int64)
        highest = np.array([part.start + int(np.argmax(mean[part])) for part in parts], np.int64)
        lux = estimates["illuminance"].standard_error
        top = mean[highest]
        apart = np.hypot(
            error[lowest], error[highest] * np.divide(mean[lowest], top, out=np.zeros_like(top), where=top > 0)
        )
        ratio = np.divide(apart, top, out=np.zeros_like(top), where=top > 0.0)
        errors = {
            "lowest_illuminance": lux[lowest],
            "highest_illuminance": lux[highest],
            "uniformity": error[lowest],
            "diversity": np.where(lowest == highest, 0.0, ratio),
        }
        return estimates | {name: replace(estimates[name], standard_error=some) for name, some in errors.items()}

    def _with_unseen(self, estimates: dict[str, Estimate]) -> dict[str, Estimate]:
        """The same with the light that readings may have though no path found any."""
        bound = UNSEEN_PATHS * self._unseen.mean / max(self.count, 1)
        if not bound.any():
            return estimates
        numbers = {"irradiance": bound} | self._numbers.illuminances(bound)
        for name in estimates.keys() & {"irradiance", "illuminance"}:
            estimate = estimates[name]
            missed = np.where(estimate.value == 0.0, numbers[name], 0.0)
            estimates[name] = Estimate(
                estimate.value,
                estimate.standard_error,
                estimate.degrees_of_freedom,
                {**estimate.others, UNSEEN: missed},
            )
        return estimates

    def _readings(self, index: int, name: str, estimates: Mapping[str, Estimate]) -> Readings:
        part, sensor = self._numbers.parts[name], self._sensors[index]
        return Readings(
            sensor=name,
            position=sensor.place,
            normal=sensor.direction,
            enclosed=self._enclosed.mean[part],
            numbers={
                key: estimate[index] if key in OF_SENSORS else estimate[part] for key, estimate in estimates.items()
            },
            kind=sensor.kind,
        )
