"""What lies under the mouse: rays against all cells, with the faces and the section that the window shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells
from hradiosity.show.window.navigation import Pose

REACH: Final = 9.0
"""Pixels by which a click may miss a sensor."""
_HIDDEN: Final = 1e-3
"""By how much a sensor may lie behind what is seen, over the distance: those on a surface are seen."""


@dataclass(frozen=True)
class CutPlane:
    """Hides points with ``normal · point > offset``.

    normal : (3,) float64, unit
    offset : float [m]
    """

    normal: NDArray[np.float64]
    offset: float

    def hides(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) of points (n, 3)."""
        hidden: NDArray[np.bool_] = np.einsum("nk,k->n", points, self.normal) > self.offset
        return hidden


@dataclass(frozen=True)
class Picked:
    """kind : "cell" or "sensor"; number : of it; point : (3,) float64 [m]."""

    kind: str
    number: int
    point: NDArray[np.float64]


def pick_cell(
    cells: Cells, origin: NDArray[np.float64], direction: NDArray[np.float64], plane: CutPlane | None
) -> tuple[int, float]:
    """Nearest cell that faces a ray, and how far along the ray; −1 and inf where there is none.

    Möller & Trumbore (1997) on parallelograms and triangles.
    """
    near = _near_ray(cells, origin, direction)
    first, triangle = cells.first_corner[near], cells.is_triangle[near]
    edge_u = cells.corners[near, 1] - first
    edge_v = cells.corners[near, np.where(triangle, 2, 3)] - first
    normal = np.cross(edge_u, edge_v)
    slope = np.einsum("nk,k->n", normal, direction)
    faces = slope < 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = first - origin
        along = np.einsum("nk,nk->n", offset, normal) / slope
        turned = np.cross(offset, direction)
        s = np.einsum("nk,nk->n", edge_v, turned) / slope
        t = -np.einsum("nk,nk->n", edge_u, turned) / slope
        inside = (s >= 0.0) & (t >= 0.0) & np.where(triangle, s + t <= 1.0, (s <= 1.0) & (t <= 1.0))
    met = np.flatnonzero(faces & (along > 0.0) & inside)
    if plane is not None:
        met = met[~plane.hides(origin + along[met, None] * direction)]
    if not len(met):
        return -1, float("inf")
    nearest = met[np.argmin(along[met])]
    return int(near[nearest]), float(along[nearest])


def _near_ray(cells: Cells, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cells whose spheres about their first corners meet the line of a ray, with a little more for rounding."""
    offset = cells.first_corner - origin
    along = np.einsum("nk,k->n", offset, direction)
    square = np.einsum("nk,nk->n", offset, offset)
    reach = cells.reach * (1.0 + _HIDDEN)
    return np.flatnonzero(square - along * along <= reach * reach + 1e-12 * square)


def pick(
    cells: Cells,
    sensors: NDArray[np.float64],
    pose: Pose,
    place: tuple[float, float],
    size: tuple[int, int],
    plane: CutPlane | None,
) -> Picked | None:
    """What is seen at a place of the window.

    Parameters
    ----------
    cells : Cells
    sensors : (n, 3) float64 [m]
        Shown points; they win over surfaces, as they are small.
    pose : Pose
    place : x, y in pixels from the lower left corner
    size : width and height in pixels
    plane : CutPlane, optional
    """
    x, y = (np.array(value, np.float64) for value in place)
    direction = pose.rays(x, y, *size)
    cell, along = pick_cell(cells, pose.position, direction, plane)
    depth = along * float(np.einsum("k,k->", direction, pose.forward))
    miss = np.linalg.norm(pose.project(sensors, *size) - np.array(place), axis=1)
    far = np.einsum("nk,k->n", sensors - pose.position, pose.forward)
    seen = (miss <= REACH) & (far <= depth * (1.0 + _HIDDEN))
    if plane is not None:
        seen &= ~plane.hides(sensors)
    if seen.any():
        number = int(np.argmin(np.where(seen, miss, np.inf)))
        return Picked("sensor", number, sensors[number])
    return None if cell < 0 else Picked("cell", cell, pose.position + along * direction)
