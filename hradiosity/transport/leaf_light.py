"""Direct light at the vertices that leaves share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import BACK
from hradiosity.model.scene import Scene
from hradiosity.space.leaf_fan import EDGE_ENDS
from hradiosity.space.leaf_vertices import places_in_space, vertex_keys
from hradiosity.space.leaves import CENTRE, N_PLACES, NONE, Leaves
from hradiosity.space.visibility import trace_closest
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.refinement_goal import RefinementGoal, RefinementOptions, ShadowLight

INSET = 2.0**-16
"""Distance that points keep from the outline of their patch, relative to the scene's half extent."""
RAY_BUDGET = 512
"""Shadow rays from a vertex to all emitters together, if the options leave it open."""
LEAST_RAYS, MOST_RAYS = 16, 256
"""To each emitter."""
RAY_ERROR_SHARE, MOST_RAYS_BY_ERROR = 0.5, 4096
"""Of the error that is asked for, what shadow rays may make of it in a penumbra; and the most of them."""
LEAST_PILOT, PILOT_SHARE = 4, 4
"""Rays to an emitter that decide alone when they agree: one in four, but not fewer than four."""
BATCH = 1 << 17
"""Vertices evaluated at a time."""


class VertexLight:
    """Values at points that leaves share; each is computed once."""

    def __init__(self, on_device: DeviceScene, scene: Scene, goal: RefinementGoal, options: RefinementOptions) -> None:
        self._on_device, self._scene, self._goal, self._options = on_device, scene, goal, options
        lamps = scene.luminaires
        weights = luminous_weights(scene.bands)
        self._lumens = np.array([np.einsum("b,b->", lamp.emission, weights) for lamp in lamps]).reshape(len(lamps))
        self._n_samples = options.light_samples or _shadow_rays(len(scene.emitters), options.error)
        self._n_pilot = max(LEAST_PILOT, self._n_samples // PILOT_SHARE)
        self._key = np.zeros(0, np.int64)
        self._side = np.zeros(0, np.int64)
        self._position = np.zeros((0, 3))
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
        inset = INSET * self._on_device.scale
        position = places_in_space(self._scene.patches, side, places.reshape(-1, 2)[first], steps, inset)
        light, unshaded, covered = self._sample(side, position)
        order = np.argsort(np.concatenate([self._key, unique]), kind="stable")
        self._key = np.concatenate([self._key, unique])[order]
        self._side = np.concatenate([self._side, side])[order]
        self._position = np.concatenate([self._position, position])[order]
        self._light = np.concatenate([self._light, light])[order]
        self._open = np.concatenate([self._open, unshaded])[order]
        self._covered = np.concatenate([self._covered, covered])[order]

    def _sample(
        self, side: NDArray[np.int64], position: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_]]:
        """Light per luminaire, illuminance without obstacles [lx] and coveredness of points."""
        patches = self._scene.patches
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

    def _index(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n, 5) numbers of the vertices at corners and centre."""
        return np.searchsorted(self._key, self._keys(leaves, nodes, leaves.places(nodes)[:, : CENTRE + 1]))

    def light(self, leaves: Leaves, nodes: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """(n, 5) illuminance [lx] at corners and centre, and whether that is known and no repetition."""
        index = self._index(leaves, nodes)
        known = ~self._covered[index]
        known[:, 3] &= ~leaves.is_triangle[nodes]
        return np.einsum("npl,l->np", self._light[index].astype(np.float64), self._lumens), known

    def hides(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(n,) whether a corner or the centre lies inside of a solid."""
        inside: NDArray[np.bool_] = np.any(self._covered[self._index(leaves, nodes)], axis=1)
        return inside

    def uneven(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the light on each node is not what its corners say."""
        reference = self._goal.reference[leaves.cell[nodes]]
        index = self._index(leaves, nodes)
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
        return ShadowLight(leaves, vertex, self._side, self._position, self._light, self._covered)


def _shadow_rays(n_emitters: int, error: float | None) -> int:
    """To each emitter. Their error in a penumbra falls with the power of three quarters of their number, and that of
    several emitters partly cancels.
    """
    if error is None:
        return int(np.clip(RAY_BUDGET // max(n_emitters, 1), LEAST_RAYS, MOST_RAYS))
    wanted = (RAY_ERROR_SHARE * error) ** (-4.0 / 3.0) / max(n_emitters, 1) ** 0.5
    return int(np.clip(wanted, LEAST_RAYS, MOST_RAYS_BY_ERROR))
