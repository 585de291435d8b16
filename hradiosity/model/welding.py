"""Which corners are the same point: the first step of everything that looks at edges."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

WELD_TOLERANCE: Final = 1e-7
"""Points closer than this, relative to the diagonal of the bounding box, are one point (1 µm in a 10 m room)."""


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
    from scipy.spatial import cKDTree

    if distance == 0.0:
        return np.zeros(len(points), dtype=np.int64)
    cell = np.round((points - points.min(axis=0)) / distance).astype(np.int64)
    number = cell[:, 0]
    for axis in (1, 2):
        span = int(cell[:, axis].max()) + 1
        number = np.unique(number, return_inverse=True)[1] * span + cell[:, axis]
    _, first, number = np.unique(number, return_index=True, return_inverse=True)
    pairs = cKDTree(points[first]).query_pairs(distance, output_type="ndarray")
    return connected(pairs[:, 0], pairs[:, 1], len(first))[number]


def connected(first: NDArray[np.integer], second: NDArray[np.integer], n: int) -> NDArray[np.int64]:
    """(n,) component numbers, counted by first member, of the graph of n nodes with edges first — second."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
