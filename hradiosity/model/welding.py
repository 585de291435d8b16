"""Which corners are the same point: the first step of everything that looks at edges."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

WELD_TOLERANCE: Final = 1e-7
"""Points closer than this, relative to the diagonal of the bounding box, are one point (1 µm in a 10 m room)."""

FEW: Final = 256
"""Points that are all compared with each other, so that small polygons need no search tree."""


def weld_distance(points: NDArray[np.float64], tolerance: float = WELD_TOLERANCE) -> float:
    """Absolute distance [m] that ``tolerance`` means for these (n, 3) points; 0 without points."""
    if len(points) == 0:
        return 0.0
    return tolerance * float(np.linalg.norm(np.ptp(points, axis=0)))


def weld(points: NDArray[np.float64], distance: float) -> NDArray[np.int64]:
    """Number points so that those within ``distance`` of each other share a number.

    Points are first rounded to cells of that size, then cells whose representatives lie within it are joined, so
    that two points on both sides of a cell boundary are still one. Joining is transitive.

    Parameters
    ----------
    points : (n, 3) float64
        Finite coordinates in any unit.
    distance : float
        In the unit of the points; at least 1e-15 of their extent, or 0 when all are one point.

    Returns
    -------
    (n,) int64
        Numbers 0 … number of distinct points - 1, in an order that depends on the coordinates only.
    """
    if distance == 0.0:
        return np.zeros(len(points), dtype=np.int64)
    cell = np.round((points - points.min(axis=0)) / distance).astype(np.int64)
    number = cell[:, 0]
    for axis in (1, 2):
        span = int(cell[:, axis].max()) + 1
        number = np.unique(number, return_inverse=True)[1] * span + cell[:, axis]
    _, first, number = np.unique(number, return_index=True, return_inverse=True)
    pairs = _close_pairs(points[first], distance)
    return connected(pairs[:, 0], pairs[:, 1], len(first))[number]


def _close_pairs(points: NDArray[np.float64], distance: float) -> NDArray[np.int64]:
    """(m, 2) numbers of points that lie within ``distance`` of each other."""
    if len(points) <= FEW:
        apart = np.linalg.norm(points[:, None] - points, axis=2)
        return np.argwhere(np.triu(apart <= distance, 1))
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(points).query_pairs(distance, output_type="ndarray"), np.int64)


def connected(first: NDArray[np.integer], second: NDArray[np.integer], n: int) -> NDArray[np.int64]:
    """(n,) component numbers, counted by first member, of the graph of n nodes with edges first — second.

    Each component joins the one with the lowest number beside it, which at least halves those that have neighbours,
    until no edge joins two.
    """
    root = np.arange(n)
    one, other = root[first], root[second]
    while (one != other).any():
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while ((above := root[root]) != root).any():
            root = above
        one, other = root[first], root[second]
    return np.unique(root, return_inverse=True)[1].astype(np.int64)
