"""Where to split for shadows: direct light on leaves that are cut until it is well interpolated."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import BACK
from hradiosity.model.scene import Scene
from hradiosity.space.cell_lookup import CellFrames
from hradiosity.space.leaf_fan import EDGE_ENDS
from hradiosity.space.leaf_vertices import SideRims, places_in_space, vertex_keys
from hradiosity.space.leaves import CENTRE, N_PLACES, NONE, Leaves, plant_leaves, split_leaves
from hradiosity.space.visibility import trace_closest
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points

INSET = 2.0**-16
"""Distance that points keep from the outline of their patch, relative to the scene's half extent."""
RAY_BUDGET = 512
"""Shadow rays from a vertex to all emitters together, if the options leave it open."""
LEAST_RAYS, MOST_RAYS = 16, 256
LEAST_PILOT, PILOT_SHARE = 4, 4
"""Rays to an emitter that decide alone when they agree: one in four, but not fewer than four."""
BATCH = 1 << 17
"""Vertices evaluated at a time."""


@dataclass(frozen=True, kw_only=True)
class RefinementOptions:
    """How finely shadows are resolved.

    tolerance : difference between the centre of a leaf and the mean of its corners, over the reference illuminance,
        above which the leaf is split
    contrast : part of the light that obstacles take from one corner and not from another, over the reference
        illuminance, above which the leaf is split
    base_level : level that all leaves have at least, so that small shadows are found
    max_level : highest level; each halves the edges
    light_samples : shadow rays to each emitter; None lets their number decide
    seed : of the shadow rays
    """

    tolerance: float = 0.04
    contrast: float = 0.25
    base_level: int = 1
    max_level: int = 5
    light_samples: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if not (self.tolerance > 0.0 and self.contrast > 0.0):
            raise ValueError(f"tolerance and contrast must be > 0, are {self.tolerance} and {self.contrast}")
        if not 0 <= self.base_level <= self.max_level <= 12:
            raise ValueError(f"0 <= base_level <= max_level <= 12 is wanted, got {self.base_level}, {self.max_level}")
        if self.light_samples is not None and self.light_samples < 1:
            raise ValueError(f"light_samples must be at least 1, is {self.light_samples}")


@dataclass(frozen=True)
class RefinementGoal:
    """Which cells get leaves, and how fine.

    frames : CellFrames
    rims : SideRims
    grid : (n_patches, 2) int64, cells along edge_u and edge_v of each patch
    size : (n_cells,) float64, edge [m] below which a leaf is not split; infinite for cells that nobody looks at,
        which get no leaves
    reference : (n_cells,) float64, illuminance [lx] that tolerances refer to, above 0
    """

    frames: CellFrames
    rims: SideRims
    grid: NDArray[np.int64]
    size: NDArray[np.float64]
    reference: NDArray[np.float64]


@dataclass(frozen=True)
class ShadowLight:
    """Direct light at the vertices of leaves, without wavelengths.

    leaves : Leaves
    vertex : (n_nodes, 9) int32, vertices of each leaf in the order of ``leaves.PLACES``; NONE for the middle of an
        edge that no finer leaf lies beside, and for all vertices of nodes that are no leaves
    vertex_side : (n_vertices,) int64, a side that the vertex lies on
    per_luminaire : (n_vertices, n_luminaires) float32, irradiance over the exitance (or intensity) of each luminaire
    covered : (n_vertices,) bool, the vertex lies inside a solid and has no light of its own
    """

    leaves: Leaves
    vertex: NDArray[np.int32]
    vertex_side: NDArray[np.int64]
    per_luminaire: NDArray[np.float32]
    covered: NDArray[np.bool_]


def refine_shadows(
    on_device: DeviceScene, scene: Scene, goal: RefinementGoal, options: RefinementOptions
) -> ShadowLight:
    """Cut cells at shadow boundaries, level by level.

    Parameters
    ----------
    on_device : DeviceScene
    scene : Scene
    goal : RefinementGoal
    options : RefinementOptions
    """
    vertices = _Vertices(on_device, scene, goal, options)
    leaves = plant_leaves(goal.frames, np.isfinite(goal.size), options.max_level)
    fresh = np.arange(leaves.n_nodes)
    for level in range(options.max_level + 1):
        vertices.evaluate(leaves, fresh)
        if level == options.max_level:
            break
        large = _edge_length(scene, leaves, fresh, goal.grid) > goal.size[leaves.cell[fresh]]
        wanted = large if level < options.base_level else large & vertices.uneven(leaves, fresh)
        before = leaves.n_nodes
        leaves = _split_balanced(leaves, fresh[wanted], vertices)
        fresh = np.arange(before, leaves.n_nodes)
        fresh = fresh[leaves.is_leaf[fresh]]
        if not len(fresh):
            break
    return vertices.finish(leaves)


