"""What points receive from a flat polygon, in float64: Lambert's formula, and the area integral."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def points_to_polygon(
    points: NDArray[np.float64], normals: NDArray[np.float64], polygon: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Form factors of surface elements to a convex polygon, without obstacles.

    Lambert's formula over the part of the polygon above each horizon; its edges are vectors of their own, so that
    small far polygons keep their digits. Positive whatever the winding: it is for the caller to know that the points
    are in front of the polygon.

    Parameters
    ----------
    points, normals : (n, 3) float64
        Places [m] and unit normals.
    polygon : (k, 3) float64
        Corners in order [m].

    Returns
    -------
    (n,) float64
    """
    corner = polygon - points[:, None]
    height = np.einsum("nkd,nd->nk", corner, normals)
    height_after = np.roll(height, -1, axis=1)
    side = np.roll(polygon, -1, axis=0) - polygon
    crosses = (height < 0.0) != (height_after < 0.0)
    cut = np.divide(height, height - height_after, out=np.zeros_like(height), where=crosses)
    below = (height < 0.0) & (height_after < 0.0)
    first = np.where(height < 0.0, cut, 0.0)
    last = np.where(height_after < 0.0, cut, 1.0)
    edge = np.where(below, 0.0, last - first)[..., None] * side
    total = _edge_terms(normals[:, None], corner + first[..., None] * side, edge).sum(axis=1)
    crossing = corner + cut[..., None] * side
    entry = np.where((crosses & (height < 0.0))[..., None], crossing, 0.0).sum(axis=1)
    leave = np.where((crosses & (height >= 0.0))[..., None], crossing, 0.0).sum(axis=1)
    total = total + _edge_terms(normals, leave, entry - leave)
    factor: NDArray[np.float64] = np.abs(total) / (2.0 * np.pi)
    return factor


def _edge_terms(
    normal: NDArray[np.float64], start: NDArray[np.float64], edge: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Angle under which each edge is seen, times the cosine between the normal and the plane's normal."""
    across = np.cross(start, edge)
    sine = np.linalg.norm(across, axis=-1)
    cosine = np.einsum("...d,...d->...", start, start + edge)
    along = np.einsum("...d,...d->...", across, np.broadcast_to(normal, across.shape))
    terms: NDArray[np.float64] = np.divide(
        along * np.arctan2(sine, cosine), sine, out=np.zeros_like(sine), where=sine > 0.0
    )
    return terms


def point_to_patch(
    point: NDArray[np.float64],
    normal: NDArray[np.float64],
    origin: NDArray[np.float64],
    edge_u: NDArray[np.float64],
    edge_v: NDArray[np.float64],
    *,
    triangle: bool = False,
    order: int = 40,
) -> float:
    """Form factor of a surface element to the front of a parallelogram or triangle, by Gauss points on its area.

    Both cosines are clamped at 0, so the result converges slowly where the horizon crosses the patch. Triangles by
    Duffy's map (Duffy 1982).
    """
    node, weight = gauss(order)
    u, v = np.meshgrid(node, node, indexing="ij")
    w = np.outer(weight, weight)
    if triangle:
        w = w * (1.0 - u)
        v = v * (1.0 - u)
    across = np.cross(edge_u, edge_v)
    r = origin - point + u[..., None] * edge_u + v[..., None] * edge_v
    received = np.maximum(r @ normal, 0.0) * np.maximum(-(r @ across), 0.0)
    squared = np.einsum("ijd,ijd->ij", r, r)
    return float(np.einsum("ij,ij->", w, received / squared**2) / np.pi)


def gauss(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights of Gauss–Legendre quadrature on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(order)
    return 0.5 + 0.5 * x, 0.5 * w
