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

LEVELS: Final = ((8, 4, 0.5, 1e-6), (16, 8, 0.25, 1e-12), (16, 8, 0.125, 1e-12), (16, 8, 0.0625, 1e-12))
"""Gauss points on edges half a length apart and 1.5 lengths apart, step of the double-exponential rule, and relative
error of the Gauss rules: their ellipse of convergence gives less than that."""
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
    near, far, step, near_error = LEVELS[level]
    rules = [_even(*_lower_half(near)), _even(*_lower_half(far)), _even(*double_exponential(step))]
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
        exchange=exchange,
        error=error,
        rounding=rounding,
    )
    return pairs.estimate(exchange, error), device.fetch(rounding)[: len(pairs)]


def _lower_half(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    node, weight = gauss(order)
    return node[: order // 2], weight[: order // 2]


def _even(node: NDArray[np.float64], weight: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Kernels take two nodes at a time; the one that is added has no weight."""
    if len(node) % 2 == 0:
        return node, weight
    return np.append(node, 0.25), np.append(weight, 0.0)
