"""The cheapest method that meets the tolerance, pair by pair: Gauss points far away, the contour integral near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.area import OPEN, area_exchange
from hradiosity.transport.form_factor.contour import contour_exchange
from hradiosity.transport.form_factor.pairs import Estimate, Pairs

NONE, GAUSS, CONTOUR = range(3)


def cheapest_exchange(
    pairs: Pairs, tolerance: float, far_tolerance: float | None = None
) -> tuple[Estimate, NDArray[np.uint8]]:
    """A F of pairs within a relative `tolerance`, and what made each: NONE, GAUSS or CONTOUR.

    Parameters
    ----------
    pairs : Pairs
    tolerance : float
    far_tolerance : float, optional
        Another tolerance for the decision between Gauss points and contour.
    """
    ladder = area_exchange(pairs, tolerance if far_tolerance is None else far_tolerance)
    result = ladder.estimate
    used = np.minimum(ladder.order, GAUSS)
    near = np.flatnonzero(ladder.order == OPEN)
    if len(near):
        rest = contour_exchange(pairs.subset(near), tolerance)
        result.exchange[near] = rest.exchange
        result.error[near] = rest.error
        used[near] = CONTOUR
    return result, used
