"""From runs and reference to prices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import student_quantile
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Readings
from hradiosity.suites.compare import counted_bands
from hradiosity.suites.cost.errors import error_of
from hradiosity.suites.cost.pareto import pareto_front
from hradiosity.suites.cost.values import BandsPrice, EffectPrice, Price, Run

Found = Mapping[str, Readings]


@dataclass(frozen=True)
class Truth:
    """A reference, ready to be compared with.

    names : of the sensors, in order
    illuminance : (n_lit,) float64 [lx]
    spectra : (n_counted,) float64 [W m⁻² per band], of readings and bands that have light
    lit : (n,) bool, readings with light
    counted : (n, n_bands) bool
    noise, spectral_noise : standard error over value, root mean square
    """

    names: tuple[str, ...]
    illuminance: NDArray[np.float64]
    spectra: NDArray[np.float64]
    lit: NDArray[np.bool_]
    counted: NDArray[np.bool_]
    noise: float
    spectral_noise: float

    @classmethod
    def of(cls, reference: Found) -> Truth:
        """From the referee's readings.

        Raises
        ------
        ValueError
            When there is no light in it.
        """
        names = tuple(reference)
        lux, spectra = _joined(reference, names, "illuminance"), _joined(reference, names, "irradiance")
        quantile = student_quantile(0.95, SCRAMBLES - 1)
        lux_error = _joined(reference, names, "illuminance_half_width") / quantile
        error = _joined(reference, names, "half_width") / quantile
        lit = lux > 0.0
        counted = (spectra > 0.0) & counted_bands(spectra)[None, :]
        if not lit.any() or not counted.any():
            raise ValueError("there is no light in the reference")
        return cls(
            names=names,
            illuminance=lux[lit],
            spectra=spectra[counted],
            lit=lit,
            counted=counted,
            noise=rms(lux_error[lit] / lux[lit]),
            spectral_noise=rms(error[counted] / spectra[counted]),
        )

    def deviations(self, found: Found) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n_lit,) and (n_counted,) value / reference − 1 of illuminances and of spectra."""
        lux = _joined(found, self.names, "illuminance")[self.lit]
        spectra = _joined(found, self.names, "irradiance")[self.counted]
        return lux / self.illuminance - 1.0, spectra / self.spectra - 1.0

    def sampling(self, run: Run) -> float:
        """Standard error of a run's illuminances by its own replicates, relative, root mean square."""
        width = _joined(run.readings, self.names, "illuminance_half_width")[self.lit]
        return rms(width / student_quantile(0.95, run.replicates - 1) / self.illuminance)


def prices(runs: Sequence[Run], truth: Truth) -> list[Price]:
    """Every setting, by rising cost; runs of one setting with several seeds count together."""
    together: dict[str, list[Run]] = {}
    for run in runs:
        together.setdefault(run.setting.name, []).append(run)
    found = sorted((_price(group, truth) for group in together.values()), key=lambda price: price.cpu_seconds)
    front = front_of(found)
    return [replace(price, on_front=k in front) for k, price in enumerate(found)]


def front_of(found: Sequence[Price]) -> set[int]:
    """Which prices are on the Pareto front of CPU seconds and illuminance."""
    return {int(k) for k in pareto_front(*costs_and_errors(found))}


def costs_and_errors(
    found: Sequence[Price], *, spectral: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n,) CPU seconds and errors; an error that can't be told from the noise is infinite, since it proves nothing."""
    errors = [price.spectrum if spectral else price.illuminance for price in found]
    cost = np.array([price.cpu_seconds for price in found], np.float64)
    return cost, np.array([np.inf if e.below_floor else max(e.rms, 1e-12) for e in errors], np.float64)


def effect_price(name: str, flags: str, usual: Run, forced: Run) -> EffectPrice:
    """What forcing an effect costs, and what it changes."""
    names = tuple(usual.readings)
    before, after = (_joined(run.readings, names, "illuminance") for run in (usual, forced))
    lit = before > 0.0
    variance = np.zeros(int(lit.sum()))
    for run in (usual, forced):
        width = _joined(run.readings, names, "illuminance_half_width")[lit]
        variance += (width / student_quantile(0.95, run.replicates - 1) / before[lit]) ** 2
    return EffectPrice(
        name=name,
        flags=flags,
        usual_seconds=usual.cpu_seconds,
        forced_seconds=forced.cpu_seconds,
        change=rms(after[lit] / before[lit] - 1.0),
        sampling=float(np.sqrt(variance.mean())) if lit.any() else 0.0,
    )


