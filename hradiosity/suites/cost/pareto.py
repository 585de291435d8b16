"""Which settings nothing beats, and what an accuracy costs among them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

SAMPLING_SLOPE: Final = 2.0
"""Beyond what was measured, time is taken to grow with this power of 1 / error: that of random sampling."""
TARGETS: Final = (0.5, 0.3, 0.2, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001, 0.0005, 0.0003)
"""Errors whose price is told."""

Kind = Literal["interpolated", "extrapolated", "at most"]


@dataclass(frozen=True)
class Quote:
    """What an error costs.

    target : the error asked for, relative
    seconds : CPU seconds
    kind : "interpolated" between measured settings, "extrapolated" beyond the best of them, or "at most": the
        cheapest setting is better than that
    setting : number of the cheapest measured setting that is as good; None when there is none
    """

    target: float
    seconds: float
    kind: Kind
    setting: int | None


def pareto_front(cost: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray[np.int64]:
    """Settings that no other one beats in both cost and error, by rising cost; of equal ones the first.

    Parameters
    ----------
    cost, error : (n,) float64
        An error that is not finite is on no front.
    """
    order = np.lexsort((np.arange(len(cost)), error, cost))
    order = order[np.isfinite(error[order])]
    best = np.minimum.accumulate(np.concatenate([[np.inf], error[order]]))[:-1]
    return order[error[order] < best].astype(np.int64)


def quote(target: float, cost: NDArray[np.float64], error: NDArray[np.float64]) -> Quote | None:
    """Cost of an error by straight lines in log-log between the settings on the front; None when there is no front.

    Parameters
    ----------
    target : float
    cost, error : (n,) float64
        Of all settings, errors above 0.
    """
    front = pareto_front(cost, error)
    if not len(front):
        return None
    seconds, reached = cost[front], error[front]
    good = np.flatnonzero(reached <= target)
    if not len(good):
        far = float(seconds[-1] * (reached[-1] / target) ** SAMPLING_SLOPE)
        return Quote(target, far, "extrapolated", None)
    first = int(good[0])
    if first == 0:
        return Quote(target, float(seconds[0]), "at most", int(front[0]))
    between = slice(first - 1, first + 1)
    logs = np.interp(-np.log(target), -np.log(reached[between]), np.log(seconds[between]))
    return Quote(target, float(np.exp(logs)), "interpolated", int(front[first]))


def quotes(cost: NDArray[np.float64], error: NDArray[np.float64]) -> list[Quote]:
    """Prices of round errors: from the last that the cheapest setting reaches to the first that none does."""
    front = pareto_front(cost, error)
    if not len(front):
        return []
    worst, best = error[front[0]], error[front[-1]]
    easy = [target for target in TARGETS if worst <= target][-1:]
    reached = [target for target in TARGETS if best <= target < worst]
    beyond = [target for target in TARGETS if target < best][:1]
    found = [quote(target, cost, error) for target in (*easy, *reached, *beyond)]
    return [one for one in found if one is not None]
