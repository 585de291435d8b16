"""Reflected light for maps: read on leaves of its own, fewer than shadow edges need, by more paths from each point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.solution import ReflectedLux, Solution
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaf_vertices import places_in_space
from hradiosity.space.leaves import Leaves
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.leaf_points import INSET, LeafVertices, side_normals
from hradiosity.transport.refinement_goal import RefinementGoal

TRIAL_POINTS, TRIAL_PATHS = 128, 256
"""That tell how noisy paths are."""
LEAST_PATHS, MOST_PATHS = 64, 1 << 16
SMOOTHED: Final = 0.7
"""Noise of what lies between vertices, over theirs."""
EVENNESS: Final = 0.6
"""Noise falls with this power of the number of paths from a point, which are spread evenly."""


class ReflectedVertices(LeafVertices):
    """Reflected light at points that leaves share, and all that comes along paths beside: weak emitters, the sky.

    Parameters
    ----------
    on_device : DeviceScene
    solution : Solution
        With a solver behind it.
    goal : RefinementGoal
    n_paths : int
        From each point.
    """

    def __init__(self, on_device: DeviceScene, solution: Solution, goal: RefinementGoal, n_paths: int) -> None:
        super().__init__(on_device, solution.scene.patches, goal, 3)
        self._solution, self._n_paths = solution, n_paths

    def _sample(self, position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.floating]:
        """(n, 3) illuminance [lx], its standard error by the paths, and the half width of its interval."""
        found = read_reflected(self._solution, position, normal, self._n_paths, len(self.position))
        return np.column_stack([found.lux, found.noise, found.half_width])

    def light(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 5) illuminance [lx] at corners and centre."""
        found: NDArray[np.float64] = self.values[self.index(leaves, nodes), 0].astype(np.float64)
        return found

    def variance(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 5) of `light` [lx²]."""
        found: NDArray[np.float64] = self.values[self.index(leaves, nodes), 1].astype(np.float64) ** 2
        return found

    def finish(self, leaves: Leaves) -> ReflectedLight:
        """What is known at the vertices of these leaves."""
        return ReflectedLight(leaves, self.numbered(leaves), self.values, self.covered)


@dataclass(frozen=True)
class ReflectedLight:
    """Reflected light on leaves.

    leaves : Leaves
    vertex : (n_nodes, 9) int32, as of `hradiosity.transport.refinement_goal.ShadowLight`
    values : (n_vertices, 3) float32 [lx]: illuminance, its standard error, and the half width of its interval
    covered : (n_vertices,) bool
    """

    leaves: Leaves
    vertex: NDArray[np.int32]
    values: NDArray[np.float32]
    covered: NDArray[np.bool_]

    @property
    def n_read(self) -> int:
        """Points that were read."""
        return int(np.count_nonzero(~self.covered))

    def at(self, cell: NDArray[np.int64], s: NDArray[np.float32], t: NDArray[np.float32]) -> NDArray[np.float64]:
        """(n, 3) `values` at places in cells that have leaves, interpolated; 0 inside of things."""
        node, s, t = self.leaves.locate(cell, s, t)
        triangle = self.leaves.frames.is_triangle[cell]
        vertices, weights = open_fan(self.vertex, self.covered, node, s, t, triangle)
        found: NDArray[np.float64] = np.einsum("nk,nkv->nv", weights, self.values[vertices].astype(np.float64))
        return found


def open_fan(
    vertex: NDArray[np.int32],
    covered: NDArray[np.bool_],
    node: NDArray[np.integer],
    s: NDArray[np.float32],
    t: NDArray[np.float32],
    triangle: NDArray[np.bool_],
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """As `fan_weights`, with weights of covered vertices given to the others; all 0 where all are covered."""
    vertices, weights = fan_weights(vertex, node, s, t, triangle)
    return vertices, open_weights(vertices, weights, covered)


def open_weights(
    vertices: NDArray[np.int32], weights: NDArray[np.float32], covered: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """(n, k) weights without covered vertices, brought back to a sum of 1 where there are others."""
    known = np.where(covered[vertices], 0.0, weights.astype(np.float64))
    total = known.sum(axis=1, keepdims=True)
    scaled: NDArray[np.float64] = known / np.where(total > 0.0, total, 1.0)
    return scaled


def read_reflected(
    solution: Solution, position: NDArray[np.float64], normal: NDArray[np.float64], n_paths: int, seed: int
) -> ReflectedLux:
    """Reflected light at points.

    Raises
    ------
    RuntimeError
        When the solution has no solver behind it.
    """
    if solution.reflector is None:
        raise RuntimeError("this solution was not made by a solver of this process; solve the scene to map it")
    return solution.reflector(position, normal, n_paths, seed)


def paths_for(on_device: DeviceScene, solution: Solution, goal: RefinementGoal, noise: float) -> int:
    """Paths from each point that leave this noise of a map over the reference illuminance.

    Parameters
    ----------
    on_device : DeviceScene
    solution : Solution
    goal : RefinementGoal
    noise : float
        Root mean square over the area.
    """
    patches, frames = solution.scene.patches, goal.frames
    cell = np.flatnonzero(np.isfinite(goal.size))
    if not len(cell):
        return LEAST_PATHS
    patch = frames.side[cell] // 2
    until = np.cumsum(patches.area[patch] / goal.grid[patch].prod(axis=1))
    place = (np.arange(TRIAL_POINTS) + 0.5) / TRIAL_POINTS * until[-1]
    cell = np.unique(cell[np.minimum(np.searchsorted(until, place), len(cell) - 1)])
    side, parts = frames.side[cell], np.where(frames.is_triangle[cell], 3, 2)
    middle = parts[:, None] * frames.corner[cell] + frames.extent[cell][:, None]
    position = places_in_space(patches, side, middle, parts[:, None] * goal.grid[side // 2], INSET * on_device.scale)
    found = read_reflected(solution, position, side_normals(patches, side), TRIAL_PATHS, TRIAL_POINTS)
    spread = SMOOTHED * float(np.sqrt(((found.noise / goal.reference[cell]) ** 2).mean()))
    wanted = TRIAL_PATHS * (spread / noise) ** (1.0 / EVENNESS)
    return int(np.clip(np.ceil(wanted), LEAST_PATHS, MOST_PATHS))
