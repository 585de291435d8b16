"""Which settings to try next: changes of single knobs, added up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from hradiosity.suites.cost.pareto import pareto_front

LEAST_SHARE: Final = 0.03
"""Part of the usual mean square error that no sum of gains goes below: gains measured one by one don't all add up."""


@dataclass(frozen=True)
class Change:
    """One knob at another value.

    factor : of its usual value
    cost, square : CPU seconds and mean square error, less those of the usual setting
    """

    factor: float
    cost: float
    square: float


@dataclass(frozen=True)
class Proposal:
    """Several knobs at once.

    factors : by knob; those that stay are left out
    cost, error : expected CPU seconds, and root mean square error
    """

    factors: Mapping[str, float]
    cost: float
    error: float


def propose(
    usual_cost: float, usual_error: float, changes: Mapping[str, Sequence[Change]], *, most: int
) -> list[Proposal]:
    """Combinations of at least two changes that should lie on the Pareto front, spread over its cost.

    Cost and mean square error of a combination are taken to be those of the usual setting plus the sum of the single
    changes: variances of independent samples add, and so do seconds of stages.

    Parameters
    ----------
    usual_cost, usual_error : float
    changes : mapping
        By knob; each is used at most once.
    most : int
        Proposals at most.
    """
    knobs = list(changes)
    choices = list(product(*([None, *changes[knob]] for knob in knobs)))
    cost = np.array([usual_cost + sum(c.cost for c in choice if c) for choice in choices])
    square = np.array([usual_error**2 + sum(c.square for c in choice if c) for choice in choices])
    square = np.maximum(square, LEAST_SHARE * usual_error**2)
    possible = np.where(cost > 0.0, np.sqrt(square), np.inf)
    front = [k for k in pareto_front(cost, possible) if sum(c is not None for c in choices[k]) >= 2]
    if len(front) > most:
        wanted = np.geomspace(cost[front[0]], cost[front[-1]], most)
        front = sorted({min(front, key=lambda k: abs(np.log(cost[k] / c))) for c in wanted}, key=lambda k: cost[k])
    return [
        Proposal(
            {knob: c.factor for knob, c in zip(knobs, choices[k]) if c is not None},
            float(cost[k]),
            float(possible[k]),
        )
        for k in front
    ]
