"""Vertices that leaves share, and what is known there; each is computed once."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, Patches
from hradiosity.space.leaf_fan import EDGE_ENDS
from hradiosity.space.leaf_vertices import places_in_space, vertex_keys
from hradiosity.space.leaves import CENTRE, N_PLACES, NONE, Leaves
from hradiosity.space.visibility import trace_closest
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.refinement_goal import RefinementGoal

INSET = 2.0**-16
"""Distance that points keep from the outline of their patch, relative to the scene's half extent."""
BATCH = 1 << 17
"""Vertices evaluated at a time."""


class LeafVertices(ABC):
    """Values at points that leaves share.

    Parameters
    ----------
    on_device : DeviceScene
    patches : Patches
    goal : RefinementGoal
    n_values : int
        Numbers that `_sample` finds at each point.

    Attributes
    ----------
    side : (n,) int64, a side that each vertex lies on
    position : (n, 3) float64 [m], a little inside of the outline of that side
    values : (n, n_values) float32, 0 where `covered`
    covered : (n,) bool, the vertex lies inside a solid
    """

    def __init__(self, on_device: DeviceScene, patches: Patches, goal: RefinementGoal, n_values: int) -> None:
        self._on_device, self._patches, self._goal = on_device, patches, goal
        self._key = np.zeros(0, np.int64)
        self.side = np.zeros(0, np.int64)
        self.position = np.zeros((0, 3))
        self.values = np.zeros((0, n_values), np.float32)
        self.covered = np.zeros(0, np.bool_)

    @abstractmethod
    def _sample(self, position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.floating]:
        """(n, n_values) at points (n, 3) in the open [m], with unit normals."""

    @abstractmethod
    def light(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 5) illuminance [lx] at corners and centre."""

    def variance(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 5) of `light` [lx²], 0 unless it is noisy."""
        return np.zeros((len(nodes), CENTRE + 1))

    def _keys(self, leaves: Leaves, nodes: NDArray[np.int64], places: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n, k) keys of places (n, k, 2) of nodes."""
        side = np.repeat(leaves.side[nodes], places.shape[1])
        steps = leaves.step * self._goal.grid[side // 2]
        is_triangle = self._patches.is_triangle
        return vertex_keys(self._goal.rims, is_triangle, side, places.reshape(-1, 2), steps).reshape(places.shape[:2])

    def corner_keys(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Sorted keys of all corners of the nodes."""
        return np.unique(self._keys(leaves, nodes, leaves.places(nodes)[:, :CENTRE]))

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
        """Find the values at corners and centres of the nodes where they are not known yet."""
        places = leaves.places(nodes)[:, : CENTRE + 1]
        keys = self._keys(leaves, nodes, places).ravel()
        unique, first = np.unique(keys, return_index=True)
        new = ~np.isin(unique, self._key, assume_unique=True)
        unique, first = unique[new], first[new]
        side = np.repeat(leaves.side[nodes], CENTRE + 1)[first]
        steps = leaves.step * self._goal.grid[side // 2]
        inset = INSET * self._on_device.scale
        position = places_in_space(self._patches, side, places.reshape(-1, 2)[first], steps, inset)
        values, covered = self._evaluated(side, position)
        order = np.argsort(np.concatenate([self._key, unique]), kind="stable")
        self._key = np.concatenate([self._key, unique])[order]
        self.side = np.concatenate([self.side, side])[order]
        self.position = np.concatenate([self.position, position])[order]
        self.values = np.concatenate([self.values, values])[order]
        self.covered = np.concatenate([self.covered, covered])[order]

    def _evaluated(
        self, side: NDArray[np.int64], position: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Values and coveredness of points."""
        normal = side_normals(self._patches, side)
        covered = self._inside_solids(position, normal)
        values = np.zeros((len(side), self.values.shape[1]), np.float32)
        seen = np.flatnonzero(~covered)
        for start in range(0, len(seen), BATCH):
            part = seen[start : start + BATCH]
            values[part] = self._sample(position[part], normal[part])
        return values, covered

    def _inside_solids(self, position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether a ray along the normal meets the inside of a solid first."""
        solid = self._patches.solid
        if not len(position) or not (solid >= 0).any():
            return np.zeros(len(position), np.bool_)
        bvh = self._on_device.bvh
        hits = trace_closest(bvh, position + 2.0**-20 * bvh.scale * normal, normal)
        inside: NDArray[np.bool_] = (hits.patch >= 0) & (hits.side == BACK) & (solid[hits.patch] >= 0)
        return inside

    def index(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n, 5) numbers of the vertices at corners and centre."""
        return np.searchsorted(self._key, self._keys(leaves, nodes, leaves.places(nodes)[:, : CENTRE + 1]))

    def known(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(n, 5) whether corners and centre are in the open and no repetition."""
        known = ~self.covered[self.index(leaves, nodes)]
        known[:, 3] &= ~leaves.is_triangle[nodes]
        return known

    def hides(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(n,) whether a corner or the centre lies inside of a solid."""
        inside: NDArray[np.bool_] = np.any(self.covered[self.index(leaves, nodes)], axis=1)
        return inside

    def numbered(self, leaves: Leaves) -> NDArray[np.int32]:
        """(n_nodes, 9) numbers of the vertices of all leaves, see `ShadowLight.vertex`."""
        nodes = np.flatnonzero(leaves.is_leaf)
        keys = self._keys(leaves, nodes, leaves.places(nodes))
        corners = np.unique(keys[:, :CENTRE])
        index = np.searchsorted(self._key, keys)
        known = np.isin(keys, corners)
        known[:, CENTRE] = True
        known[:, N_PLACES - 1] &= ~leaves.is_triangle[nodes]
        vertex = np.full((leaves.n_nodes, N_PLACES), NONE, np.int32)
        vertex[nodes] = np.where(known, index, NONE)
        return vertex


def side_normals(patches: Patches, side: NDArray[np.integer]) -> NDArray[np.float64]:
    """(n, 3) unit normals of sides."""
    normals: NDArray[np.float64] = patches.normal[side // 2] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
    return normals