def bands_prices(found: Sequence[tuple[int, int, Run]]) -> list[BandsPrice]:
    """Prices of (bands, columns, run), all against the run with the most bands."""
    if not found:
        return []
    best = max(found, key=lambda item: item[0])[2].readings
    return [_bands_price(bands, columns, run, best) for bands, columns, run in sorted(found, key=lambda item: item[0])]


def _bands_price(bands: int, columns: int, run: Run, best: Found) -> BandsPrice:
    """One number of bands against the readings with the most; dark readings are left out."""
    names = tuple(best)
    lit = _joined(best, names, "illuminance") > 0.0

    def both(what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return _numbers(run.readings, names, what)[lit], _numbers(best, names, what)[lit]

    lux, true_lux = both("illuminance")
    melanopic, true_melanopic = both("melanopic_edi_lx")
    shift = np.abs(np.subtract(*both("chromaticity"))).max(axis=1)
    return BandsPrice(
        bands=bands,
        columns=columns,
        cpu_seconds=run.cpu_seconds,
        illuminance=rms(lux / true_lux - 1.0),
        mean_illuminance=float(lux.mean() / true_lux.mean() - 1.0),
        chromaticity=rms(shift[np.isfinite(shift)]),
        cct=_rms_where_known(np.subtract(*both("cct_k"))),
        ra=_rms_where_known(np.subtract(*both("ra"))),
        melanopic=float(melanopic.mean() / true_melanopic.mean() - 1.0) if true_melanopic.any() else math.nan,
    )


def largest_spread(runs: Sequence[Run]) -> float:
    """Standard deviation of one replicate over the base of `Readings.accuracy`, of the worst reading.

    Runs with several seeds give it more degrees of freedom.
    """
    names = tuple(runs[0].readings)
    squares = []
    for run in runs:
        relative = np.concatenate([run.readings[name].accuracy for name in names])
        squares.append((relative / student_quantile(0.95, run.replicates - 1)) ** 2 * run.replicates)
    return float(np.sqrt(np.mean(squares, axis=0).max(initial=0.0)))


def rms(values: NDArray[np.float64]) -> float:
    """Root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _price(runs: Sequence[Run], truth: Truth) -> Price:
    """One setting; the best known memory is that of its first run."""
    pairs = [truth.deviations(run.readings) for run in runs]
    readings = int(truth.lit.sum())
    lux, spectra = [p[0] for p in pairs], [p[1] for p in pairs]
    memory = [run.memory_bytes for run in runs if run.memory_bytes is not None]
    return Price(
        setting=runs[0].setting,
        elements=runs[0].elements,
        seeds=len(runs),
        cpu_seconds=float(np.mean([run.cpu_seconds for run in runs])),
        wall_seconds=float(np.mean([run.wall_seconds for run in runs])),
        memory_bytes=max(memory) if memory else None,
        illuminance=error_of(lux, truth.noise, readings),
        spectrum=error_of(spectra, truth.spectral_noise, readings),
        bias=float(np.mean([d.mean() for d in lux])),
        sampling=rms(np.array([truth.sampling(run) for run in runs])),
    )


def _rms_where_known(values: NDArray[np.float64]) -> float:
    """Root mean square of what isn't NaN; NaN of nothing."""
    known = values[np.isfinite(values)]
    return rms(known) if known.size else math.nan


def _numbers(found: Found, names: Sequence[str], what: str) -> NDArray[np.float64]:
    """A derived number of all sensors, one after another."""
    return np.concatenate([found[name].numbers[what].value for name in names])


def _joined(found: Found, names: Sequence[str], what: str) -> NDArray[np.float64]:
    """An array of all sensors, one after another."""
    return np.concatenate([getattr(found[name], what) for name in names])
