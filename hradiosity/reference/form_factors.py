"""Form factors between two surfaces: closed forms, and quadrature for any pair of convex polygons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.reference.point_factors import gauss, points_to_polygon


def parallel_rectangles(width: float, depth: float, distance: float) -> float:
    """F between equal, aligned, parallel rectangles (Howell's catalogue, C-11)."""
    x, y = width / distance, depth / distance
    root_x, root_y = np.sqrt(1.0 + x * x), np.sqrt(1.0 + y * y)
    total = (
        0.5 * np.log((1.0 + x * x) * (1.0 + y * y) / (1.0 + x * x + y * y))
        + x * root_y * np.arctan(x / root_y)
        + y * root_x * np.arctan(y / root_x)
        - x * np.arctan(x)
        - y * np.arctan(y)
    )
    return float(2.0 * total / (np.pi * x * y))


def perpendicular_rectangles(common: float, depth: float, height: float) -> float:
    """F from a rectangle common × depth to one common × height, at right angles along the common edge (C-14)."""
    w, h = depth / common, height / common
    w2, h2 = w * w, h * h
    both = w2 + h2
    ratio = (
        np.log((1.0 + w2) * (1.0 + h2) / (1.0 + both))
        + w2 * np.log(w2 * (1.0 + both) / ((1.0 + w2) * both))
        + h2 * np.log(h2 * (1.0 + both) / ((1.0 + h2) * both))
    )
    root = np.sqrt(both)
    total = w * np.arctan(1.0 / w) + h * np.arctan(1.0 / h) - root * np.arctan(1.0 / root) + 0.25 * ratio
    return float(total / (np.pi * w))


def hinged_squares(angle: float) -> float:
    """F between unit squares with a common edge and an angle [rad] between them, by one sum of Gauss points.

    F = sin² φ / π ∫∫ s t arctan(1/ρ) / ρ³ ds dt over the distances from the edge, ρ² = s² + t² − 2 s t cos φ; in polar
    coordinates the radial integral is closed. Nothing cancels next to 180°; below some degrees the sum is too coarse.
    """
    node, weight = gauss(64)
    polar = 0.25 * np.pi * node
    product = np.cos(polar) * np.sin(polar)
    k = np.sqrt(1.0 - 2.0 * product * np.cos(angle))
    reach = 1.0 / np.cos(polar)
    radial = reach * np.arctan2(1.0, k * reach) + np.log1p((k * reach) ** 2) / (2.0 * k)
    return float(0.5 * np.sin(angle) ** 2 * np.einsum("p,p->", weight, product / k**3 * radial))


def coaxial_disks(radius: float, other_radius: float, distance: float) -> float:
    """F from a disk to a parallel one on the same axis (C-41)."""
    a, b = radius / distance, other_radius / distance
    x = 1.0 + (1.0 + b * b) / (a * a)
    # The smaller root of f² − X f + (b/a)² = 0 in the form that does not cancel.
    return float(2.0 * (b / a) ** 2 / (x + np.sqrt(x * x - 4.0 * (b / a) ** 2)))


def point_to_disk(radius: float, distance: float) -> float:
    """F from a surface element to a parallel disk whose axis goes through it (B-12)."""
    return radius**2 / (radius**2 + distance**2)


def polygon_pair(polygon: NDArray[np.float64], other: NDArray[np.float64], *, tolerance: float = 1e-8) -> float:
    """F from the front of one convex polygon to the front of another, without obstacles.

    Lambert's formula at points of the first polygon, which is cut into triangles from its first corner. The points are
    Gauss points crowded towards the edges, where the integrand has kinks when the polygons touch; their number is
    doubled until two results agree.

    Parameters
    ----------
    polygon, other : (k, 3) float64
        Corners, counter-clockwise seen from the front [m].
    tolerance : float
        Relative change at which to stop.

    Raises
    ------
    RuntimeError
        When 256 points a direction do not reach the tolerance.
    """
    before = np.inf
    for order in (16, 32, 64, 128, 256):
        now = _averaged(polygon, other, order)
        if abs(now - before) <= tolerance * abs(now):
            return now
        before = now
    raise RuntimeError(f"the form factor {now} did not settle within {tolerance:.1e}")


def _averaged(polygon: NDArray[np.float64], other: NDArray[np.float64], order: int) -> float:
    """Mean over the polygon of Lambert's factor, 0 where a point lies behind the other polygon."""
    node, weight = gauss(order)
    # x = t³ (10 − 15 t + 6 t²) maps [0, 1] onto itself and leaves and arrives with slope and curvature 0.
    weight = weight * 30.0 * node**2 * (1.0 - node) ** 2
    node = node**3 * (10.0 - 15.0 * node + 6.0 * node**2)
    s, t = (grid.ravel() for grid in np.meshgrid(node, node, indexing="ij"))
    share = np.outer(weight, weight).ravel() * (1.0 - s)
    normal = _unit(np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0]))
    other_normal = np.cross(other[1] - other[0], other[2] - other[0])
    total, area = 0.0, 0.0
    for b, c in zip(polygon[1:-1] - polygon[0], polygon[2:] - polygon[0]):
        twice_area = float(np.linalg.norm(np.cross(b, c)))
        points = polygon[0] + s[:, None] * b + ((1.0 - s) * t)[:, None] * c
        front = (points - other[0]) @ other_normal > 0.0
        factor = points_to_polygon(points, np.broadcast_to(normal, points.shape), other)
        total += twice_area * float(np.einsum("n,n->", share, np.where(front, factor, 0.0)))
        area += 0.5 * twice_area
    return total / area


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vector / np.linalg.norm(vector)
    return unit
