"""Form factors by exact projection on a hemisphere over points of the smaller polygon (Lambert 1760, Nusselt 1928)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.quadrature import receiver_arguments

EXACT_ARC: Final = 255
LARGEST_ORDER: Final = 16
_ORDERS: Final = (1, 2, 4, 8, LARGEST_ORDER)


def hemisphere_exchange(pairs: Pairs, tolerance: float, points: int | None = None) -> Estimate:
    """A F of pairs, by ``points × points`` Gauss points on each quadrilateral of the first polygon.

    The error is a change between two numbers of points. Where the polygons are nearer to each other than the points
    are, both may miss the same, and it is too small: that is a place for the contour integral.

    Parameters
    ----------
    pairs : Pairs
    tolerance : float
        Relative change at which to stop doubling the points where `points` is None; at most `LARGEST_ORDER`.
    points : int, optional
        The error is then twice what one point less a direction changes (for a single one, one more).
    """
    if points is not None:
        value = receiver_sum(pairs, points)
        other = receiver_sum(pairs, points - 1 if points > 1 else 2)
        return Estimate(value, 2.0 * np.abs(value - other))
    value = receiver_sum(pairs, _ORDERS[0])
    error = np.full(len(pairs), np.inf)
    for order in _ORDERS[1:]:
        open_ = np.flatnonzero(error > tolerance * value)
        if len(open_) == 0:
            break
        finer = receiver_sum(pairs.subset(open_), order)
        error[open_] = np.abs(finer - value[open_])
        value[open_] = finer
    return Estimate(value, error)


def receiver_sum(pairs: Pairs, order: int, halvings: int = EXACT_ARC) -> NDArray[np.float64]:
    """(n_pairs,) A F [m²] with so many points a direction, arcs exact or as ``2**halvings`` chords each."""
    device = pairs.device
    (exchange,) = pairs.results(1)
    device.kernel("pair_hemisphere", "hemisphere_exchange", **pairs.corner_definitions)(
        len(pairs),
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        **receiver_arguments(pairs, order),
        halvings=halvings,
        exchange=exchange,
    )
    return pairs.estimate(exchange, exchange).exchange
