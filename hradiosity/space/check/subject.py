"""What all checks look at: the scene, its rays, which sides are lit, and sizes computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Scene
from hradiosity.space.bvh import Bvh
from hradiosity.space.lit_sides import LitSides


@dataclass(frozen=True, eq=False)
class Subject:
    """A scene under examination.

    scene : Scene
    bvh : Bvh
        Of the scene's patches.
    lit : LitSides
    seed : of all random rays
    """

    scene: Scene
    bvh: Bvh
    lit: LitSides
    seed: int = 0

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """(n, 4, 3) corners of the patches [m]."""
        return self.scene.patches.corners()

    @cached_property
    def normal(self) -> NDArray[np.float64]:
        """(n, 3) unit normals."""
        return self.scene.patches.normal

    @cached_property
    def area(self) -> NDArray[np.float64]:
        """(n,) areas [m²]."""
        return self.scene.patches.area

    @cached_property
    def centroid(self) -> NDArray[np.float64]:
        """(n, 3) centres of area [m]."""
        return self.scene.patches.centroid

    @cached_property
    def size(self) -> float:
        """Diagonal of the scene's bounding box [m]."""
        low, high = self.scene.patches.bounds()
        return float(np.linalg.norm(high - low))

    @cached_property
    def offset(self) -> float:
        """How far off a surface a ray must start in single precision [m]."""
        local = np.abs(self.corners - self.bvh.local_origin).max(initial=0.0)
        return 2.0**-20 * max(float(local), self.bvh.scale)

    @cached_property
    def longest_edge(self) -> NDArray[np.float64]:
        """(n,) longest edge of each patch [m]."""
        return np.asarray(np.linalg.norm(self.corners - np.roll(self.corners, -1, axis=1), axis=2).max(axis=1))

    @cached_property
    def height(self) -> NDArray[np.float64]:
        """(n,) smallest width of each patch, across its longest edge [m]."""
        twice = np.where(self.scene.patches.is_triangle, 2.0, 1.0) * self.area
        return np.divide(twice, self.longest_edge, out=np.zeros_like(twice), where=self.longest_edge > 0.0)

    @cached_property
    def emits(self) -> NDArray[np.bool_]:
        """(n,) the patch is a lamp."""
        emits = np.zeros(len(self.scene.patches), np.bool_)
        patch = self.scene.emitters.patch
        emits[patch[patch != NONE]] = True
        return emits

    @cached_property
    def reflects_behind(self) -> NDArray[np.bool_]:
        """(n,) the patch's material reflects on its back."""
        return np.array([m.two_sided for m in self.scene.materials], np.bool_)[self.scene.patches.material]

    def name(self, patch: int) -> str:
        """Name of a patch's object."""
        return self.scene.objects[int(self.scene.patches.object[patch])]

    @cached_property
    def owner_of_solid(self) -> NDArray[np.int64]:
        """(n_solids + 1,) object that each solid belongs to; NONE at the end, where index NONE leads."""
        patches = self.scene.patches
        owner = np.full(int(patches.solid.max(initial=NONE)) + 2, NONE, np.int64)
        owner[patches.solid] = patches.object
        owner[NONE] = NONE
        return owner

    def name_of_solid(self, solid: int) -> str:
        """Name of the object that a solid belongs to."""
        return self.scene.objects[int(self.owner_of_solid[solid])]

    def random(self, stream: int) -> np.random.Generator:
        """Random numbers of one check."""
        return np.random.Generator(np.random.Philox(key=[self.seed, stream]))
