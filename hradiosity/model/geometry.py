"""Flat patches: the parallelograms and triangles that a scene is made of."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FRONT: Final = 0
"""Side that the normal (edge_u × edge_v) points away from."""
BACK: Final = 1
"""The other side."""
NONE: Final = -1
"""No emitter, no solid."""


@dataclass(frozen=True)
class Patches:
    """Flat surfaces, one row each; all coordinates in metres, world frame, z up.

    A parallelogram is ``origin + u edge_u + v edge_v`` with u, v in [0, 1]; a triangle is the half of it with
    u + v <= 1. The normal is along ``edge_u × edge_v``.

    origin : (n, 3) float64 [m]
    edge_u, edge_v : (n, 3) float64 [m]
    is_triangle : (n,) bool
    material : (n,) int32, index into ``Scene.materials``
    object : (n,) int32, index into ``Scene.objects`` (names)
    surface : (n,) int32, the polygon that the patch was cut from: pictures have no seam inside one
    solid : (n,) int32, number of the closed outward-facing shell that the patch belongs to, or NONE; behind the
        patches of a solid there is matter, and no light
    """

    origin: NDArray[np.float64]
    edge_u: NDArray[np.float64]
    edge_v: NDArray[np.float64]
    is_triangle: NDArray[np.bool_]
    material: NDArray[np.int32]
    object: NDArray[np.int32]
    surface: NDArray[np.int32]
    solid: NDArray[np.int32]

    def __post_init__(self) -> None:
        n = len(self.origin)
        for name in ("origin", "edge_u", "edge_v"):
            if getattr(self, name).shape != (n, 3):
                raise ValueError(f"{name} must have shape ({n}, 3), has {getattr(self, name).shape}")
        for name in ("is_triangle", "material", "object", "surface", "solid"):
            if getattr(self, name).shape != (n,):
                raise ValueError(f"{name} must have shape ({n},), has {getattr(self, name).shape}")

    def __len__(self) -> int:
        return len(self.origin)

    @property
    def area(self) -> NDArray[np.float64]:
        """(n,) area [m²]."""
        whole: NDArray[np.float64] = np.linalg.norm(np.cross(self.edge_u, self.edge_v), axis=1)
        area: NDArray[np.float64] = np.where(self.is_triangle, 0.5 * whole, whole)
        return area

    @property
    def normal(self) -> NDArray[np.float64]:
        """(n, 3) unit normal of the front side; 0 for a degenerate patch."""
        cross = np.cross(self.edge_u, self.edge_v)
        length = np.linalg.norm(cross, axis=1, keepdims=True)
        normal: NDArray[np.float64] = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0)
        return normal

    @property
    def centroid(self) -> NDArray[np.float64]:
        """(n, 3) centre of area [m]."""
        share = np.where(self.is_triangle, 1.0 / 3.0, 0.5)[:, None]
        return self.origin + share * (self.edge_u + self.edge_v)

    def corners(self) -> NDArray[np.float64]:
        """(n, 4, 3) corners in order around the patch [m]; a triangle repeats its last corner."""
        u_end, v_end = self.origin + self.edge_u, self.origin + self.edge_v
        opposite = np.where(self.is_triangle[:, None], v_end, u_end + self.edge_v)
        return np.stack([self.origin, u_end, opposite, v_end], axis=1)

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner (3,) of everything [m]; the origin when there is nothing."""
        if not len(self):
            return np.zeros(3), np.zeros(3)
        corners = self.corners().reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)
