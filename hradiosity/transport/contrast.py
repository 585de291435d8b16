"""How much the light that surfaces receive differs between directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.hierarchy import COVERED, UNLIT, Elements
from hradiosity.transport.exchange import RowHits

MOST_CONTRAST = 5.0
"""Contrast of the received light from which on the solution is looked up there at a first hit that is near, too: where
light comes through a gap, the noise of one more ray is worse than one value for a whole element."""


def side_contrast(
    hits: RowHits,
    side: NDArray[np.integer],
    area: NDArray[np.float64],
    leaving: NDArray[np.float64],
    arriving: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(n_rows,) variance of what one ray from a row brings, over the square of the light that the row receives.

    Taken over all rows of a patch side together, so that it does not follow the luck of a single row's few rays.

    Parameters
    ----------
    hits : RowHits
    side : (n_rows,) int
        2 · patch + side that each row lies on.
    area : (n_rows,) float64
        Exposed area [m²].
    leaving : (n_rows,) float64
        Brightness of what the rows reflect.
    arriving : (n_rows,) float64
        Brightness of their irradiance, direct light included.
    """
    n = len(leaving)
    brought = np.append(leaving, 0.0)[np.where(hits.row < UNLIT, hits.row, n).astype(np.int64)]
    counts = hits.share
    exposed = np.maximum((counts * (hits.row != COVERED)).sum(axis=1), 0.5 / hits.row.shape[1])
    label = np.unique(side, return_inverse=True)[1].ravel()
    total = np.bincount(label, area)
    mean = np.bincount(label, area * (counts * brought).sum(axis=1) / exposed)
    square = np.bincount(label, area * (counts * brought**2).sum(axis=1) / exposed)
    received = np.bincount(label, area * arriving)
    variance = np.maximum(square * total - mean**2, 0.0)
    contrast: NDArray[np.float64] = np.divide(variance, received**2, out=np.zeros(len(total)), where=received > 0.0)
    of_rows: NDArray[np.float64] = contrast[label]
    return of_rows


def lookup_sizes(
    hits: RowHits,
    elements: Elements,
    area: NDArray[np.float64],
    leaving: NDArray[np.float64],
    arriving: NDArray[np.float64],
) -> NDArray[np.float32]:
    """(n_rows,) edge of each element [m] as paths take it, see `hradiosity.readings.surface_light.SurfaceLight`.

    Below 0 where light comes from so few directions that one more ray mostly misses it, infinite where all is covered.
    Parameters are those of `side_contrast`.
    """
    side = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    contrast = side_contrast(hits, side, area, leaving, arriving)
    size = np.where(contrast > MOST_CONTRAST, -1.0, 1.0) * np.sqrt(elements.area)
    return np.where(area > 0.0, size, np.inf).astype(np.float32)
