"""Exchange areas of links when nothing stands between, from form factors of their facets."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.space.nodes import Nodes
from hradiosity.transport.form_factor.auto import cheapest_exchange
from hradiosity.transport.form_factor.pairs import Pairs
from hradiosity.transport.form_factor.polygons import polygon_set

TOLERANCE: Final = 1e-3
"""Relative error of each form factor, far below what is left by links of finite size."""
BATCH_PAIRS: Final = 1 << 20
"""Pairs of facets on the device at a time."""


def open_exchange(
    device: Device, nodes: Nodes, first: NDArray[np.int64], second: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(n_links,) A F of each pair of nodes [m²], without obstacles; of a group with itself, of all its facets.

    Raises
    ------
    DeviceError
        When the device has no double precision.
    """
    facets = nodes.facets
    count = np.where(facets.is_triangle, 3, 4)
    polygons = polygon_set(facets.corners, count, [""] * len(facets))
    pairs = Pairs(polygons, np.zeros(0, np.uint32), np.zeros(0, np.uint32), device)
    exchange = np.zeros(len(first))
    n_facets = np.diff(nodes.facet_start)
    per_link = n_facets[first] * n_facets[second]
    ends = np.cumsum(per_link)
    low = 0
    while low < len(first):
        done = ends[low - 1] if low else 0
        high = max(int(np.searchsorted(ends, done + BATCH_PAIRS, side="right")), low + 1)
        link = np.repeat(np.arange(low, high), per_link[low:high])
        within = np.arange(len(link)) - (ends[link] - per_link[link] - done)
        of_second = n_facets[second[link]]
        one = nodes.facet_start[first[link]] + within // of_second
        other = nodes.facet_start[second[link]] + within % of_second
        apart = one != other
        smaller = facets.area[one] <= facets.area[other]
        chosen = pairs.with_pairs(
            np.where(smaller, one, other)[apart].astype(np.uint32),
            np.where(smaller, other, one)[apart].astype(np.uint32),
        )
        found, _ = cheapest_exchange(chosen, TOLERANCE)
        exchange += np.bincount(link[apart], weights=found.exchange, minlength=len(first))
        low = high
    return exchange
