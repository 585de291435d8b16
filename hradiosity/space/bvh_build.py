"""Builds the ray structure: triangles of the patches, then one level of 8-wide nodes a launch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.model.geometry import Patches
from hradiosity.space.bvh import LEAF_FLAG, LEAF_WORDS, NODE_WORDS, WIDTH, Bvh, PatchGeometry

_SURFACE_LEVELS: Final = 12
"""Levels split by surface area; below, sets are halved, so that 9 levels more are enough for 2²⁸ triangles."""
_BOX_MARGIN: Final = 2.0**-20
"""Boxes grow by this share of the scene's half extent: covers the rounding of the triangle test (see hr_bvh.h)."""
_NOWHERE: Final = np.float32(3e38)
"""Bound of a missing child: no ray meets it, and the slab test stays finite."""


@dataclass(frozen=True)
class _Triangles:
    """corners : (n, 3, 3) float32 [m], local; name : (n,) uint32, 2 patch + half."""

    corners: NDArray[np.float32]
    name: NDArray[np.uint32]


@dataclass(frozen=True)
class _Level:
    """One launch: bounds (m, 8, 8) float32 and ranges (m, 8, 2) uint32 of the children of m nodes."""

    bounds: NDArray[np.float32]
    ranges: NDArray[np.uint32]


def build_bvh(device: Device, patches: Patches) -> Bvh:
    """Ray structure over all patches; those without area are left out and never hit.

    Binned surface area heuristic, top down. The same patches give the same structure, bit for bit.

    Raises
    ------
    ValueError
        When a coordinate is not finite.
    """
    if not all(np.isfinite(a).all() for a in (patches.origin, patches.edge_u, patches.edge_v)):
        raise ValueError("patches must have finite coordinates")
    local_origin, scale = _frame(patches)
    triangles = _triangles(patches, local_origin)
    levels, order = _split(device, triangles)
    nodes, leaf_ranges = _nodes(levels, _area_before(triangles, order), np.float32(_BOX_MARGIN * scale))
    return Bvh(
        device=device,
        nodes=device.upload(nodes),
        leaves=device.upload(_leaves(triangles, order, leaf_ranges)),
        patches=_geometry(device, patches, local_origin),
        n_patches=len(patches),
        depth=len(levels),
        local_origin=local_origin,
        scale=scale,
    )


def _frame(patches: Patches) -> tuple[NDArray[np.float64], float]:
    """Centre of the bounding box and largest half extent; origin and 1 where there is nothing to measure."""
    if len(patches) == 0:
        return np.zeros(3), 1.0
    low, high = patches.bounds()
    half = float(0.5 * (high - low).max())
    return 0.5 * (low + high), half if half > 0.0 else 1.0


def _triangles(patches: Patches, local_origin: NDArray[np.float64]) -> _Triangles:
    """Triangles with area, first halves before second ones; corners are rounded once, so both halves share them."""
    corners = (patches.corners() - local_origin).astype(np.float32)
    second = np.flatnonzero(~patches.is_triangle)
    both = np.concatenate([corners[:, [0, 1, 3]], corners[second][:, [2, 3, 1]]])
    name = np.concatenate([2 * np.arange(len(patches)), 2 * second + 1]).astype(np.uint32)
    exact = both.astype(np.float64)
    cross = np.cross(exact[:, 1] - exact[:, 0], exact[:, 2] - exact[:, 0])
    kept = (cross[:, 0] != 0.0) | (cross[:, 1] != 0.0) | (cross[:, 2] != 0.0)
    return _Triangles(both[kept], name[kept])


def _split(device: Device, triangles: _Triangles) -> tuple[list[_Level], NDArray[np.uint32]]:
    """Levels from the root down, and the triangles' numbers in the order that the ranges refer to."""
    n = len(triangles.name)
    host_boxes = np.zeros((n, 8), np.float32)
    a, b, c = triangles.corners.transpose(1, 0, 2)
    host_boxes[:, 0:3] = np.minimum(np.minimum(a, b), c)
    host_boxes[:, 4:7] = -np.maximum(np.maximum(a, b), c)
    boxes = device.upload(host_boxes)
    order = device.upload(np.arange(n, dtype=np.uint32))
    split_nodes = device.kernel("bvh_build", "split_nodes")
    levels: list[_Level] = []
    ranges = np.array([[0, n]], np.uint32)
    while len(ranges):
        m = len(ranges)
        bounds = device.empty((m, WIDTH, 8), np.float32)
        child_range = device.empty((m, WIDTH, 2), np.uint32)
        split_nodes(
            m,
            boxes=boxes,
            names=order,
            node_range=device.upload(ranges),
            child_bounds=bounds,
            child_range=child_range,
            halve=int(len(levels) >= _SURFACE_LEVELS),
        )
        level = _Level(device.fetch(bounds), device.fetch(child_range))
        levels.append(level)
        ranges = level.ranges[_count(level.ranges) > WIDTH]
    return levels, device.fetch(order)[:n]


