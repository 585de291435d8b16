"""How far readings are from a reference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.solution import Readings

BAND_FLOOR = 0.01
"""Bands whose mean over the readings is below this part of the strongest band's do not count."""


@dataclass(frozen=True)
class Comparison:
    """Errors relative to the reference, over all readings that have light in it.

    readings : number of readings compared; dark ones in the reference are left out
    spectral_rms : root mean square over readings and bands of value/reference − 1
    illuminance_rms, illuminance_p95, illuminance_max : of the illuminances: root mean square, 95th percentile and
        largest of the magnitudes
    bias : mean of illuminance/reference − 1
    reference_spectral_rms, reference_illuminance_rms : standard error of the reference itself over its value, root
        mean square
    covered : share of the readings whose illuminance interval, widened by the reference's in quadrature, holds the
        reference
    spectra_covered : the same over readings and bands
    """

    readings: int
    spectral_rms: float
    illuminance_rms: float
    illuminance_p95: float
    illuminance_max: float
    bias: float
    reference_spectral_rms: float
    reference_illuminance_rms: float
    covered: float
    spectra_covered: float


def compare(
    readings: Mapping[str, Readings], reference: Mapping[str, Readings], *, quantile: float = 1.0
) -> Comparison:
    """Errors of `readings`, sensors matched by name.

    Parameters
    ----------
    readings, reference : mapping of sensor name to Readings
    quantile : float
        Half width over standard error of the reference: Student's quantile of its number of scrambles.

    Raises
    ------
    ValueError
        When the sensors, their readings or the bands differ, or nothing in the reference has light.
    """
    _check_alike(readings, reference)
    names = list(reference)
    value, truth = (np.concatenate([r[name].illuminance for name in names]) for r in (readings, reference))
    lux_width, lux_noise = (np.concatenate([r[n].illuminance_half_width for n in names]) for r in (readings, reference))
    spectra, true_spectra = (np.concatenate([r[name].irradiance for name in names]) for r in (readings, reference))
    width, noise = (np.concatenate([r[name].half_width for name in names]) for r in (readings, reference))
    bands = counted_bands(true_spectra)
    lit = truth > 0.0
    counts = (true_spectra > 0.0) & bands[None, :]
    if not lit.any() or not counts.any():
        raise ValueError("nothing in the reference has light")
    lux_error = value[lit] / truth[lit] - 1.0
    return Comparison(
        readings=int(lit.sum()),
        spectral_rms=_rms(spectra[counts] / true_spectra[counts] - 1.0),
        illuminance_rms=_rms(lux_error),
        illuminance_p95=float(np.quantile(np.abs(lux_error), 0.95)),
        illuminance_max=float(np.abs(lux_error).max()),
        bias=float(lux_error.mean()),
        reference_spectral_rms=_rms(noise[counts] / quantile / true_spectra[counts]),
        reference_illuminance_rms=_rms(lux_noise[lit] / quantile / truth[lit]),
        covered=_covered(value[lit], truth[lit], lux_width[lit], lux_noise[lit]),
        spectra_covered=_covered(spectra[counts], true_spectra[counts], width[counts], noise[counts]),
    )


def counted_bands(spectra: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n_bands,) which bands of (n_readings, n_bands) spectra carry enough light to count."""
    mean = spectra.mean(axis=0)
    enough: NDArray[np.bool_] = mean > BAND_FLOOR * mean.max(initial=0.0)
    return enough


def _check_alike(readings: Mapping[str, Readings], reference: Mapping[str, Readings]) -> None:
    if set(readings) != set(reference):
        raise ValueError(f"sensors differ: {sorted(readings)} and {sorted(reference)}")
    if not reference:
        raise ValueError("there is no sensor to compare")
    for name, known in reference.items():
        if readings[name].irradiance.shape != known.irradiance.shape:
            shapes = f"{readings[name].irradiance.shape} and {known.irradiance.shape}"
            raise ValueError(f"readings or bands of sensor {name!r} differ: {shapes}")


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _covered(
    value: NDArray[np.float64], truth: NDArray[np.float64], width: NDArray[np.float64], noise: NDArray[np.float64]
) -> float:
    return float(np.mean(np.abs(value - truth) <= np.hypot(width, noise)))
