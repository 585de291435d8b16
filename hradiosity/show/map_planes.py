"""The flat surfaces of a map, each laid out as seen from its front."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.surface_map import SurfaceMap
from hradiosity.space.leaf_fan import EDGE_ENDS
from hradiosity.space.leaves import CENTRE, NONE

_SAME: Final = 1e-4
"""Normals, and distances over the extent, that differ by less are one plane."""
_LEVEL: Final = 0.999


@dataclass(frozen=True)
class MapPlane:
    """Leaves in one plane.

    name : where it faces and lies
    axis_names : of both axes, with units
    leftwards : the first axis runs to the left, as seen from the front
    points : (n, 2) float64 [m]
    triangles : (m, 3) int64
    lux : (n,) float64
    area : [m²]
    """

    name: str
    axis_names: tuple[str, str]
    leftwards: bool
    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    lux: NDArray[np.float64]
    area: float


def map_planes(found: SurfaceMap) -> list[MapPlane]:
    """The planes that a map's leaves lie in, the largest first."""
    normal, middle, area = found.leaf_normal, found.leaf_middle, found.leaf_area
    if not len(area):
        return []
    extent = max(float(np.ptp(middle, axis=0).max()), 1e-9)
    offset = np.einsum("ij,ij->i", normal, middle) / extent
    keys = np.round(np.column_stack([normal, offset]) / _SAME).astype(np.int64)
    _, plane = np.unique(keys, axis=0, return_inverse=True)
    plane = plane.ravel()
    order = np.argsort(-np.bincount(plane, area), kind="stable")
    return [_plane(found, np.flatnonzero(plane == number), area) for number in order]


def _plane(found: SurfaceMap, leaves: NDArray[np.int64], area: NDArray[np.float64]) -> MapPlane:
    """One of them; a vertex inside of something has the light of the other two of each triangle."""
    normal = found.leaf_normal[leaves[0]]
    across, up, axis_names, leftwards = _axes(normal)
    corners = fan_triangles(found)[leaves]
    corners = corners[(corners >= 0).all(axis=2)]
    covered = found.shadow.covered[corners]
    corners, covered = corners[~covered.all(axis=1)], covered[~covered.all(axis=1)]
    lux = np.where(covered, 0.0, found.lux[corners])
    lux = np.where(covered, lux.sum(axis=1, keepdims=True) / (~covered).sum(axis=1, keepdims=True), lux)
    position = found.shadow.position[corners.ravel()]
    return MapPlane(
        name=_name(normal, position),
        axis_names=axis_names,
        leftwards=leftwards,
        points=np.column_stack([position @ across, position @ up]),
        triangles=np.arange(corners.size).reshape(-1, 3),
        lux=lux.ravel(),
        area=float(area[leaves].sum()),
    )


def fan_triangles(found: SurfaceMap) -> NDArray[np.int64]:
    """(n_leaves, 8, 3) vertices of the triangles around the centre of each leaf; NONE for those that it lacks."""
    leaves = np.flatnonzero(found.shadow.leaves.is_leaf)
    vertex = found.shadow.vertex[leaves].astype(np.int64)
    triangle = found.shadow.leaves.is_triangle[leaves].astype(np.int64)
    ends = EDGE_ENDS[triangle]
    first, last = (np.take_along_axis(vertex, ends[:, :, end], axis=1) for end in range(2))
    middle, centre = vertex[:, CENTRE + 1 :], np.repeat(vertex[:, CENTRE : CENTRE + 1], 4, axis=1)
    cut = middle != NONE
    halves = np.stack([centre, first, np.where(cut, middle, last)], axis=2)
    others = np.where(cut[:, :, None], np.stack([centre, middle, last], axis=2), NONE)
    halves[triangle == 1, 3] = others[triangle == 1, 3] = NONE
    return np.concatenate([halves, others], axis=1)


def _axes(
    normal: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], tuple[str, str], bool]:
    """Axes across and up, their names, and whether the first runs to the left: x and y of what lies level, else as seen
    from the front.
    """
    if abs(normal[2]) > _LEVEL:
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), ("x, m", "y, m"), False
    across = np.array([-normal[1], normal[0], 0.0])
    across /= np.linalg.norm(across)
    up = np.cross(normal, across)
    second = "z, m" if abs(normal[2]) < 1.0 - _LEVEL else "up along the surface, m"
    axis = int(np.argmax(np.abs(across)))
    if abs(across[axis]) < _LEVEL:
        return across, up, ("to the right, m", second), False
    return np.abs(across), up, (f"{'xyz'[axis]}, m", second), bool(across[axis] < 0.0)


def _name(normal: NDArray[np.float64], position: NDArray[np.float64]) -> str:
    """Such as "faces up, z = 0 m"."""
    axis = int(np.argmax(np.abs(normal)))
    if abs(normal[axis]) > _LEVEL:
        words = ("−x", "+x", "−y", "+y", "down", "up")[2 * axis + int(normal[axis] > 0.0)]
        return f"faces {words}, {'xyz'[axis]} = {round(float(position[:, axis].mean()), 3) + 0.0:g} m"
    return "faces ({:.2f}, {:.2f}, {:.2f})".format(*normal)
