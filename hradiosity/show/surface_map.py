"""Illuminance on surfaces as a map whose error is asked for: leaves cut at shadow boundaries, read at their corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import BACK
from hradiosity.show.light import PictureScene, picture_scene
from hradiosity.solution import Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.hierarchy import NONE
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaves import CENTRE
from hradiosity.transport.device_scene import DeviceScene, upload_scene
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.refine import RefinementGoal, RefinementOptions, ShadowLight, refine_shadows

FINEST: Final = 1e-4
"""Edge of the smallest leaves, relative to the scene's half extent."""


@dataclass(frozen=True)
class SurfaceMap:
    """Illuminance on some sides. What is left of a leaf that lies inside of things at all its vertices counts as dark.

    shadow : the leaves, and their vertices
    lux, half_width : (n_vertices,) float64 [lx], 0 where the vertex lies inside of something; half widths of the
        95 % intervals of the readings there, which do not hold the error of interpolation
    """

    solution: Solution
    shadow: ShadowLight
    lux: NDArray[np.float64]
    half_width: NDArray[np.float64]

    @property
    def n_leaves(self) -> int:
        """Number of leaves."""
        return int(self.shadow.leaves.is_leaf.sum())

    @property
    def corners(self) -> NDArray[np.float64]:
        """(n_leaves, 4, 3) corners of the leaves [m]; a triangle repeats its last one."""
        return self.shadow.position[self._leaf_corners]

    @property
    def corner_lux(self) -> NDArray[np.float64]:
        """(n_leaves, 4) illuminance there [lx]; NaN inside of things."""
        return np.where(self.shadow.covered, np.nan, self.lux)[self._leaf_corners]

    @property
    def _leaf_corners(self) -> NDArray[np.int32]:
        return self.shadow.vertex[self.shadow.leaves.is_leaf, :CENTRE]

    def at(
        self, side: NDArray[np.int64], u: NDArray[np.floating], v: NDArray[np.floating], *, flat: bool = False
    ) -> NDArray[np.float64]:
        """(n,) illuminance [lx] at points; NaN where the map has no leaf.

        Parameters
        ----------
        side : (n,) int64
            2 · patch + side.
        u, v : (n,) float
            Along the patch's edges.
        flat : bool
            The mean of each leaf in place of what is interpolated.
        """
        triangles = self.solution.scene.patches.is_triangle
        cell, s, t = locate_cells(self.solution.elements, triangles, side, u, v)
        node, s, t = self.shadow.leaves.locate(cell, s, t)
        known = np.maximum(node, 0)
        if flat:
            vertices = self.shadow.vertex[known, : CENTRE + 1]
            weights = np.where(triangles[side // 2, None], [2, 2, 2, 0, 3], [1, 1, 1, 1, 2]).astype(np.float32)
        else:
            vertices, weights = fan_weights(self.shadow.vertex, known, s, t, triangles[side // 2])
        weights = np.where(self.shadow.covered[vertices], np.float32(0.0), weights)
        total = weights.sum(axis=1)
        value = np.einsum("nk,nk->n", weights, self.lux[vertices]) / np.where(total > 0.0, total, 1.0)
        return np.where(node < 0, np.nan, value)


def map_objects(solution: Solution, device: Device, names: Sequence[str], *, error: float = 0.01) -> SurfaceMap:
    """Map of all sides of some objects that light reaches.

    Parameters
    ----------
    solution : Solution
        Of a solver of this process, since it is read at the corners of the leaves; the samples of its options tell
        the noise there.
    names : sequence of str
        Of the objects, as the scene has them; the floor of a box that is a room is no object of its own.
    error : float
        Root mean square error of the direct light that interpolation may leave, over the mean illuminance.

    Raises
    ------
    ValueError
        When there is no object of a name.
    RuntimeError
        When the solution was not made by a solver of this process.
    """
    scene = solution.scene
    unknown = [name for name in names if name not in scene.objects]
    if unknown:
        raise ValueError(
            f"there is no object {', '.join(map(repr, unknown))}; the scene has {', '.join(scene.objects)}"
        )
    chosen = np.isin(scene.patches.object, [scene.objects.index(name) for name in names])
    sides = np.flatnonzero((solution.elements.first_cell != NONE) & chosen[:, None])
    sampled = sampled_scene(scene, solution.plan.weak_emitters)
    on_device = upload_scene(device, sampled, build_bvh(device, scene.patches), occlusion=solution.plan.occlusion)
    return map_surfaces(
        solution, on_device, sides, RefinementOptions(base_level=0, max_level=10, error=error), FINEST * on_device.scale
    )


def map_surfaces(
    solution: Solution,
    on_device: DeviceScene,
    sides: NDArray[np.int64],
    refinement: RefinementOptions,
    finest: float,
) -> SurfaceMap:
    """Cut leaves on sides, and read the solution at their corners and centres.

    Parameters
    ----------
    solution : Solution
        With a solver behind it; its options tell the effort of each reading.
    sides : (n,) int64
        2 · patch + side of the solution's scene.
    refinement : RefinementOptions
        With ``error`` for a map of that root mean square error of the direct light.
    finest : float
        Edge of leaves that are not split any more [m].
    """
    picture = picture_scene(solution)
    goal = map_goal(picture, solution, sides, finest)
    sampled = sampled_scene(solution.scene, solution.plan.weak_emitters)
    shadow = refine_shadows(on_device, sampled, goal, refinement)
    return read_map(solution, shadow)


def read_map(solution: Solution, shadow: ShadowLight) -> SurfaceMap:
    """Read the solution at the vertices of leaves."""
    patches = solution.scene.patches
    normal = patches.normal[shadow.vertex_side // 2] * np.where(shadow.vertex_side % 2 == BACK, -1.0, 1.0)[:, None]
    free = np.flatnonzero(~shadow.covered)
    lux, half_width = np.zeros((2, len(shadow.covered)))
    if len(free):
        found = solution.read(shadow.position[free], normal[free])
        lux[free], half_width[free] = found.illuminance, found.illuminance_half_width
    return SurfaceMap(solution, shadow, lux, half_width)


def map_goal(picture: PictureScene, solution: Solution, sides: NDArray[np.int64], finest: float) -> RefinementGoal:
    """Leaves on some sides, with the mean illuminance there as the reference of errors."""
    elements = solution.elements
    wanted = np.isin(picture.frames.side, sides)
    row = elements.cell_row[wanted].astype(np.int64)
    lux = np.einsum("rb,b->r", solution.surfaces.irradiance, luminous_weights(solution.scene.bands))
    mean = float(np.average(lux[row], weights=elements.area[row])) if len(row) else 0.0
    size = np.where(wanted, finest, np.inf)
    return RefinementGoal(picture.frames, picture.rims, picture.grid, size, np.full(len(size), max(mean, 1e-300)))