def _count(ranges: NDArray[np.uint32]) -> NDArray[np.uint32]:
    return ranges[..., 1] - ranges[..., 0]


def _area_before(triangles: _Triangles, order: NDArray[np.uint32]) -> NDArray[np.float64]:
    """(n + 1,) area of the first k triangles in `order` [m²], so that a range's area is one difference."""
    corners = triangles.corners[order].astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.concatenate([[0.0], np.cumsum(0.5 * np.linalg.norm(cross, axis=1))])


def _nodes(
    levels: list[_Level], area_before: NDArray[np.float64], margin: np.float32
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Node rows, and ranges (n_leaves, 2) of the leaves in the order of their references; leaf 0 is the empty one."""
    bounds = np.concatenate([level.bounds for level in levels])
    ranges = np.concatenate([level.ranges for level in levels])
    count = _count(ranges)
    is_leaf = (count > 0) & (count <= WIDTH)
    is_node = count > WIDTH
    reference = np.full(count.shape, LEAF_FLAG, np.uint32)
    reference[is_leaf] = LEAF_FLAG + np.arange(1, 1 + np.count_nonzero(is_leaf))
    reference[is_node] = np.arange(1, 1 + np.count_nonzero(is_node))
    low = np.where(count[..., None] > 0, bounds[..., 0:3] - margin, _NOWHERE)
    high = np.where(count[..., None] > 0, margin - bounds[..., 4:7], -_NOWHERE)
    rows = np.zeros((len(bounds), WIDTH, NODE_WORDS // WIDTH), np.float32)
    rows[:, :, 0:6:2] = low
    rows[:, :, 1:6:2] = high
    rows[:, :, 6] = reference.view(np.float32)
    last_blocks_most = np.argsort(_blocking_per_test(bounds, ranges, area_before), axis=1, kind="stable")
    nodes = np.take_along_axis(rows, last_blocks_most[..., None], axis=1).transpose(0, 2, 1)
    return np.ascontiguousarray(nodes).reshape(-1, NODE_WORDS), np.concatenate(
        [np.zeros((1, 2), np.uint32), ranges[is_leaf]]
    )


def _blocking_per_test(
    bounds: NDArray[np.float32], ranges: NDArray[np.uint32], area_before: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(m, 8) how likely a ray that meets a child's box is blocked there, for the triangles to be tested.

    The likelihood is surface inside over half the box's surface, at most 1 (after Nah and Manocha 2014). Any-hit rays
    go to the best child first, which makes them half as fast again (``hradiosity.suites.bench_rays``).
    """
    extent = -(bounds[..., 0:3] + bounds[..., 4:7]).astype(np.float64)
    around = extent[..., 0] * extent[..., 1] + extent[..., 1] * extent[..., 2] + extent[..., 2] * extent[..., 0]
    inside = area_before[ranges[..., 1]] - area_before[ranges[..., 0]]
    count = _count(ranges)
    share = np.divide(inside, around, out=np.zeros_like(inside), where=(count > 0) & (around > 0.0))
    return np.minimum(share, 1.0) / np.maximum(count, WIDTH)


def _leaves(triangles: _Triangles, order: NDArray[np.uint32], ranges: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Leaf rows; places without a triangle have all corners at 0, which no ray hits, and no patch's name."""
    place = ranges[:, :1] + np.arange(WIDTH, dtype=np.uint32)
    used = place < ranges[:, 1:]
    which = order[place[used]]
    corners = np.zeros((len(ranges), WIDTH, 9), np.float32)
    corners[used] = triangles.corners[which].transpose(0, 2, 1).reshape(-1, 9)
    name = np.full((len(ranges), WIDTH), 0xFFFFFFFF, np.uint32)
    name[used] = triangles.name[which]
    leaves = np.empty((len(ranges), LEAF_WORDS // WIDTH, WIDTH), np.float32)
    leaves[:, :9] = corners.transpose(0, 2, 1)
    leaves[:, 9] = name.view(np.float32)
    return leaves.reshape(-1, LEAF_WORDS)


def _geometry(device: Device, patches: Patches, local_origin: NDArray[np.float64]) -> PatchGeometry:
    return PatchGeometry(
        origin=device.upload(patches.origin - local_origin, np.float32),
        edge_u=device.upload(patches.edge_u, np.float32),
        edge_v=device.upload(patches.edge_v, np.float32),
        normal=device.upload(patches.normal, np.float32),
        kind=device.upload(patches.is_triangle, np.uint32),
    )
