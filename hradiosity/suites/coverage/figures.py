"""Coverage, width and error of intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import Estimate
from hradiosity.suites.coverage.measure import Numbers
from hradiosity.suites.coverage.truth import Truth

LEVELS = (0.5, 0.8, 0.95)
"""Nominal coverage of the intervals."""
Width = Callable[[Estimate, float], NDArray[np.float64]]


@dataclass(frozen=True)
class Figures:
    """Of one kind of number in one scene, or over scenes.

    count : numbers, times seeds
    covered : by LEVELS, share of intervals, widened by the truth's own in quadrature, that hold the truth
    uncertain : standard error of the last of `covered`, from the spread of the seeds
    rms : root mean square error, relative (see `measure.FIXED_SCALE`), the truth's own error taken out
    bias : mean error
    common : root mean square of the error that all seeds have in common
    ratio : median half width of the 95 % interval over `rms`
    truth_ratio : median half width of the truth's 95 % interval over that of the run
    """

    count: int
    covered: tuple[float, ...]
    uncertain: float
    rms: float
    bias: float
    common: float
    ratio: float
    truth_ratio: float


def own_width(estimate: Estimate, level: float) -> NDArray[np.float64]:
    """The interval as the program gives it."""
    return estimate.half_width_at(level)


def figures_of(numbers: Numbers, width: Width = own_width) -> Figures | None:
    """Of one kind of number in one scene; None when there are none."""
    if not len(numbers.truth):
        return None
    error = np.array([estimate.value - numbers.truth for estimate in numbers.estimates])
    half = np.array([width(estimate, 0.95) for estimate in numbers.estimates])
    scaled, known = error / numbers.scale, numbers.truth_error / numbers.scale
    seen = np.isfinite(scaled)
    squares = np.mean(scaled[seen] ** 2 - np.broadcast_to(known, scaled.shape)[seen] ** 2)
    rms = _root(float(squares))
    median = float(np.nanmedian(half / numbers.scale))
    held = {level: covered(numbers, level, width) for level in LEVELS}
    truth_half = Truth.quantile(0.95) * numbers.truth_error
    return Figures(
        count=error.size,
        covered=tuple(float(held[level].mean()) for level in LEVELS),
        uncertain=_standard_error(held[LEVELS[-1]].mean(axis=1)),
        rms=rms,
        bias=float(scaled[seen].mean()),
        common=_common(scaled, known),
        ratio=median / rms if rms > 0.0 else float("nan"),
        truth_ratio=float(np.nanmedian(truth_half / np.maximum(half, np.finfo(np.float64).tiny))),
    )


def covered(numbers: Numbers, level: float, width: Width = own_width) -> NDArray[np.bool_]:
    """(n_seeds, n) which intervals hold the truth; one without a value holds none."""
    slack = Truth.quantile(level) * numbers.truth_error
    return np.array([np.abs(e.value - numbers.truth) <= np.hypot(width(e, level), slack) for e in numbers.estimates])


def over_scenes(parts: Sequence[Figures]) -> Figures:
    """Every scene counts alike: means, and of the ratios medians."""

    def median(values: Sequence[float]) -> float:
        kept = [value for value in values if np.isfinite(value)]
        return float(np.median(kept)) if kept else float("nan")

    return Figures(
        count=sum(part.count for part in parts),
        covered=tuple(float(np.mean([part.covered[i] for part in parts])) for i in range(len(LEVELS))),
        uncertain=float(np.sqrt(np.sum([part.uncertain**2 for part in parts]))) / len(parts),
        rms=_root(float(np.mean([part.rms**2 for part in parts]))),
        bias=float(np.mean([part.bias for part in parts])),
        common=_root(float(np.mean([part.common**2 for part in parts]))),
        ratio=median([part.ratio for part in parts]),
        truth_ratio=median([part.truth_ratio for part in parts]),
    )


def _common(scaled: NDArray[np.float64], known: NDArray[np.float64]) -> float:
    """Mean over seeds, squared, less what is left in it of the spread of the seeds and of the truth's error."""
    if len(scaled) < 2:
        return float("nan")
    left = scaled.mean(axis=0) ** 2 - scaled.var(axis=0, ddof=1) / len(scaled) - known**2
    return _root(float(np.nanmean(left)))


def _standard_error(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")


def _root(square: float) -> float:
    return float(np.sqrt(max(square, 0.0)))