def _edge_length(
    scene: Scene, leaves: Leaves, nodes: NDArray[np.int64], grid: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(n,) longer edge of nodes [m]."""
    patch = leaves.side[nodes] // 2
    share = np.abs(leaves.extent[nodes]) / leaves.step
    length_u = np.linalg.norm(scene.patches.edge_u, axis=1)[patch] / grid[patch, 0]
    length_v = np.linalg.norm(scene.patches.edge_v, axis=1)[patch] / grid[patch, 1]
    longer: NDArray[np.float64] = share * np.maximum(length_u, length_v)
    return longer


def _split_balanced(leaves: Leaves, nodes: NDArray[np.int64], vertices: _Vertices) -> Leaves:
    """Split nodes, and then leaves beside which others are more than one level finer."""
    while len(nodes):
        leaves = split_leaves(leaves, nodes)
        candidates = np.flatnonzero(leaves.is_leaf & (leaves.level < leaves.max_level - 1))
        corners = vertices.corner_keys(leaves, np.flatnonzero(leaves.is_leaf))
        quarters = vertices.quarter_keys(leaves, candidates)
        nodes = candidates[np.isin(quarters, corners).any(axis=1)]
    return leaves


class _Vertices:
    """Values at points that leaves share; each is computed once."""

    def __init__(self, on_device: DeviceScene, scene: Scene, goal: RefinementGoal, options: RefinementOptions) -> None:
        self._on_device, self._scene, self._goal, self._options = on_device, scene, goal, options
        lamps = scene.luminaires
        weights = luminous_weights(scene.bands)
        self._lumens = np.array(
            [np.einsum("b,b->", lamp.exitance if len(lamp.exitance) else lamp.intensity, weights) for lamp in lamps]
        ).reshape(len(lamps))
        self._n_samples = options.light_samples or int(
            np.clip(RAY_BUDGET // max(len(scene.emitters), 1), LEAST_RAYS, MOST_RAYS)
        )
        self._n_pilot = max(LEAST_PILOT, self._n_samples // PILOT_SHARE)
        self._key = np.zeros(0, np.int64)
        self._side = np.zeros(0, np.int64)
        self._light = np.zeros((0, len(lamps)), np.float32)
        self._open = np.zeros(0)
        self._covered = np.zeros(0, np.bool_)

    def _keys(self, leaves: Leaves, nodes: NDArray[np.int64], places: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n, k) keys of places (n, k, 2) of nodes."""
        side = np.repeat(leaves.side[nodes], places.shape[1])
        steps = leaves.step * self._goal.grid[side // 2]
        is_triangle = self._scene.patches.is_triangle
        return vertex_keys(self._goal.rims, is_triangle, side, places.reshape(-1, 2), steps).reshape(places.shape[:2])

    def corner_keys(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Sorted keys of all corners of the nodes."""
        return np.unique(self._keys(leaves, nodes, leaves.places(nodes)[:, :4]))

    def quarter_keys(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n, 8) keys of the points at one and three quarters of each edge; a triangle repeats one edge."""
        places = leaves.places(nodes)
        ends = EDGE_ENDS[leaves.is_triangle[nodes].astype(np.int64)]
        first = np.take_along_axis(places, ends[:, :, :1], axis=1)
        last = np.take_along_axis(places, ends[:, :, 1:], axis=1)
        middle = places[:, CENTRE + 1 :]
        quarters = np.concatenate([(first + middle) // 2, (last + middle) // 2], axis=1)
        return self._keys(leaves, nodes, quarters)

    def evaluate(self, leaves: Leaves, nodes: NDArray[np.int64]) -> None:
        """Find the light at corners and centres of the nodes where it is not known yet."""
        places = leaves.places(nodes)[:, : CENTRE + 1]
        keys = self._keys(leaves, nodes, places).ravel()
        unique, first = np.unique(keys, return_index=True)
        new = ~np.isin(unique, self._key, assume_unique=True)
        unique, first = unique[new], first[new]
        side = np.repeat(leaves.side[nodes], CENTRE + 1)[first]
        steps = leaves.step * self._goal.grid[side // 2]
        light, unshaded, covered = self._sample(side, places.reshape(-1, 2)[first], steps)
        order = np.argsort(np.concatenate([self._key, unique]), kind="stable")
        self._key = np.concatenate([self._key, unique])[order]
        self._side = np.concatenate([self._side, side])[order]
        self._light = np.concatenate([self._light, light])[order]
        self._open = np.concatenate([self._open, unshaded])[order]
        self._covered = np.concatenate([self._covered, covered])[order]

    def _sample(
        self, side: NDArray[np.int64], place: NDArray[np.int64], steps: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_]]:
        """Light per luminaire, illuminance without obstacles [lx] and coveredness of points."""
        patches, scale = self._scene.patches, self._on_device.scale
        position = places_in_space(patches, side, place, steps, INSET * scale)
        normal = patches.normal[side // 2] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
        covered = self._inside_solids(position, normal)
        n_lamps = len(self._scene.luminaires)
        light = np.zeros((len(side), n_lamps), np.float32)
        unshaded = np.zeros(len(side))
        seen = np.flatnonzero(~covered)
        for start in range(0, len(seen), BATCH):
            part = seen[start : start + BATCH]
            light[part], unshaded[part] = self._direct(position[part], normal[part])
        return light, unshaded, covered

    def _direct(
        self, position: NDArray[np.float64], normal: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        on_device, seed = self._on_device, self._options.seed
        per_emitter = direct_at_points(on_device, position, normal, self._n_samples, seed, self._n_pilot)
        luminaire = self._scene.emitters.luminaire
        by_lamp = np.zeros((len(luminaire), len(self._lumens)), np.float32)
        by_lamp[np.arange(len(luminaire)), luminaire] = 1.0
        light = np.einsum("xe,el->xl", per_emitter, by_lamp)
        if not on_device.occlusion:
            return light, np.einsum("xl,l->x", light, self._lumens)
        open_scene = replace(on_device, occlusion=False)
        factor = direct_at_points(open_scene, position, normal, 1, seed)
        return light, np.einsum("xe,e->x", factor.astype(np.float64), self._lumens[luminaire])

    def _inside_solids(self, position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether a ray along the normal meets the inside of a solid first."""
        solid = self._scene.patches.solid
        if not len(position) or not (solid >= 0).any():
            return np.zeros(len(position), np.bool_)
        bvh = self._on_device.bvh
        hits = trace_closest(bvh, position + 2.0**-20 * bvh.scale * normal, normal)
        inside: NDArray[np.bool_] = (hits.patch >= 0) & (hits.side == BACK) & (solid[hits.patch] >= 0)
        return inside

    def uneven(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the light on each node is not what its corners say."""
        reference = self._goal.reference[leaves.cell[nodes]]
        index = np.searchsorted(self._key, self._keys(leaves, nodes, leaves.places(nodes)[:, : CENTRE + 1]))
        lux = np.einsum("vl,l->v", self._light.astype(np.float64), self._lumens)
        visible = np.divide(lux, self._open, out=np.zeros_like(lux), where=self._open > 0.0)
        counted = ~self._covered[index]
        counted[:, 3] &= ~leaves.is_triangle[nodes]
        corners = counted[:, :CENTRE].sum(axis=1)
        mean = (lux[index] * counted)[:, :CENTRE].sum(axis=1) / np.maximum(corners, 1)
        departs = (corners > 0) & counted[:, CENTRE]
        departs &= np.abs(lux[index][:, CENTRE] - mean) > self._options.tolerance * reference
        highest = np.where(counted, visible[index], -np.inf).max(axis=1)
        lowest = np.where(counted, visible[index], np.inf).min(axis=1)
        brightest = np.where(counted, self._open[index], 0.0).max(axis=1)
        hidden = np.maximum(highest - lowest, 0.0) * brightest > self._options.contrast * reference
        mixed = counted.any(axis=1) & self._covered[index].any(axis=1)
        wanted: NDArray[np.bool_] = departs | hidden | mixed
        return wanted

    def finish(self, leaves: Leaves) -> ShadowLight:
        """Number the vertices of all leaves."""
        nodes = np.flatnonzero(leaves.is_leaf)
        keys = self._keys(leaves, nodes, leaves.places(nodes))
        corners = np.unique(keys[:, :CENTRE])
        index = np.searchsorted(self._key, keys)
        known = np.isin(keys, corners)
        known[:, CENTRE] = True
        known[:, N_PLACES - 1] &= ~leaves.is_triangle[nodes]
        vertex = np.full((leaves.n_nodes, N_PLACES), NONE, np.int32)
        vertex[nodes] = np.where(known, index, NONE)
        return ShadowLight(leaves, vertex, self._side, self._light, self._covered)
