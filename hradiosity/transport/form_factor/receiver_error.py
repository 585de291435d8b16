"""How far off a sum over points of the first polygon may be, from other sums over it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.quadrature import LineRule, gauss, rim

FASTER: Final = 5.0
"""By which steps that shrink are trusted to shrink on less than they did."""

Sum: TypeAlias = Callable[[int, LineRule], NDArray[np.float64]]
"""From an order and a rule to A F of all pairs, (n_pairs,) [m²]."""


def points_error(value: NDArray[np.float64], order: int, sum_of: Sum) -> NDArray[np.float64]:
    """Largest change from Gauss points of `order` a direction to one less (for a single one, one more), and to points
    of `rim`: a step that lies between two Gauss points, or between the last one and the border, shows in either.
    """
    fewer = sum_of(order - 1 if order > 1 else 2, gauss)
    at_border = sum_of(max(order - 1, 2), rim)
    error: NDArray[np.float64] = np.maximum(np.abs(value - fewer), np.abs(value - at_border))
    return error


def last_error(step: NDArray[np.float64], before: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is left after a step of doubling, (n_pairs,): the step, or what the next one should be when they shrink."""
    shrinks = np.divide(step, before, out=np.ones_like(step), where=np.isfinite(before) & (before > 0.0))
    error: NDArray[np.float64] = step * np.minimum(1.0, FASTER * shrinks)
    return error
