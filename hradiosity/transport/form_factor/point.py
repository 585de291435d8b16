"""Form factors from sizes, angles and distance alone: the swiftest method, for pairs far apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs


def point_exchange(pairs: Pairs, *, disks: bool) -> Estimate:
    """``A_i A_j cos cos / (π r²)`` between centroids; its error falls with the square of size over distance.

    Parameters
    ----------
    pairs : Pairs
    disks : bool
        Put ``π r² + A_i + A_j`` in place of π r²: the first terms of the closed form for coaxial parallel disks,
        which keeps the factor of near pairs below 1.
    """
    device = pairs.device
    (exchange,) = pairs.results(1)
    polygons = pairs.polygon_arguments
    device.kernel("pair_point", "point_exchange")(
        len(pairs),
        **{name: polygons[name] for name in ("polygon_normal", "polygon_sphere", "polygon_area")},
        **pairs.pair_arguments,
        disks=int(disks),
        exchange=exchange,
    )
    value = pairs.estimate(exchange, exchange).exchange
    return Estimate(value, _error(pairs, value))


def _error(pairs: Pairs, exchange: NDArray[np.float64]) -> NDArray[np.float64]:
    """The remainder of one Gauss point on either polygon, with the pole that the other one's sphere leaves.

    Where the spheres overlap, or a horizon may cut, nothing better is known than the smaller area.
    """
    p = pairs.polygons
    across = p.centre[pairs.second] - p.centre[pairs.first]
    distance = np.linalg.norm(across, axis=1)
    radius_a, radius_b = p.radius[pairs.first], p.radius[pairs.second]
    height_b = np.einsum("nd,nd->n", across, p.normal[pairs.first])
    height_a = -np.einsum("nd,nd->n", across, p.normal[pairs.second])
    hidden = (height_b < -radius_b) | (height_a < -radius_a)
    clear = (distance > radius_a + radius_b) & (height_b > radius_b) & (height_a > radius_a)
    room_a, room_b = np.where(clear, distance - radius_b, 1.0), np.where(clear, distance - radius_a, 1.0)
    relative = 3.4 * ((radius_a / room_a) ** 2 + (radius_b / room_b) ** 2)
    smaller = np.minimum(p.area[pairs.first], p.area[pairs.second])
    error: NDArray[np.float64] = np.where(clear, np.minimum(relative * exchange, smaller), smaller)
    return np.where(hidden, 0.0, error)
