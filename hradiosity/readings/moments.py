"""What the replicates say of the readings: spectra and the numbers derived from them, each with its own interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import Estimate
from hradiosity.model.scene import Sensor
from hradiosity.model.spectrum import Bands
from hradiosity.readings.interval import RunningMean, RunningMoments, part_of
from hradiosity.readings.numbers import OF_SENSORS, ReadingNumbers
from hradiosity.solution import Readings

MESH_WEIGHT = 0.5
"""Share of the change by elements of twice the size that stands for what is left to change with smaller ones."""
UNSEEN_PATHS = 3.0
"""Paths that may lead to light, of all, when none of them was found to: at most 3/N with 95 % (Hanley 1983)."""


@dataclass(frozen=True)
class ReplicateReadings:
    """Readings of one replicate.

    spectra : (n, n_bands) float64 [W m⁻² per band]
    enclosed : (n,) float64, share of the view that ends inside a solid
    coarse_change : (n, n_bands) float64, what elements of twice the size would add; None where that is not known
    brightest_unseen : (n, n_bands) float64, most that a path could have brought over the number of paths, where light
        may come though no path found any; None for certain
    unlike : (n, n_bands) float64, for variants: see `hradiosity.plan.SpectralColumns.unlike`; None for the scene
    variants : the same of the scene's variants
    """

    spectra: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    coarse_change: NDArray[np.float64] | None = None
    brightest_unseen: NDArray[np.float64] | None = None
    unlike: NDArray[np.float64] | None = None
    variants: tuple[ReplicateReadings, ...] = ()


class ReplicateNumbers(NamedTuple):
    """The numbers of a replicate by name, and those with elements of twice the size, if these are known."""

    fine: dict[str, NDArray[np.float64]]
    coarse: dict[str, NDArray[np.float64]] | None


class ReadingMoments:
    """Running means and spreads of all readings of some sensors.

    Parameters
    ----------
    sensors : sequence of Sensor
    bands : Bands
    full : bool
        With the numbers that take longer, see `hradiosity.metrics.derived`.

    Attributes
    ----------
    position, normal : (n, 3) float64, of all sensors, one after another
    """

    def __init__(self, sensors: Sequence[Sensor], bands: Bands, *, full: bool = False) -> None:
        self.position = np.concatenate([np.zeros((0, 3)), *(s.position for s in sensors)])
        self.normal = np.concatenate([np.zeros((0, 3)), *(s.normal for s in sensors)])
        self._numbers = ReadingNumbers(sensors, bands, full=full)
        n = len(self.position)
        empty = self._numbers.of(np.zeros((n, len(bands))))
        self._values = {name: RunningMoments(array.shape) for name, array in empty.items()}
        self._changes = {name: RunningMean(array.shape) for name, array in empty.items()}
        self._enclosed = RunningMean((n,))
        self._unseen = RunningMean((n, len(bands)))

    @property
    def count(self) -> int:
        """Number of replicates."""
        return self._enclosed.count

    def add(self, replicate: ReplicateReadings) -> ReplicateNumbers:
        """Take one more replicate into account; returns its numbers."""
        numbers, coarse = self._numbers.of(replicate.spectra), None
        for name, value in numbers.items():
            self._values[name].add(value)
        if replicate.coarse_change is not None:
            coarse = self._numbers.of(replicate.spectra + replicate.coarse_change)
            for name, value in numbers.items():
                self._changes[name].add(coarse[name] - value)
        self._enclosed.add(replicate.enclosed)
        unseen = replicate.brightest_unseen
        self._unseen.add(np.zeros_like(replicate.spectra) if unseen is None else unseen)
        return ReplicateNumbers(numbers, coarse)

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
        return np.concatenate([np.zeros(0), *(r.accuracy for r in self.readings(relative).values())])

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
            **{f"change/{name}": moments for name, moments in self._changes.items()},
            "enclosed": self._enclosed,
            "unseen": self._unseen,
        }

    def _estimates(self, relative: Mapping[str, float], illuminance_only: bool) -> dict[str, Estimate]:
        """Every number of all readings and sensors. Numbers that are no powers are those of the mean spectrum."""
        spectra = self._values["irradiance"].mean
        numbers = self._numbers.illuminances(spectra) if illuminance_only else self._numbers.of(spectra)
        effects = {part: self._numbers.effect_of(spectra, numbers, share) for part, share in relative.items()}
        count = self.count
        estimates = {}
        for name, value in numbers.items():
            others = {part: effect[name] for part, effect in effects.items()}
            if self._changes[name].count:
                others = {"mesh": MESH_WEIGHT * np.abs(self._changes[name].mean)} | others
            estimates[name] = Estimate(value, self._values[name].standard_error, count - 1, others)
        return self._with_unseen(estimates)

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
                {**estimate.others, "unseen": missed},
            )
        return estimates

    def _readings(self, index: int, name: str, estimates: Mapping[str, Estimate]) -> Readings:
        part = self._numbers.parts[name]
        return Readings(
            sensor=name,
            position=self.position[part],
            normal=self.normal[part],
            enclosed=self._enclosed.mean[part],
            numbers={
                key: estimate[index] if key in OF_SENSORS else estimate[part] for key, estimate in estimates.items()
            },
        )
