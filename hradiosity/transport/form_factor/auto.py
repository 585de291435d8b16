"""The cheapest method that meets the tolerance, pair by pair: Gauss points far away, the contour integral near."""

from __future__ import annotations

import numpy as np

from hradiosity.transport.form_factor.area import OPEN, area_exchange
from hradiosity.transport.form_factor.contour import contour_exchange
from hradiosity.transport.form_factor.pairs import Estimate, Pairs


def cheapest_exchange(pairs: Pairs, tolerance: float) -> Estimate:
    """A F of pairs within a relative `tolerance`."""
    ladder = area_exchange(pairs, tolerance)
    result = ladder.estimate
    near = np.flatnonzero(ladder.order == OPEN)
    if len(near):
        rest = contour_exchange(pairs.subset(near), tolerance)
        result.exchange[near] = rest.exchange
        result.error[near] = rest.error
    return result
