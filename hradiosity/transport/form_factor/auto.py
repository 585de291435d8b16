"""The cheapest method that meets the tolerance, pair by pair: Gauss points far away, the contour integral near.

Where the contour integral loses digits by cancellation, projection on hemispheres stands in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.area import OPEN, area_exchange
from hradiosity.transport.form_factor.contour import contour_exchange
from hradiosity.transport.form_factor.hemisphere import hemisphere_exchange
from hradiosity.transport.form_factor.pairs import Estimate, Pairs

NONE, GAUSS, CONTOUR, HEMISPHERE = range(4)


def cheapest_exchange(
    pairs: Pairs, tolerance: float, far_tolerance: float | None = None
) -> tuple[Estimate, NDArray[np.uint8]]:
    """A F of pairs within a relative `tolerance`, and what made each: NONE, GAUSS, CONTOUR or HEMISPHERE.

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
    if len(near) == 0:
        return result, used
    rest = contour_exchange(pairs.subset(near), tolerance)
    result.exchange[near], result.error[near], used[near] = rest.exchange, rest.error, CONTOUR
    lossy = near[(rest.error > tolerance * rest.exchange) & _is_smooth(pairs.subset(near))]
    if len(lossy):
        direct = hemisphere_exchange(pairs.subset(lossy), 1e-3 * tolerance)
        better = direct.error < result.error[lossy]
        chosen = lossy[better]
        result.exchange[chosen], result.error[chosen] = direct.exchange[better], direct.error[better]
        used[chosen] = HEMISPHERE
    return result, used


def _is_smooth(pairs: Pairs) -> NDArray[np.bool_]:
    """Whether the first polygon lies higher over the plane of the second than 1.5 times its radius, and all above it.

    What its points receive is then smooth over it, so that few Gauss points give all digits. For slivers and for
    polygons far smaller than the other one the contour integral loses some by cancellation.
    """
    p = pairs.polygons
    across = p.centre[pairs.first] - p.centre[pairs.second]
    height = np.einsum("nd,nd->n", across, p.normal[pairs.second])
    far_corner = p.corners[pairs.second] - p.centre[pairs.first][:, None]
    horizon = np.einsum("nkd,nd->nk", far_corner, p.normal[pairs.first]).min(axis=1, initial=np.inf)
    smooth: NDArray[np.bool_] = (height > 1.5 * p.radius[pairs.first]) & (horizon >= 0.0)
    return smooth
