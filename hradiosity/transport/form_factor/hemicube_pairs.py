"""Form factors of pairs by hemicubes over points of the smaller polygon (Cohen & Greenberg 1985).

`hradiosity.transport.form_factor.hemicube` draws whole scenes with depth; here one polygon is drawn and nothing can
hide it, so that rows of covered pixels are found from its edges.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.hemicube import delta_factors
from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.quadrature import LineRule, gauss, receiver_arguments
from hradiosity.transport.form_factor.receiver_error import points_error

_TURNS: Final = 4


def hemicube_exchange(pairs: Pairs, points: int, resolution: int, seed: int) -> Estimate:
    """A F of pairs with ``points × points`` hemicubes on each quadrilateral of the first polygon.

    Parameters
    ----------
    pairs : Pairs
    points, resolution : int
        Resolution: pixels along an edge of the top face, even and at least 8.
    seed : int
        Of the random turn of each hemicube about its normal.

    Raises
    ------
    ValueError
        For an odd or small resolution.
    """
    if resolution < 8 or resolution % 2:
        raise ValueError(f"the resolution of a hemicube must be even and at least 8, is {resolution}")
    turned = _turned(pairs, points, resolution, seed, _TURNS)
    value = turned.mean(axis=1)
    points_off = points_error(
        value, points, lambda order, line: _turned(pairs, order, resolution, seed, 1, line).mean(axis=1)
    )
    spread: NDArray[np.float64] = turned.max(axis=1) - turned.min(axis=1)
    smaller = np.minimum(pairs.polygons.area[pairs.first], pairs.polygons.area[pairs.second])
    pixel = float(delta_factors(resolution).max())
    return Estimate(np.minimum(value, smaller), points_off + spread + 0.5 * pixel * smaller)


def _turned(
    pairs: Pairs, points: int, resolution: int, seed: int, turns: int, line: LineRule = gauss
) -> NDArray[np.float64]:
    """(n_pairs, turns) A F [m²]."""
    device = pairs.device
    exchange = device.empty((len(pairs), turns), np.float64)
    device.kernel("pair_hemicube", "hemicube_exchange", **pairs.corner_definitions)(
        len(pairs) * turns,
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        **receiver_arguments(pairs, points, line),
        pixel=device.upload(delta_factors(resolution)),
        resolution=resolution,
        n_turns=turns,
        seed=seed,
        exchange=exchange,
    )
    rows: NDArray[np.float64] = device.fetch(exchange)
    return rows
