"""Illuminance on surfaces as a map whose error is asked for: leaves cut where the light changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.facing import named_part
from hradiosity.show.light import PictureScene, picture_scene
from hradiosity.show.map_reflected import ReflectedLight, ReflectedVertices, open_weights, paths_for
from hradiosity.solution import Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.hierarchy import NONE
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaves import CENTRE, Leaves, plant_leaves
from hradiosity.transport.device_scene import DeviceScene, upload_scene
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.leaf_light import VertexLight
from hradiosity.transport.leaf_points import side_normals
from hradiosity.transport.refine import RefinementGoal, RefinementOptions, ShadowLight, split_by_error, united

FINEST: Final = 1e-4
"""Edge of the smallest leaves, relative to the scene's half extent."""
MAX_LEVEL: Final = 10
DIRECT_SHARE, REFLECTED_SHARE, NOISE_SHARE = 0.8, 0.4, 0.3
"""Of a map's error: what direct light and reflected light between vertices, and noise, may come to; squares add up."""

_FACES: Final = 0.99
"""Cosine to a direction from which on a side faces there."""
_MEAN_WEIGHTS: Final = np.array([[1, 1, 1, 1, 2], [2, 2, 2, 0, 3]], np.float32)
"""Of corners and centre in the mean over the fan of a parallelogram and of a triangle."""


