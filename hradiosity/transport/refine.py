"""Where to split for shadows: direct light on leaves that are cut until it is well interpolated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.model.scene import Scene
from hradiosity.space.leaves import CENTRE, Leaves, plant_leaves, split_leaves
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.leaf_error import LeafErrors
from hradiosity.transport.leaf_light import VertexLight
from hradiosity.transport.leaf_points import LeafVertices
from hradiosity.transport.refinement_goal import RefinementGoal, RefinementOptions, ShadowLight

__all__ = ["RefinementGoal", "RefinementOptions", "ShadowLight", "refine_shadows", "split_by_error", "united"]

SHARE = 0.6
"""Part of the squared error that the leaves hold which are split in one round."""


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
    vertices = VertexLight(on_device, scene, goal, options)
    leaves = plant_leaves(goal.frames, np.isfinite(goal.size), options.max_level)
    if options.error is not None:
        return vertices.finish(split_by_error(leaves, vertices, scene.patches, goal, options.base_level, options.error))
    fresh = np.arange(leaves.n_nodes)
    for level in range(options.max_level + 1):
        vertices.evaluate(leaves, fresh)
        if level == options.max_level:
            break
        large = _edge_length(scene.patches, leaves, fresh, goal.grid) > goal.size[leaves.cell[fresh]]
        large &= leaves.level[fresh] < options.max_level
        wanted = large if level < options.base_level else large & vertices.uneven(leaves, fresh)
        before = leaves.n_nodes
        leaves = _split_balanced(leaves, fresh[wanted], vertices)
        fresh = np.arange(before, leaves.n_nodes)
        fresh = fresh[leaves.is_leaf[fresh]]
        if not len(fresh):
            break
    return vertices.finish(leaves)


def split_by_error(
    leaves: Leaves, vertices: LeafVertices, patches: Patches, goal: RefinementGoal, base_level: int, wanted: float
) -> Leaves:
    """Split the leaves that hold most of the expected error, round by round, until the rest is what is wanted.

    Each round takes the fewest leaves that hold `SHARE` of the square of the error (Dörfler 1996), so that smooth
    light and shadow edges end up with leaves that gain as much by one split more.

    Parameters
    ----------
    leaves : Leaves
        Not split yet.
    vertices : LeafVertices
        Of these leaves, with nothing known yet.
    patches : Patches
    goal : RefinementGoal
    base_level : int
        That all leaves have at least.
    wanted : float
        Root mean square error over the reference illuminance.
    """
    errors = LeafErrors()
    known = 0
    while True:
        vertices.evaluate(leaves, np.arange(known, leaves.n_nodes))
        fresh = np.arange(known, leaves.n_nodes)
        errors.add(
            leaves, vertices.light(leaves, fresh), vertices.variance(leaves, fresh), vertices.known(leaves, fresh)
        )
        known = leaves.n_nodes
        nodes = np.flatnonzero(leaves.is_leaf)
        edge, cell = _edge_length(patches, leaves, nodes, goal.grid), leaves.cell[nodes]
        splittable = (edge > goal.size[cell]) & (leaves.level[nodes] < leaves.max_level)
        coarse = splittable & (leaves.level[nodes] < base_level)
        weight = _pixels(patches, leaves, nodes, goal)
        square = (
            weight
            * ((errors.of(nodes) + errors.hidden(nodes, vertices.hides(leaves, nodes))) / goal.reference[cell]) ** 2
        )
        chosen = nodes[coarse] if coarse.any() else nodes[_largest(square, splittable, wanted**2 * weight.sum())]
        if not len(chosen):
            return leaves
        leaves = _split_balanced(leaves, chosen, vertices)


def _largest(square: NDArray[np.float64], splittable: NDArray[np.bool_], wanted: float) -> NDArray[np.int64]:
    """Leaves to split in one round: none if the sum of squares is as wanted already.

    Leaves that are as small as they may be count, but are none to split.
    """
    if square.sum() <= wanted:
        return np.zeros(0, np.int64)
    order = np.argsort(-np.where(splittable, square, -1.0), kind="stable")[: int(splittable.sum())]
    held = np.cumsum(square[order])
    if not len(held) or held[-1] <= 0.0:
        return np.zeros(0, np.int64)
    return order[: int(np.searchsorted(held, SHARE * held[-1])) + 1]


def _pixels(patches: Patches, leaves: Leaves, nodes: NDArray[np.int64], goal: RefinementGoal) -> NDArray[np.float64]:
    """(n,) area of nodes in squares of the size that leaves are not split below."""
    patch, size = leaves.side[nodes] // 2, goal.size[leaves.cell[nodes]]
    cells = goal.grid[patch].prod(axis=1)
    share = (leaves.extent[nodes] / leaves.step) ** 2
    pixels: NDArray[np.float64] = share * patches.area[patch] / cells / size**2
    return pixels


def _edge_length(
    patches: Patches, leaves: Leaves, nodes: NDArray[np.int64], grid: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(n,) longer edge of nodes [m]."""
    patch = leaves.side[nodes] // 2
    share = np.abs(leaves.extent[nodes]) / leaves.step
    length_u = np.linalg.norm(patches.edge_u, axis=1)[patch] / grid[patch, 0]
    length_v = np.linalg.norm(patches.edge_v, axis=1)[patch] / grid[patch, 1]
    longer: NDArray[np.float64] = share * np.maximum(length_u, length_v)
    return longer


def _split_balanced(leaves: Leaves, nodes: NDArray[np.int64], vertices: LeafVertices) -> Leaves:
    """Split nodes, and then leaves beside which others are more than one level finer."""
    while len(nodes):
        leaves = split_leaves(leaves, nodes)
        candidates = np.flatnonzero(leaves.is_leaf & (leaves.level < leaves.max_level - 1))
        corners = vertices.corner_keys(leaves, np.flatnonzero(leaves.is_leaf))
        quarters = vertices.quarter_keys(leaves, candidates)
        nodes = candidates[np.isin(quarters, corners).any(axis=1)]
    return leaves


def united(leaves: Leaves, finer: Leaves, vertices: LeafVertices) -> Leaves:
    """The leaves, split further wherever others of the same cells are finer, and where that asks for it.

    Parameters
    ----------
    leaves, finer : Leaves
    vertices : LeafVertices
        Whose keys tell neighbours; new vertices are not evaluated.
    """
    while True:
        nodes = np.flatnonzero(leaves.is_leaf & (leaves.level < leaves.max_level))
        cell = leaves.cell[nodes].astype(np.int64)
        s, t = leaves.in_cell(nodes)[:, CENTRE].astype(np.float32).T
        there = finer.locate(cell, s, t)[0]
        coarse = nodes[(there >= 0) & (finer.level[np.maximum(there, 0)] > leaves.level[nodes])]
        if not len(coarse):
            return leaves
        leaves = _split_balanced(leaves, coarse, vertices)
