"""Form factors of pairs far apart: Gauss points on both polygons, as few as the distance allows.

The ladder of orders is that of View3D (Walton, NISTIR 6925, 2002); here the order follows from a bound on the remainder
and not from trying.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.quadrature import surface_rule

ORDERS: Final = (1, 2, 3, 4)
OPEN: Final = 255
"""Order of a pair that is too near, or that crosses a horizon."""


@dataclass(frozen=True)
class Ladder:
    """What the ladder made of pairs.

    estimate : Estimate, 0 where the order is 0 or `OPEN`
    order : (n_pairs,) uint8, Gauss points a direction; 0 where the polygons see nothing of each other
    """

    estimate: Estimate
    order: NDArray[np.uint8]


def area_exchange(pairs: Pairs, tolerance: float) -> Ladder:
    """A F of the pairs that Gauss points settle within a relative `tolerance`."""
    device = pairs.device
    rules = [surface_rule(pairs.polygons, order).point for order in ORDERS]
    starts = np.cumsum([0] + [rule.size for rule in rules[:-1]])
    exchange, error = pairs.results()
    order = device.empty((len(pairs),), np.uint8)
    device.kernel("pair_area", "area_exchange", **pairs.corner_definitions)(
        len(pairs),
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        rule_point=device.upload(np.concatenate([rule.ravel() for rule in rules])),
        rule_start=device.upload(starts, np.uint32),
        rule_length=device.upload(np.array([rule.shape[2] for rule in rules]), np.uint32),
        tolerance=tolerance,
        exchange=exchange,
        error=error,
        order_taken=order,
    )
    taken = device.fetch(order)[: len(pairs)]
    return Ladder(pairs.estimate(exchange, error), taken)