@dataclass(frozen=True)
class SurfaceMap:
    """Illuminance on some sides. What is left of a leaf that lies inside of things at all its vertices counts as dark.

    shadow : the leaves, and their vertices
    lux, half_width : (n_vertices,) float64 [lx], 0 where the vertex lies inside of something; half widths of the
        95 % intervals of the reflected light there, which do not hold the error of interpolation
    reflected : the reflected light that is part of `lux`, on fewer leaves; None where there is none
    """

    solution: Solution
    shadow: ShadowLight
    lux: NDArray[np.float64]
    half_width: NDArray[np.float64]
    reflected: ReflectedLight | None = None

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
    def corner_half_width(self) -> NDArray[np.float64]:
        """(n_leaves, 4) half widths there [lx]; NaN inside of things."""
        return np.where(self.shadow.covered, np.nan, self.half_width)[self._leaf_corners]

    @property
    def leaf_lux(self) -> NDArray[np.float64]:
        """(n_leaves,) mean illuminance of each leaf [lx]; NaN where all of its vertices lie inside of things."""
        return self._leaf_means(self.lux)

    @property
    def leaf_half_width(self) -> NDArray[np.float64]:
        """(n_leaves,) mean half width [lx]; NaN as of `leaf_lux`."""
        return self._leaf_means(self.half_width)

    @property
    def leaf_middle(self) -> NDArray[np.float64]:
        """(n_leaves, 3) middle of each leaf [m]."""
        middle: NDArray[np.float64] = self.shadow.position[self.shadow.vertex[self.shadow.leaves.is_leaf, CENTRE]]
        return middle

    @property
    def leaf_normal(self) -> NDArray[np.float64]:
        """(n_leaves, 3) unit normals."""
        leaves = self.shadow.leaves
        return side_normals(self.solution.scene.patches, leaves.side[leaves.is_leaf])

    @property
    def leaf_area(self) -> NDArray[np.float64]:
        """(n_leaves,) [m²]."""
        leaves, patches = self.shadow.leaves, self.solution.scene.patches
        side = leaves.side[leaves.is_leaf]
        share = (leaves.extent[leaves.is_leaf] / leaves.step) ** 2
        area: NDArray[np.float64] = (
            share * patches.area[side // 2] / self.solution.elements.divisions[side // 2].prod(1)
        )
        return area

    def _leaf_means(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        nodes = self.shadow.leaves.is_leaf
        vertices = self.shadow.vertex[nodes, : CENTRE + 1]
        weights = open_weights(vertices, _MEAN_WEIGHTS[self.shadow.leaves.is_triangle[nodes].astype(int)],
                               self.shadow.covered)  # fmt: skip
        mean: NDArray[np.float64] = np.einsum("nk,nk->n", weights, values[vertices])
        return np.where(weights.any(axis=1), mean, np.nan)

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
            weights = _MEAN_WEIGHTS[triangles[side // 2].astype(int)]
        else:
            vertices, weights = fan_weights(self.shadow.vertex, known, s, t, triangles[side // 2])
        value = np.einsum("nk,nk->n", open_weights(vertices, weights, self.shadow.covered), self.lux[vertices])
        return np.where(node < 0, np.nan, value)


def map_objects(solution: Solution, device: Device, names: Sequence[str], *, error: float = 0.01) -> SurfaceMap:
    """Map of all sides of some objects that light reaches.

    Parameters
    ----------
    solution : Solution
        Of a solver of this process, since reflected light is read at points of the map.
    names : sequence of str
        Of the objects, as the scene has them; with one of `hradiosity.model.facing.FACINGS` behind it, those of the
        object's sides: "room:up" is the floor of a box that is a room.
    error : float
        Root mean square error of the map that leaves and noise may leave, over the mean illuminance; that of the
        solution itself comes on top.

    Raises
    ------
    ValueError
        When no name is given, there is no object of a name, or no light reaches any of the objects.
    RuntimeError
        When the solution was not made by a solver of this process.
    """
    scene = solution.scene
    if not names:
        raise ValueError(f"a map needs the name of an object; the scene has {', '.join(scene.objects)}")
    unknown = [name for name in names if named_part(scene.objects, name) is None]
    if unknown:
        raise ValueError(
            f"there is no object {', '.join(map(repr, unknown))}; the scene has {', '.join(scene.objects)}"
        )
    sides = lit_sides_of(solution, names)
    if not len(sides):
        raise ValueError(f"no light reaches {', '.join(map(repr, names))}")
    sampled = sampled_scene(scene, solution.plan.weak_emitters)
    on_device = upload_scene(device, sampled, build_bvh(device, scene.patches), occlusion=solution.plan.occlusion)
    return map_surfaces(solution, on_device, sides, error)


def lit_sides_of(solution: Solution, names: Sequence[str]) -> NDArray[np.int64]:
    """(n,) sides, 2 · patch + side, of objects of the scene that light reaches; see `map_objects`."""
    scene = solution.scene
    side = np.flatnonzero(solution.elements.first_cell != NONE)
    chosen = np.zeros(len(side), np.bool_)
    for part in filter(None, (named_part(scene.objects, name) for name in names)):
        of_object = scene.patches.object[side // 2] == part[0]
        if part[1] is not None:
            of_object &= side_normals(scene.patches, side) @ np.array(part[1]) > _FACES
        chosen |= of_object
    return side[chosen]


def map_surfaces(
    solution: Solution, on_device: DeviceScene, sides: NDArray[np.int64], error: float, finest: float = FINEST
) -> SurfaceMap:
    """Map of some sides: 2 · patch + side of the solution's scene; see `map_objects`.

    Direct light is computed at the vertices of its leaves. Reflected light is smooth but dear: it is read at the
    vertices of others, which are coarser nearly everywhere, and interpolated. Leaves of the map are as fine as the
    finer of both.

    Parameters
    ----------
    finest : float
        Edge of leaves that are not split any more, relative to the scene's half extent.
    """
    goal = map_goal(picture_scene(solution), solution, sides, finest * on_device.scale)
    direct, leaves = cut_by_direct(solution, on_device, goal, error)
    if not reflects(solution):
        return joined(solution, direct, leaves, None)
    n_paths = paths_for(on_device, solution, goal, NOISE_SHARE * error)
    vertices = ReflectedVertices(on_device, solution, goal, n_paths)
    planted = plant_leaves(goal.frames, np.isfinite(goal.size), MAX_LEVEL)
    read = split_by_error(planted, vertices, solution.scene.patches, goal, 0, REFLECTED_SHARE * error)
    return joined(solution, direct, united(leaves, read, direct), vertices.finish(read))


def cut_by_direct(
    solution: Solution, on_device: DeviceScene, goal: RefinementGoal, error: float
) -> tuple[VertexLight, Leaves]:
    """Leaves that leave the direct light its share of an error, and the light at their vertices."""
    options = RefinementOptions(base_level=0, max_level=MAX_LEVEL, error=DIRECT_SHARE * error)
    vertices = VertexLight(on_device, sampled_scene(solution.scene, solution.plan.weak_emitters), goal, options)
    planted = plant_leaves(goal.frames, np.isfinite(goal.size), MAX_LEVEL)
    return vertices, split_by_error(planted, vertices, solution.scene.patches, goal, 0, DIRECT_SHARE * error)


def reflects(solution: Solution) -> bool:
    """Whether there is light that paths bring."""
    return solution.plan.gathers or solution.scene.sky is not None


def joined(solution: Solution, direct: VertexLight, leaves: Leaves, reflected: ReflectedLight | None) -> SurfaceMap:
    """Direct light at the vertices of leaves, with reflected light interpolated there."""
    direct.evaluate(leaves, np.flatnonzero(leaves.is_leaf))
    shadow = direct.finish(leaves)
    lux, half_width = direct.lux, np.zeros(len(direct.lux))
    if reflected is not None:
        nodes = np.flatnonzero(leaves.is_leaf)
        cell = np.repeat(leaves.cell[nodes].astype(np.int64), CENTRE + 1)
        s, t = leaves.in_cell(nodes)[:, : CENTRE + 1].reshape(-1, 2).astype(np.float32).T
        found = reflected.at(cell, s, t)
        vertex = shadow.vertex[nodes, : CENTRE + 1].ravel()
        more = np.zeros((len(lux), 2))
        more[vertex] = np.where(shadow.covered[vertex, None], 0.0, found[:, [0, 2]])
        lux, half_width = lux + more[:, 0], more[:, 1]
    return SurfaceMap(solution, shadow, np.maximum(lux, 0.0), half_width, reflected)


def map_goal(picture: PictureScene, solution: Solution, sides: NDArray[np.int64], finest: float) -> RefinementGoal:
    """Leaves on some sides, with the mean illuminance there as the reference of errors."""
    elements = solution.elements
    wanted = np.isin(picture.frames.side, sides)
    row = elements.cell_row[wanted].astype(np.int64)
    lux = np.einsum("rb,b->r", solution.surfaces.irradiance, luminous_weights(solution.scene.bands))
    mean = float(np.average(lux[row], weights=elements.area[row])) if len(row) else 0.0
    size = np.where(wanted, finest, np.inf)
    return RefinementGoal(picture.frames, picture.rims, picture.grid, size, np.full(len(size), max(mean, 1e-300)))
