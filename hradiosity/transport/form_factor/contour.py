"""Form factors by the contour integral: the reference for accuracy (Stokes; Mitalas & Stephenson 1966).

Both polygons are cut to what they see of each other, so that no cosine changes sign. Of each pair of edges the inner
integral is closed; the outer one runs over the shorter edge. Parallel edges have a closed double integral; of others,
those far apart take Gauss points, and those that touch or nearly do take double-exponential points between the places
where one edge begins, ends or passes the other.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.quadrature import double_exponential, gauss

LEVELS: Final = (
    (8, 4, 0.25, 1e-6, 2e-5),
    (16, 8, 0.25, 1e-12, 2e-5),
    (16, 8, 0.125, 1e-12, 1e-6),
    (24, 12, 0.0625, 1e-16, 1e-8),
)
"""Gauss points on edges half a length apart and 1.5 lengths apart, step of the double-exponential rule, error of the
Gauss rules (their ellipse of convergence gives less than that), and that of the double-exponential one over the root of
the change by the last halving. In 98 to 100 % of pairs of edges that touch, cross or come near each other at all angles
it was less, whatever their gap."""
DOUBLE_EXPONENTIAL_REACH: Final = 3.0
FLAT_COSINE: Final = 0.9
"""Cosine between the normals of polygons from which on they lie nearly in one plane."""


def contour_exchange(pairs: Pairs, tolerance: float) -> Estimate:
    """A F of pairs, refined until the error estimate is below `tolerance` of the value.

    Parameters
    ----------
    pairs : Pairs
    tolerance : float
        Relative. The rounding error, about 1e-15 of the product of the polygons' perimeters, is not refined away; it
        is in the estimate. Where it is too large for polygons nearly in one plane, another form of the integral stands
        in, whose terms fall with the angle as the value does (``cl/include/hr_flat_contour.h``).
    """
    result, rounding = refined_exchange(pairs, "contour_exchange", tolerance)
    total = result.error + rounding
    lost = np.flatnonzero((rounding > 0.5 * tolerance * result.exchange) & _is_nearly_flat(pairs))
    if len(lost):
        flat, flat_rounding = refined_exchange(pairs.subset(lost), "flat_exchange", tolerance)
        better = flat.error + flat_rounding < total[lost]
        chosen = lost[better]
        result.exchange[chosen], total[chosen] = flat.exchange[better], (flat.error + flat_rounding)[better]
    return Estimate(result.exchange, total)


def _is_nearly_flat(pairs: Pairs) -> NDArray[np.bool_]:
    normal = pairs.polygons.normal
    flat: NDArray[np.bool_] = np.einsum("nd,nd->n", normal[pairs.first], normal[pairs.second]) > FLAT_COSINE
    return flat


def refined_exchange(pairs: Pairs, kernel: str, tolerance: float) -> tuple[Estimate, NDArray[np.float64]]:
    """A F with the error of the quadrature, and the rounding error, (n_pairs,) [m²], level by level."""
    start = 0 if tolerance >= 1e-5 else 1
    result, rounding = _at_level(pairs, kernel, start)
    for level in range(start + 1, len(LEVELS)):
        open_ = np.flatnonzero(result.error > np.maximum(tolerance * result.exchange, rounding))
        if len(open_) == 0:
            break
        finer, finer_rounding = _at_level(pairs.subset(open_), kernel, level)
        better = finer.error < result.error[open_]
        result.exchange[open_[better]] = finer.exchange[better]
        result.error[open_[better]] = finer.error[better]
        rounding[open_[better]] = finer_rounding[better]
    return result, rounding


def _at_level(pairs: Pairs, kernel: str, level: int) -> tuple[Estimate, NDArray[np.float64]]:
    """A F with the error of the quadrature, and the rounding error, (n_pairs,) [m²]."""
    near, far, step, near_error, crowded_error = LEVELS[level]
    # One step further than the reach: kernels take two nodes at a time, and this makes their number even.
    crowded = double_exponential(step, DOUBLE_EXPONENTIAL_REACH + step)
    rules = [_lower_half(near), _lower_half(far), crowded]
    node, weight = (np.concatenate(column) for column in zip(*rules))
    device = pairs.device
    exchange, error, rounding = pairs.results(3)
    device.kernel("pair_contour", kernel, **pairs.corner_definitions)(
        len(pairs),
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        rule_node=device.upload(node),
        rule_weight=device.upload(weight),
        n_near=len(rules[0][0]),
        n_far=len(rules[1][0]),
        n_fine=len(rules[2][0]),
        near_error=near_error,
        coarser_weight=0.25 / crowded[1][::2].sum(),
        crowded_error=crowded_error,
        exchange=exchange,
        error=error,
        rounding=rounding,
    )
    return pairs.estimate(exchange, error), device.fetch(rounding)[: len(pairs)]


def _lower_half(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    node, weight = gauss(order)
    return node[: order // 2], weight[: order // 2]
