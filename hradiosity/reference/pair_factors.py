"""What the methods for pairs of polygons approximate, written plainly: float64, no cases, no care for speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.reference.point_factors import gauss


def area_pair(polygon: NDArray[np.float64], other: NDArray[np.float64], order: int) -> float:
    """A F [m²] by ``order**4`` Gauss points on each pair of triangles, both cosines clamped at 0."""
    total = 0.0
    for x, weight_x, normal_x in _triangle_points(polygon, order):
        for y, weight_y, normal_y in _triangle_points(other, order):
            d = y[None] - x[:, None]
            cosines = np.maximum(d @ normal_x, 0.0) * np.maximum(-(d @ normal_y), 0.0)
            squared = np.einsum("pqd,pqd->pq", d, d)
            total += float(np.einsum("p,q,pq->", weight_x, weight_y, cosines / squared**2))
    return total / np.pi


def _triangle_points(
    polygon: NDArray[np.float64], order: int
) -> list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Points, weights [m²] and normal of each triangle of the fan about the first corner (Duffy's map)."""
    node, weight = gauss(order)
    s, t = (grid.ravel() for grid in np.meshgrid(node, node, indexing="ij"))
    share = np.outer(weight, weight).ravel() * s
    parts = []
    for b, c in zip(polygon[1:-1] - polygon[0], polygon[2:] - polygon[0]):
        across = np.cross(b, c)
        twice_area = float(np.linalg.norm(across))
        points = polygon[0] + s[:, None] * (b + t[:, None] * (c - b))
        parts.append((points, share * twice_area, across / twice_area))
    return parts


def contour_pair(polygon: NDArray[np.float64], other: NDArray[np.float64], order: int) -> float:
    """A F [m²] by the double contour integral with Gauss points on both edges: for polygons that do not touch."""
    node, weight = gauss(order)
    total = 0.0
    for start, edge in zip(polygon, np.roll(polygon, -1, axis=0) - polygon):
        for other_start, other_edge in zip(other, np.roll(other, -1, axis=0) - other):
            p = start + node[:, None] * edge
            q = other_start + node[:, None] * other_edge
            log = 0.5 * np.log(((p[:, None] - q[None]) ** 2).sum(axis=2))
            total += float(edge @ other_edge) * float(np.einsum("i,j,ij->", weight, weight, log))
    return total / (2.0 * np.pi)


def edge_pair(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    other_start: NDArray[np.float64],
    other_end: NDArray[np.float64],
) -> float:
    """Double integral of ln|p − q| along two edges [m²], no closed form in it.

    Double-exponential points on both (Takahasi & Mori 1974), on the second one either side of the point nearest to each
    point of the first, on the first between the places where the second one begins, ends or passes by.
    """
    edge, other_edge = end - start, other_end - other_start
    length, other_length = float(np.linalg.norm(edge)), float(np.linalg.norm(other_edge))
    lines = np.stack([edge, -other_edge], axis=1)
    crossing = np.linalg.lstsq(lines, other_start - start, rcond=None)[0][0]
    places = [(corner - start) @ edge / length**2 for corner in (other_start, other_end)]
    cuts = np.clip(np.sort([0.0, 1.0, crossing, *places]), 0.0, 1.0)
    node, weight = _double_exponential()
    s = (cuts[:-1, None] + np.diff(cuts)[:, None] * node).ravel()
    share = np.outer(np.diff(cuts), weight).ravel()
    p = start + s[:, None] * edge
    nearest = np.clip((p - other_start) @ other_edge / other_length**2, 0.0, 1.0)
    foot = other_start + nearest[:, None] * other_edge
    total = 0.0
    for reach in (-nearest, 1.0 - nearest):
        # Distances from the nearest point: its own is kept apart, so that none is a difference of large numbers.
        step = reach[:, None, None] * node[:, None] * other_edge
        squared = (((p - foot)[:, None] - step) ** 2).sum(axis=2)
        log = 0.5 * np.log(np.maximum(squared, 1e-300))
        total += float(np.einsum("i,i,j,ij->", share, np.abs(reach), weight, log))
    return total * length * other_length


def _double_exponential() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes on [0, 1], next to 0 with all digits, and weights."""
    t = np.arange(-3.5, 3.5 + 1e-9, 1.0 / 16.0)
    node = 1.0 / (1.0 + np.exp(np.pi * np.sinh(t)))
    return node, np.pi * np.cosh(t) * node * (1.0 - node) / 16.0


def chord_projection(
    point: NDArray[np.float64], normal: NDArray[np.float64], polygon: NDArray[np.float64], chords: int
) -> float:
    """Form factor of a point to a polygon wholly above its horizon, from the flat polygon whose corners divide each
    projected edge into equal angles: its area seen from above, over π.
    """
    direction = polygon - point
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    corners = []
    for u, v in zip(direction, np.roll(direction, -1, axis=0)):
        angle = np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)
        share = np.arange(chords)[:, None] / chords
        corners.append((np.sin((1.0 - share) * angle) * u + np.sin(share * angle) * v) / np.sin(angle))
    ring = np.concatenate(corners)
    return float(abs(0.5 * np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) @ normal) / np.pi)
