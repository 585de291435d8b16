"""What variants of a scene change: differences in every replicate, so that what both have in common cancels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import UNSEEN, Estimate
from hradiosity.model.scene import Scene
from hradiosity.model.variants import with_variant
from hradiosity.plan import SpectralColumns
from hradiosity.readings.companions import COMPANIONS, companion_parts
from hradiosity.readings.interval import RunningMean, RunningMoments
from hradiosity.readings.moments import ReadingMoments, ReplicateNumbers, ReplicateReadings
from hradiosity.readings.numbers import OF_SENSORS, RATIOS, ReadingNumbers, is_power
from hradiosity.readings.sensors import ReadingSamples
from hradiosity.solution import Differences, VariantReadings

Numbers = Mapping[str, NDArray[np.float64]]
_OF_SENSORS = (*OF_SENSORS, "relative_mean_illuminance")


class VariantMoments(ReadingMoments):
    """Running means and spreads of all readings of a scene, of its variants, and of their differences from the scene.

    Parameters
    ----------
    scene : Scene
        Replicates that are added hold readings of each of its variants.
    full : bool
        See `ReadingMoments`.
    """

    def __init__(self, scene: Scene, *, full: bool = False) -> None:
        sensors, bands, variants = scene.sensors, scene.bands, scene.variants
        super().__init__(sensors, bands, full=full, scene=scene)
        self._names = tuple(variant.name for variant in variants)
        self._variants = [
            ReadingMoments(sensors, bands, full=full, scene=with_variant(scene, variant)) for variant in variants
        ]
        self._differences = [_DifferenceMoments(self._numbers, len(self.planes.count), len(bands)) for _ in variants]

    def taken(self, times: NDArray[np.float64]) -> None:
        """Say how many samples each reading has had, see `ReadingMoments.times`."""
        for moments in (self, *self._variants):
            moments.times = times

    def add(self, replicate: ReplicateReadings) -> ReplicateNumbers:
        """Take one more replicate into account; returns the scene's own numbers."""
        own = super().add(replicate)
        for moments, differences, other in zip(self._variants, self._differences, replicate.variants, strict=True):
            unlike = None if other.unlike is None else self.planes.changes(other.unlike)
            differences.add(own, moments.add(other), unlike)
        return own

    def variants(self, relative: Mapping[str, float] | None = None) -> dict[str, VariantReadings]:
        """Means so far and their intervals, by variant; `relative` as for `readings`."""
        shares = relative or {}
        of_scene = self._estimates(shares, illuminance_only=False)
        out = {}
        for name, moments, differences in zip(self._names, self._variants, self._differences, strict=True):
            of_variant = moments._estimates(shares, illuminance_only=False)
            changes = differences.estimates(of_scene, of_variant, shares)
            out[name] = VariantReadings(
                {
                    sensor: moments._readings(index, sensor, of_variant)
                    for index, sensor in enumerate(self._numbers.parts)
                },
                {
                    sensor: self._of_sensor(index, sensor, name, changes)
                    for index, sensor in enumerate(self._numbers.parts)
                },
            )
        return out

    def _of_sensor(self, index: int, sensor: str, variant: str, changes: Mapping[str, Estimate]) -> Differences:
        part, places = self._numbers.parts[sensor], self._sensors[index]
        return Differences(
            sensor=sensor,
            variant=variant,
            position=places.place,
            normal=places.direction,
            numbers={key: found[index] if key in _OF_SENSORS else found[part] for key, found in changes.items()},
        )

    def _all(self) -> dict[str, RunningMean]:
        kept = super()._all()
        for number, (moments, differences) in enumerate(zip(self._variants, self._differences, strict=True)):
            kept |= {f"variant/{number}/{name}": some for name, some in moments._all().items()}
            kept |= {f"difference/{number}/{name}": some for name, some in differences.all().items()}
        return kept


def replicate_readings(
    columns: SpectralColumns, samples: ReadingSamples, unseen: NDArray[np.float64] | None
) -> ReplicateReadings:
    """Columns of a replicate as spectra of the scene and of its variants; `unseen`: see `ReplicateReadings`."""

    def spectra(of: SpectralColumns) -> ReplicateReadings:
        return ReplicateReadings(
            of.to_bands(samples.irradiance),
            samples.enclosed,
            None if samples.change is None else of.to_bands(samples.change),
            samples.changed_by,
            None if unseen is None else of.to_bands(unseen),
        )

    variants = tuple(
        replace(spectra(columns.of_variant(number)), unlike=columns.unlike(number).to_bands(samples.irradiance))
        for number in range(len(columns.variants))
    )
    return replace(spectra(columns), variants=variants)


