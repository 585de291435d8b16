"""Form factors of pairs far apart: Gauss points on both polygons, as few as the distance allows.

The ladder of orders is that of View3D (Walton, NISTIR 6925, 2002); here the order follows from a bound on the remainder
and not from trying.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
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
    device, n = pairs.device, len(pairs)
    order, relative = device.empty((n,), np.uint8), device.empty((n,), np.float32)
    device.kernel("pair_area", "choose_orders", **pairs.corner_definitions)(
        n,
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        tolerance=tolerance,
        order_taken=order,
        relative=relative,
    )
    taken = device.fetch(order)[:n]
    wanted = [k for k in ORDERS if (taken == k).any()]
    if not wanted:
        return Ladder(Estimate(np.zeros(n), np.zeros(n)), taken)
    (exchange,) = pairs.results(1)
    device.kernel("pair_area", "area_exchange", **pairs.corner_definitions)(
        n,
        polygon_normal=pairs.polygon_arguments["polygon_normal"],
        **pairs.pair_arguments,
        **_rules(pairs, wanted),
        order_taken=order,
        exchange=exchange,
    )
    value = device.fetch(exchange)[:n]
    return Ladder(Estimate(value, value * device.fetch(relative)[:n]), taken)


def _rules(pairs: Pairs, wanted: list[int]) -> dict[str, DeviceArray]:
    """Points of the orders that occur, by the names of the kernel's arguments."""
    rules = [surface_rule(pairs.polygons, k).point if k in wanted else np.zeros((0, 4, 0)) for k in ORDERS]
    sizes = np.cumsum([0] + [rule.size for rule in rules])
    upload = pairs.device.upload
    return {
        "rule_point": upload(np.concatenate([rule.ravel() for rule in rules])),
        "rule_start": upload(sizes[:-1], np.uint64),
        "rule_length": upload(np.array([rule.shape[2] for rule in rules]), np.uint32),
    }
