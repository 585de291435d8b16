"""What unbiased readings say of the intervals of others: statistics on arrays only.

Split conformal prediction (Vovk, Gammerman & Shafer 2005, Algorithmic Learning in a Random World): of m readings drawn
at random, the ⌈0.95 (m + 1)⌉-th smallest ratio of error to half width is a factor with which the interval of a further
one holds with 95 % on average, whatever the errors are distributed like.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

LEVEL: Final = 0.95
"""Share of the readings whose intervals should hold."""
LEAST_READINGS: Final = 19
"""With fewer no order statistic reaches the level."""
_ALIKE: Final = 9


@dataclass(frozen=True)
class Verdict:
    """What an audit found out.

    factor : that half widths are to be multiplied with, at least 1
    quantile : the conformal factor itself, below 1 where intervals are wider than need be
    within : share of the audited readings whose intervals, audit's noise in quadrature, hold the unbiased value
    median : of the ratios
    sharp : how many readings were audited with a noise below their half width
    bias, bias_half_width : of all audited readings together, how much too bright, over their sum; errors that all
        readings share show here even where the paths of each are too noisy to tell
    """

    factor: float
    quantile: float
    within: float
    median: float
    sharp: int
    bias: float
    bias_half_width: float


def audit_order(group: NDArray[np.int64], seed: int) -> NDArray[np.int64]:
    """Readings in random order; every beginning holds about the same share of each group.

    Parameters
    ----------
    group : (n,) int64
        Of each reading: its sensor.
    seed : int
        The same seed gives the same order.

    Returns
    -------
    (n,) int64
        Permutation of 0 … n − 1.
    """
    rng = np.random.Generator(np.random.Philox(key=seed))
    place = np.zeros(len(group))
    for members in (np.flatnonzero(group == name) for name in np.unique(group)):
        place[members] = (rng.permutation(len(members)) + rng.random()) / len(members)
    order: NDArray[np.int64] = np.argsort(place, kind="stable")
    return order


def pooled_noise(standard_error: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) standard errors, none smaller than what is usual among readings of like brightness.

    Where light is rarely found, as behind a narrow gap, the paths that found least of it also show the least spread.
    Their own standard errors would take that for a fault of the intervals: the root mean square of the errors relative
    to `value`, which those paths had no part in, over the nine readings next in brightness, bounds them from below.

    Parameters
    ----------
    standard_error, value : (n,) float64
    """
    order = np.argsort(value, kind="stable")
    relative = np.divide(standard_error, value, out=np.zeros_like(value), where=value > 0.0)[order]
    window = min(_ALIKE, len(value))
    means = np.convolve(relative**2, np.full(window, 1.0 / window), mode="valid")
    nearest = np.clip(np.arange(len(value)) - window // 2, 0, len(means) - 1)
    usual = np.empty_like(value)
    usual[order] = np.sqrt(means[nearest])
    noise: NDArray[np.float64] = np.maximum(standard_error, usual * value)
    return noise


def widening(
    error: NDArray[np.float64], half_width: NDArray[np.float64], noise: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n,) factor with which each interval would just hold the unbiased value.

    f with |error|² = (f · half_width)² + noise², the audit's noise in quadrature, or 0 where noise alone explains the
    error. Where noise is the larger of the two, that f would magnify it; then both are widened, all but as much of the
    noise as there is interval. Either way f ≤ 1 where √(half_width² + noise²) holds the error.

    Parameters
    ----------
    error : (n,) float64
        Reading less unbiased value.
    half_width : (n,) float64
        Above 0.
    noise : (n,) float64
        Half width of the unbiased value at the same level.
    """
    deducted = np.minimum(half_width, noise) ** 2
    left = np.maximum(error**2 - deducted, 0.0)
    factor: NDArray[np.float64] = np.sqrt(left / (half_width**2 + noise**2 - deducted))
    return factor


def judge(
    value: NDArray[np.float64],
    unbiased: NDArray[np.float64],
    half_width: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> Verdict:
    """The conformal factor of readings drawn at random.

    Parameters
    ----------
    value, unbiased : (n,) float64
        Each reading, and what the paths found for it.
    half_width, noise : (n,) float64
        Of both, at the same level; half widths above 0.

    Raises
    ------
    ValueError
        With fewer than 19 readings.
    """
    if len(value) < LEAST_READINGS:
        raise ValueError(f"an audit needs {LEAST_READINGS} readings, has {len(value)}")
    ratio = np.sort(widening(value - unbiased, half_width, noise))
    quantile = float(ratio[math.ceil(LEVEL * (len(ratio) + 1)) - 1])
    light = max(float(value.sum()), float(np.finfo(np.float64).tiny))
    return Verdict(
        factor=max(1.0, quantile),
        quantile=quantile,
        within=float(np.mean(ratio <= 1.0)),
        median=float(np.median(ratio)),
        sharp=int((noise <= half_width).sum()),
        bias=float((value - unbiased).sum()) / light,
        bias_half_width=math.sqrt(float((noise**2).sum())) / light,
    )