class _DifferenceMoments:
    """Running means and spreads of the differences of one variant's numbers from the scene's.

    What all replicates have in common is bounded for differences too. Elements of twice the size change the scene and
    the variant alike, and half of the difference of these changes stands for what smaller ones would change. Errors of
    the iteration, of combined columns and of rounding are shares of a column's light; those of columns that scene and
    variant share cancel as far as they share them, others add up (`SpectralColumns.unlike`).
    """

    def __init__(self, numbers: ReadingNumbers, n_readings: int, n_bands: int) -> None:
        self._numbers = numbers
        empty = numbers.of(np.zeros((n_readings, n_bands)))
        zeros = _changes(empty, empty)
        self._values = {name: RunningMoments(array.shape) for name, array in zeros.items()}
        self._companions = {
            part: {name: RunningMean(array.shape) for name, array in zeros.items()} for part in COMPANIONS
        }
        self._unlike = RunningMean((n_readings, n_bands))

    def add(self, own: ReplicateNumbers, other: ReplicateNumbers, unlike: NDArray[np.float64] | None) -> None:
        """Take one more replicate into account."""
        fine = _changes(own.fine, other.fine)
        for name, value in fine.items():
            self._values[name].add(value)
        if own.coarse is not None and other.coarse is not None:
            for name, value in _changes(own.coarse, other.coarse).items():
                self._companions[own.changed_by][name].add(value - fine[name])
        if unlike is not None:
            self._unlike.add(unlike)

    def all(self) -> dict[str, RunningMean]:
        """Everything that a checkpoint holds, by name."""
        return {
            **{f"value/{name}": moments for name, moments in self._values.items()},
            **{f"{part}/{name}": kept for part, means in self._companions.items() for name, kept in means.items()},
            "unlike": self._unlike,
        }

    def estimates(
        self, scene: Mapping[str, Estimate], variant: Mapping[str, Estimate], relative: Mapping[str, float]
    ) -> dict[str, Estimate]:
        """Differences of all numbers: those of the mean spectra, with the spread of those of the replicates."""
        own, other = ({name: found.value for name, found in some.items()} for some in (scene, variant))
        values = _changes(own, other)
        effects = {part: self._effect(own, other, values, share) for part, share in relative.items()}
        out = {}
        for name, value in values.items():
            others = {part: effect[name] for part, effect in effects.items()}
            others = companion_parts({part: means[name] for part, means in self._companions.items()}) | others
            unseen = [found[name].others[UNSEEN] for found in (scene, variant) if UNSEEN in _parts(found, name)]
            if unseen:
                others[UNSEEN] = np.sum(unseen, axis=0)
            count = self._values[name].count
            out[name] = Estimate(value, self._values[name].standard_error, count - 1, others)
        return out

    def _effect(self, own: Numbers, other: Numbers, values: Numbers, share: float) -> dict[str, NDArray[np.float64]]:
        """How far each difference may be off when every column may be off by a share of itself, see `unlike`.

        As in `ReadingNumbers.effect_of`, as if the variant's spectra alone were off.
        """
        unlike, spectra = self._unlike.mean, other["irradiance"]
        bound = self._numbers.of(unlike)
        tilted = self._numbers.of(spectra + share * unlike * self._numbers.tilt)
        effect = {
            name: share * bound[name] if is_power(name) else np.abs(tilted[name] - value)
            for name, value in other.items()
        }
        off = _over(bound["illuminance"], other["illuminance"])
        worst = [np.nan_to_num(off[part]).max(initial=0.0) for part in self._numbers.parts.values()]
        effect |= {name: 2.0 * share * np.array(worst) * other[name] for name in RATIOS}
        for name in ("illuminance", "mean_illuminance"):
            effect[f"relative_{name}"] = _over(share * (bound[name] + np.abs(values[name])), own[name])
        return effect


def _changes(own: Numbers, other: Numbers) -> dict[str, NDArray[np.float64]]:
    """Differences of all numbers, those of the illuminances also over the scene's own."""
    changes = {name: other[name] - value for name, value in own.items()}
    for name in ("illuminance", "mean_illuminance"):
        changes[f"relative_{name}"] = _over(changes[name], own[name])
    return changes


def _over(change: NDArray[np.float64], base: NDArray[np.float64]) -> NDArray[np.float64]:
    """The quotient; NaN where there is nothing to divide by."""
    quotient: NDArray[np.float64] = np.divide(change, base, out=np.full_like(base, np.nan), where=base > 0.0)
    return quotient


def _parts(estimates: Mapping[str, Estimate], name: str) -> Mapping[str, NDArray[np.float64]]:
    return estimates[name].others if name in estimates else {}
