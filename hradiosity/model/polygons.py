"""One polygon from a scene file, cut into patches."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.meshing import Pieces, merge_triangles

WARP_WORTH_A_WARNING: Final = 1e-3
"""`planarity_defect` that goes without a word."""
_FLAT: Final = 1e-10
"""Twice the area of a triangle relative to the squared size, or a distance relative to the size, that counts as 0."""


def newell_normal(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) vector area of a polygon, also of one that isn't plane: its length is the area [m²] (Newell's method)."""
    centred = vertices - vertices.mean(axis=0)
    return np.asarray(0.5 * np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0), dtype=np.float64)


def planarity_defect(vertices: NDArray[np.float64]) -> float:
    """Largest distance of a corner from the mean plane, relative to the polygon's size; 0 for a triangle.

    Parameters
    ----------
    vertices : (n, 3) float64 [m]

    Raises
    ------
    ValueError
        When the polygon has no area.
    """
    centred, normal, size = _frame(vertices)
    return float(np.abs(centred @ normal).max() / size)


def polygon_to_patches(vertices: NDArray[np.float64]) -> Pieces:
    """Cut a simple polygon, convex or not, into parallelograms and triangles of one surface.

    Ears with the shortest new edge are cut off first (ear clipping: Meisters, American Mathematical Monthly 82,
    1975), seen along the mean normal; then pairs that form parallelograms are joined. A quad that isn't plane is
    so split along its shorter diagonal that stays inside: ask ``planarity_defect`` how much it was bent. No corner
    is added or left out, so that neighbours keep whole common edges.

    Parameters
    ----------
    vertices : (n, 3) float64 [m]
        Corners in order, counter-clockwise as seen from the front; the first one isn't repeated at the end.

    Raises
    ------
    ValueError
        Fewer than three corners, no area, a corner that coincides with the next one, or edges that cross.
    """
    triangles = triangulate(vertices)
    pieces = merge_triangles(vertices, triangles)
    return pieces._replace(surface=np.zeros(len(pieces.surface), dtype=np.int32))


def triangulate(vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n - 2, 3) corner numbers of the triangles of a simple polygon; see ``polygon_to_patches``."""
    centred, normal, size = _frame(vertices)
    axis = np.eye(3)[np.abs(normal).argmin()]
    along = np.cross(normal, axis)
    along /= np.linalg.norm(along)
    flat = np.stack([centred @ along, centred @ np.cross(normal, along)], axis=1) / size
    if len(flat) > 3 and _crosses_itself(flat):
        raise ValueError("edges of the polygon cross each other")
    remaining = np.arange(len(flat))
    triangles = []
    while len(remaining) > 3:
        ear = _next_ear(flat[remaining])
        triangles.append(np.roll(remaining, 1 - ear)[:3])
        remaining = np.delete(remaining, ear)
    triangles.append(remaining)
    return np.array(triangles, dtype=np.int64)


def _frame(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Corners from their mean, unit normal, and size [m] (largest distance from the mean)."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 3:
        raise ValueError(f"a polygon needs at least three corners of three coordinates, got shape {vertices.shape}")
    centred = vertices - vertices.mean(axis=0)
    size = float(np.linalg.norm(centred, axis=1).max())
    steps = np.linalg.norm(np.roll(vertices, -1, axis=0) - vertices, axis=1)
    if not steps.min() > _FLAT * size:
        raise ValueError(f"corner {int(steps.argmin())} of the polygon coincides with the next one")
    area = newell_normal(vertices)
    length = float(np.linalg.norm(area))
    if not length > _FLAT * size * size:
        raise ValueError("the polygon has no area: its corners lie on a line, or its edges cross")
    return centred, area / length, size


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twice the signed area of triangles a b c in the plane, positive when counter-clockwise; broadcasts."""
    first, second = b - a, c - a
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0], dtype=np.float64)


def _crosses_itself(flat: NDArray[np.float64]) -> bool:
    """Whether two edges cross at an inner point of both; (n, 2) corners. Edges that only touch are let pass."""
    end = np.roll(flat, -1, axis=0)
    from_here = _turn(flat[:, None], end[:, None], flat[None])
    to_there = _turn(flat[:, None], end[:, None], end[None])
    parted = ((from_here > _FLAT) & (to_there < -_FLAT)) | ((from_here < -_FLAT) & (to_there > _FLAT))
    return bool((parted & parted.T).any())


def _next_ear(flat: NDArray[np.float64]) -> int:
    """The corner to cut off next: convex, nothing inside its triangle, shortest new edge; flat: (k, 2)."""
    before, after = np.roll(flat, 1, axis=0), np.roll(flat, -1, axis=0)
    convex = np.flatnonzero(_turn(before, flat, after) > _FLAT)
    length = np.round(np.linalg.norm(after - before, axis=1), 9)
    for corner in convex[np.argsort(length[convex], kind="stable")]:
        a, b, c = before[corner], flat[corner], after[corner]
        inside = (_turn(a, b, flat) >= -_FLAT) & (_turn(b, c, flat) >= -_FLAT) & (_turn(c, a, flat) >= -_FLAT)
        distance = np.abs(flat[:, None] - np.stack([a, b, c])).max(axis=2).min(axis=1)
        if not (inside & (distance > _FLAT)).any():
            return int(corner)
    raise ValueError("the polygon can't be cut into triangles: its edges touch or cross each other")
