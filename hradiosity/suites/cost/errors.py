"""Errors of values against a noisy reference, with the reference's own noise taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

LEAST_EXCESS: Final = 0.5
"""A mean square error that exceeds the reference's own by less than this share of it can't be told from it."""
SIGMAS: Final = 2.0
"""So many standard deviations of the mean square of the noise are needed as well, where readings are few."""


@dataclass(frozen=True)
class Error:
    """Relative errors, without the noise of the reference as far as that can be told.

    rms, p95, largest : root mean square, 95th percentile and largest magnitude; the latter two shrink as the rms does
        when the noise is taken out, as if both errors were alike in shape
    below_floor : the error can't be told from the reference's noise; the numbers are upper bounds then
    """

    rms: float
    p95: float
    largest: float
    below_floor: bool


def without_noise(rms: float, noise: float, readings: int) -> tuple[float, bool]:
    """Root mean square error with that of the reference taken out in quadrature.

    Parameters
    ----------
    rms : float
        Of value / reference − 1.
    noise : float
        Standard error of the reference over its value, root mean square.
    readings : int
        Independent values in the mean.

    Returns
    -------
    float
        √(rms² − noise²), or the noise where the difference is not sure.
    bool
        Whether it is not sure.
    """
    excess = rms**2 - noise**2
    needed = max(LEAST_EXCESS, SIGMAS * float(np.sqrt(2.0 / max(readings, 1)))) * noise**2
    if noise > 0.0 and excess < needed:
        return noise, True
    return float(np.sqrt(max(excess, 0.0))), False


def error_of(deviations: Sequence[NDArray[np.float64]], noise: float, readings: int) -> Error:
    """Error of several runs together.

    Parameters
    ----------
    deviations : sequence of (n,) float64
        Value / reference − 1, of each run.
    noise, readings
        See `without_noise`.
    """
    every = np.abs(np.concatenate(list(deviations)))
    rms = float(np.sqrt(np.mean(every**2)))
    p95, largest = float(np.quantile(every, 0.95)), float(every.max())
    clean, below = without_noise(rms, noise, readings)
    share = clean / rms if rms > 0.0 else 1.0
    return Error(clean, p95 * min(share, 1.0), largest * min(share, 1.0), below)
