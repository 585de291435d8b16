"""What row elements exchange with the outside where form factors tell of each other only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def remaining_outside(
    received: NDArray[np.float64],
    element_area: NDArray[np.float64],
    outside: NDArray[np.float64],
    sky: NDArray[np.float64],
    space: NDArray[np.integer],
    is_open: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Exchange areas with all outside and with the sky: in open spaces all that no other element receives.

    Rays tell which part of it is sky; where an element has none that left the scene, those of its space do.

    Parameters
    ----------
    received : (n_rows,) float64 [m²]
        Exchange of each row element with all others.
    element_area, outside, sky : (n_rows,) float64 [m²]
        As the rays of the elements found them, see `hradiosity.transport.exchange.seen_areas`.
    space : (n_rows,) int
    is_open : (n_spaces,) bool
        Where rays were found before to leave the scene.
    """
    n = len(is_open)
    out_of_space = np.bincount(space, weights=outside, minlength=n)
    up_from_space = np.bincount(space, weights=sky, minlength=n)
    leaves = (is_open | (out_of_space > 0.0))[space]
    rest = np.where(leaves, np.maximum(element_area - received, 0.0), 0.0)
    of_space = np.divide(up_from_space, out_of_space, out=np.zeros(n), where=out_of_space > 0.0)
    share = np.divide(sky, outside, out=of_space[space], where=outside > 0.0)
    return rest, rest * share
