"""What row elements exchange with the outside where form factors tell of each other only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.hierarchy import COVERED, Elements
from hradiosity.transport.exchange import RowHits, seen_areas


def outside_areas(
    hits: RowHits,
    elements: Elements,
    received: NDArray[np.float64],
    error: NDArray[np.float64],
    space: NDArray[np.integer],
    is_open: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Exchange areas of the row elements with all outside, and with the sky, (n_rows,) [m²]; 0 in closed spaces.

    What no other element receives, and the share of rays that left the scene, are two estimates of one number: they
    are weighted with their inverse variances. So exact form factors need no rays, and poor ones do not make a room
    darker that has a window. Rays tell which part is sky; where an element has none that left, those of its space do.

    Parameters
    ----------
    received, error : (n_rows,) float64 [m²]
        Exchange of each row element with all others, and how far off it may be.
    space : (n_rows,) int
    is_open : (n_spaces,) bool
        Where rays were found before to leave the scene.
    """
    area, outside, sky = seen_areas(hits, elements)
    n = len(is_open)
    out_of_space = np.bincount(space, weights=outside, minlength=n)
    up_from_space = np.bincount(space, weights=sky, minlength=n)
    leaves = (is_open | (out_of_space > 0.0))[space]
    rays = (hits.row != COVERED).sum(axis=1)
    # One ray more that half left: no share of few rays is sure.
    share = (np.divide(outside, area, out=np.zeros(len(area)), where=area > 0.0) * rays + 0.5) / (rays + 1.0)
    variance = area**2 * share * (1.0 - share) / np.maximum(rays, 1)
    total = variance + error**2
    trust = np.divide(variance, total, out=np.ones_like(total), where=total > 0.0)
    mixed = np.where(leaves, np.maximum(outside + trust * (area - received - outside), 0.0), 0.0)
    of_space = np.divide(up_from_space, out_of_space, out=np.zeros(n), where=out_of_space > 0.0)
    upwards = np.divide(sky, outside, out=of_space[space], where=outside > 0.0)
    return mixed, mixed * upwards
