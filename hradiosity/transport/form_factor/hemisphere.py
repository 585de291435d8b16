"""Form factors by exact projection on a hemisphere over points of the smaller polygon (Lambert 1760, Nusselt 1928)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.quadrature import LineRule, gauss, receiver_arguments, rim
from hradiosity.transport.form_factor.receiver_error import last_error, points_error

EXACT_ARC: Final = 255
LARGEST_ORDER: Final = 16
_ORDERS: Final = (1, 2, 4, 8, LARGEST_ORDER)
_ROUNDING: Final = 1e-14


def hemisphere_exchange(pairs: Pairs, tolerance: float, points: int | None = None) -> Estimate:
    """A F of pairs, by ``points × points`` Gauss points on each quadrilateral of the first polygon.

    The error is a change between several numbers of points. Where the polygons are nearer to each other than the points
    are, all may miss the same: that is a place for the contour integral.

    Parameters
    ----------
    pairs : Pairs
    tolerance : float
        Relative error at which to stop doubling the points where `points` is None; at most `LARGEST_ORDER`.
    points : int, optional
        As many, whatever comes of it.
    """
    if points is not None:
        value = receiver_sum(pairs, points)
        return Estimate(value, points_error(value, points, lambda order, line: receiver_sum(pairs, order, line=line)))
    value = receiver_sum(pairs, _ORDERS[0])
    n = len(pairs)
    error, before = np.full(n, np.inf), np.full(n, np.inf)
    taken = np.full(n, _ORDERS[0])
    for order in _ORDERS[1:]:
        open_ = np.flatnonzero(error > tolerance * value)
        if len(open_) == 0:
            break
        finer = receiver_sum(pairs.subset(open_), order)
        step = np.abs(finer - value[open_])
        error[open_] = last_error(step, before[open_]) + _ROUNDING * finer
        before[open_], value[open_], taken[open_] = step, finer, order
    for order in _ORDERS[1:]:
        chosen = np.flatnonzero(taken == order)
        if len(chosen):
            other = receiver_sum(pairs.subset(chosen), order, line=rim)
            error[chosen] = np.maximum(error[chosen], 3.0 * np.abs(value[chosen] - other))
    return Estimate(value, error)


def receiver_sum(pairs: Pairs, order: int, halvings: int = EXACT_ARC, line: LineRule = gauss) -> NDArray[np.float64]:
    """(n_pairs,) A F [m²] with so many points a direction, arcs exact or as ``2**halvings`` chords each."""
    device = pairs.device
    (exchange,) = pairs.results(1)
    device.kernel("pair_hemisphere", "hemisphere_exchange", **pairs.corner_definitions)(
        len(pairs),
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        **receiver_arguments(pairs, order, line),
        halvings=halvings,
        exchange=exchange,
    )
    return pairs.estimate(exchange, exchange).exchange
