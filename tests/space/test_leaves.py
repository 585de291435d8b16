"""Leaves tile their cells, points find theirs, and light is continuous across leaves of two sizes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ray_scenes import make_patches

from hradiosity.space.cell_lookup import cell_frames, locate_cells
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaf_vertices import find_rims, places_in_space, vertex_keys
from hradiosity.space.leaves import NONE, plant_leaves, split_leaves

# Two rectangles of one plane that share an edge, of different division; a triangle beside; a wall upon the floor.
PATCHES = make_patches(
    [(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 0)],
    [(2, 0, 0), (0.7, 0, 0), (2, 0, 0), (2, 0, 0)],
    [(0, 1, 0), (0, 1, 0), (0, 1.5, 0), (0, 0, 1)],
    [False, False, True, False],
)
LABEL = np.zeros((4, 2), np.int64)


def elements_of(size=0.3):
    return build_elements(PATCHES, np.ones((4, 2), bool), np.ones(1, bool), size, grouping=False)


def grown(elements, seed, max_level=3, times=4):
    """Leaves split at random."""
    rng = np.random.default_rng(seed)
    frames = cell_frames(elements, PATCHES.is_triangle)
    leaves = plant_leaves(frames, np.ones(len(frames.side), bool), max_level)
    for _ in range(times):
        able = np.flatnonzero(leaves.is_leaf & (leaves.level < max_level))
        leaves = split_leaves(leaves, able[rng.random(len(able)) < 0.3])
    return leaves


def random_points(n, seed=1):
    rng = np.random.default_rng(seed)
    side = rng.integers(0, 8, n)
    uv = rng.random((n, 2)).astype(np.float32)
    fold = PATCHES.is_triangle[side // 2] & (uv.sum(axis=1) > 1)
    uv[fold] = 1 - uv[fold]
    return side, uv[:, 0], uv[:, 1]


def test_frames_are_the_cells_that_kernels_number():
    elements = elements_of()
    frames = cell_frames(elements, PATCHES.is_triangle)
    corners, _ = cell_corners(PATCHES, elements)
    patch = frames.side // 2
    divisions = elements.divisions[patch]
    middle = (frames.corner + frames.extent[:, None] * np.where(frames.is_triangle, 1 / 3, 1 / 2)[:, None]) / divisions
    centre = PATCHES.origin[patch] + middle[:, :1] * PATCHES.edge_u[patch] + middle[:, 1:] * PATCHES.edge_v[patch]
    count = np.where(frames.is_triangle, 3, 4)[:, None, None]
    expected = np.where(np.arange(4)[None, :, None] < count, corners, 0).sum(axis=1) / count[:, 0]
    np.testing.assert_allclose(centre, np.where(frames.is_triangle[:, None], corners[:, :3].mean(axis=1), expected))


def test_points_are_found_in_their_cells():
    elements = elements_of()
    frames = cell_frames(elements, PATCHES.is_triangle)
    side, u, v = random_points(20000)
    cell, s, t = locate_cells(elements, PATCHES.is_triangle, side, u, v)
    assert (frames.side[cell] == side).all()
    assert (s >= 0).all() and (t >= 0).all() and (np.where(frames.is_triangle[cell], s + t, 1) <= 1 + 1e-6).all()
    steps = frames.corner[cell] + frames.extent[cell, None] * np.stack([s, t], axis=1)
    np.testing.assert_allclose(steps / elements.divisions[side // 2], np.stack([u, v], axis=1), atol=1e-6)
    assert locate_cells(elements, PATCHES.is_triangle, np.array([-1]), u[:1], v[:1])[0][0] < 0


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_leaves_tile_their_cells(seed):
    leaves = grown(elements_of(), seed)
    ends = leaves.is_leaf
    area = np.bincount(leaves.cell[ends], leaves.extent[ends].astype(float) ** 2, len(leaves.root))
    np.testing.assert_array_equal(area, float(leaves.step) ** 2)
    rng = np.random.default_rng(seed)
    cell = rng.integers(0, len(leaves.root), 3000)
    st_ = rng.random((3000, 2)).astype(np.float32)
    fold = leaves.frames.is_triangle[cell] & (st_.sum(axis=1) > 1)
    st_[fold] = 1 - st_[fold]
    node, s, t = leaves.locate(cell, st_[:, 0], st_[:, 1])
    assert leaves.is_leaf[node].all() and (leaves.cell[node] == cell).all()
    assert (s >= -1e-6).all() and (t >= -1e-6).all()
    assert (np.where(leaves.is_triangle[node], s + t, np.maximum(s, t)) <= 1 + 1e-5).all()
    there = leaves.corner[node] + leaves.extent[node, None] * np.stack([s, t], axis=1)
    start, extent = leaves.step * leaves.frames.corner[cell], leaves.step * leaves.frames.extent[cell]
    np.testing.assert_allclose(there, start + extent[:, None] * st_, atol=1e-4 * leaves.step)


def test_only_leaves_below_the_highest_level_are_split():
    leaves = grown(elements_of(), 0)
    with pytest.raises(ValueError, match="only leaves"):
        split_leaves(leaves, np.flatnonzero(~leaves.is_leaf)[:1])
    with pytest.raises(ValueError, match="only leaves"):
        split_leaves(leaves, np.flatnonzero(leaves.level == leaves.max_level)[:1])


def test_cells_without_leaves_have_none():
    frames = cell_frames(elements_of(), PATCHES.is_triangle)
    leaves = plant_leaves(frames, np.arange(len(frames.side)) == 3, 2)
    zero = np.zeros(2, np.float32)
    assert leaves.locate(np.array([3, 4]), zero, zero)[0].tolist() == [0, NONE]


def all_keys(leaves, places):
    nodes = np.flatnonzero(leaves.is_leaf)
    side = np.repeat(leaves.side[nodes], places.shape[1])
    grid = leaves.step * elements_of().divisions.astype(np.int64)[side // 2]
    flat = places.reshape(-1, 2)
    return vertex_keys(find_rims(PATCHES, LABEL), PATCHES.is_triangle, side, flat, grid), side, flat, grid


def test_vertices_are_shared_inside_a_plane_and_never_around_an_edge():
    leaves = grown(elements_of(), 3)
    keys, side, place, grid = all_keys(leaves, leaves.places(np.flatnonzero(leaves.is_leaf)))
    points = places_in_space(PATCHES, side, place, grid, 0.0)
    facing = np.where(side // 2 == 3, 2, 0) + side % 2
    label = np.column_stack([np.round(points * 1e6), facing])
    by_place = np.unique(label, axis=0, return_inverse=True)[1].ravel()
    pairs = np.unique(np.column_stack([by_place, np.unique(keys, return_inverse=True)[1]]), axis=0)
    assert len(pairs) == by_place.max() + 1 == len(np.unique(keys))


def test_labels_keep_sides_apart():
    rims = find_rims(PATCHES, np.arange(8).reshape(4, 2))
    assert len(np.unique(rims.region)) == 8
    assert len(np.unique(find_rims(PATCHES, LABEL).region)) == 4


def test_points_keep_off_the_outline_by_the_inset():
    rng = np.random.default_rng(0)
    side = rng.integers(0, 8, 500)
    grid = np.full((500, 2), 10)
    place = rng.integers(0, 11, (500, 2))
    fold = PATCHES.is_triangle[side // 2] & (place.sum(axis=1) > 10)
    place[fold] = 10 - place[fold]
    points = places_in_space(PATCHES, side, place, grid, 1e-3)
    corners = PATCHES.corners()[side // 2]
    normal = PATCHES.normal[side // 2]
    for k in range(4):
        along = corners[:, (k + 1) % 4] - corners[:, k]
        length = np.linalg.norm(along, axis=1)
        inward = np.cross(normal, along) / np.where(length > 0, length, 1)[:, None]
        distance = np.einsum("ij,ij->i", points - corners[:, k], inward)
        assert (distance[length > 0] > 0.9e-3).all()


def balanced_pair():
    """Two neighbouring cells of one patch, the second one split."""
    frames = cell_frames(elements_of(0.6), PATCHES.is_triangle)
    return split_leaves(plant_leaves(frames, frames.side == 0, 1), np.array([1]))


def test_fan_reproduces_linear_functions_and_has_no_gap():
    leaves = balanced_pair()
    nodes = np.flatnonzero(leaves.is_leaf)
    places = leaves.places(nodes)
    keys, *_ = all_keys(leaves, places)
    keys = keys.reshape(places.shape[:2])
    unique = np.unique(keys)
    corners = np.unique(keys[:, :4])
    vertex = np.full((leaves.n_nodes, 9), NONE, np.int32)
    known = np.isin(keys, corners)
    known[:, 4] = True
    vertex[nodes] = np.where(known, np.searchsorted(unique, keys), NONE)
    assert (vertex[nodes][:, 5:] != NONE).any()
    linear = np.zeros(len(unique))
    linear[np.searchsorted(unique, keys).ravel()] = places.reshape(-1, 2) @ [0.3, -0.7]

    rng = np.random.default_rng(5)
    node = nodes[rng.integers(0, len(nodes), 5000)]
    s, t = rng.random((2, 5000)).astype(np.float32)
    ids, weights = fan_weights(vertex, node, s, t, leaves.is_triangle[node])
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-6)
    assert (weights >= -1e-6).all()
    there = leaves.corner[node] + leaves.extent[node, None] * np.stack([s, t], axis=1)
    np.testing.assert_allclose((weights * linear[ids]).sum(axis=1), there @ [0.3, -0.7], atol=1e-4)

    heights = rng.random(len(unique))
    along = np.linspace(0.01, 0.99, 57, dtype=np.float32)
    left = fan_weights(vertex, np.zeros(57, np.int32), np.ones_like(along), along, np.zeros(57, bool))
    node, s, t = leaves.locate(np.full(57, leaves.cell[1]), np.zeros_like(along), along)
    right = fan_weights(vertex, node, s, t, np.zeros(57, bool))
    values = [(w * heights[i]).sum(axis=1) for i, w in (left, right)]
    np.testing.assert_allclose(*values, atol=1e-5)


def test_fan_of_a_triangle_reproduces_linear_functions():
    rng = np.random.default_rng(2)
    s, t = rng.random((2, 4000)).astype(np.float32)
    fold = s + t > 1
    s[fold], t[fold] = 1 - s[fold], 1 - t[fold]
    # corners, centre and middles of edges at their s + 2 t
    values = np.array([0, 1, 2, 1, 0.5, 1.5, 1])
    for cut in (False, True):
        vertex = np.array([[0, 1, 2, 2, 3, *((4, 5, 6, NONE) if cut else (NONE,) * 4)]], np.int32)
        ids, weights = fan_weights(vertex, np.zeros(4000, np.int64), s, t, np.ones(4000, bool))
        np.testing.assert_allclose((weights * values[ids]).sum(axis=1), s + 2 * t, atol=1e-5)
