"""Rays: hits against a float64 referee, no leak at edges and corners, what is skipped, ties."""

import numpy as np
import pytest
from device_call import device_call
from ray_scenes import box, brute_force, from_triangles, make_patches, random_patches, sphere_triangles
from scipy.spatial.transform import Rotation

from hradiosity.model.geometry import BACK, FRONT, NONE
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_any, trace_closest


def random_rays(rng, n, reach=1.5):
    """Origins in a cube and directions of any length, both exactly representable in float32."""
    origins = rng.uniform(-reach, reach, (n, 3)).astype(np.float32)
    directions = rng.normal(size=(n, 3)).astype(np.float32)
    return origins.astype(float), directions.astype(float)


@pytest.mark.parametrize("n_patches", [1, 3, 9, 70, 500])
def test_hits_agree_with_every_patch_tried_in_double(device, n_patches):
    rng = np.random.default_rng(n_patches)
    patches = random_patches(rng, n_patches)
    bvh = build_bvh(device, patches)
    origins, directions = random_rays(rng, 4000)
    hits = trace_closest(bvh, origins, directions)
    patch, side, t, u, v = brute_force(patches, origins, directions)
    # Rays within rounding of an edge may go either way: fewer than 1 in 1000 here.
    assert np.count_nonzero(hits.patch != patch) <= 4
    same = (hits.patch == patch) & (patch != NONE)
    assert same.any()
    np.testing.assert_array_equal(hits.side[same], side[same])
    # Edge functions round relative to the distance of the corners; slivers and grazing rays magnify that.
    for ours, exact in ((hits.t, t), (hits.u, u), (hits.v, v)):
        error = np.abs(ours[same] - exact[same])
        assert np.quantile(error, 0.99) < 2e-6
        assert error.max() < 1e-3
    missed = hits.patch == NONE
    assert np.isinf(hits.t[missed]).all()


def test_any_hit_is_whether_there_is_a_closest_hit(device):
    rng = np.random.default_rng(5)
    bvh = build_bvh(device, random_patches(rng, 300))
    origins, directions = random_rays(rng, 20_000)
    t_max = rng.uniform(0.1, 1.5, len(origins))
    skip = rng.integers(-1, 300, len(origins))
    hits = trace_closest(bvh, origins, directions, t_max, skip)
    blocked = trace_any(bvh, origins, directions, t_max, skip)
    np.testing.assert_array_equal(blocked, hits.patch != NONE)
    assert 0.05 < blocked.mean() < 0.95


def test_distance_limit_is_exclusive_and_skipped_patches_let_through(device):
    planes = make_patches([[-1, -1, 1], [-1, -1, 2]], [[2, 0, 0]] * 2, [[0, 2, 0]] * 2, False)
    bvh = build_bvh(device, planes)
    origin, direction = np.array([[0.25, 0.5, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    hit = trace_closest(bvh, origin, direction)
    assert (hit.patch[0], hit.side[0], hit.t[0], hit.u[0], hit.v[0]) == (0, BACK, 1.0, 0.625, 0.75)
    assert trace_closest(bvh, origin, -direction).patch[0] == NONE
    assert trace_closest(bvh, origin, direction, t_max=1.0).patch[0] == NONE
    assert not trace_any(bvh, origin, direction, t_max=1.0)[0]
    assert trace_any(bvh, origin, direction, t_max=np.nextafter(np.float32(1), np.float32(2)))[0]
    through = trace_closest(bvh, origin, direction, skip_patch=0)
    assert (through.patch[0], through.t[0]) == (1, 2.0)
    assert trace_any(bvh, origin, direction, skip_patch=0)[0]
    assert not trace_any(bvh, origin, direction, skip_patch=0, skip_other=1)[0]


@pytest.mark.parametrize("front", [True, False])
def test_side_is_that_of_the_normal(device, front):
    bvh = build_bvh(device, make_patches([[0, 0, 0]], [[1, 0, 0]], [[0, 1, 0]], False))
    z = 1.0 if front else -1.0
    hit = trace_closest(bvh, np.array([[0.75, 0.5, z]]), np.array([[0.0, 0.0, -z]]))
    assert hit.side[0] == (FRONT if front else BACK)


def test_lowest_patch_wins_where_surfaces_coincide(device):
    rng = np.random.default_rng(2)
    patches = random_patches(rng, 40)
    first = np.concatenate([np.arange(40), np.arange(40)[::-1]])
    twice = make_patches(
        patches.origin[first], patches.edge_u[first], patches.edge_v[first], patches.is_triangle[first]
    )
    hits = trace_closest(build_bvh(device, twice), *random_rays(rng, 20_000))
    assert (hits.patch < 40).all()
    assert (hits.patch >= 0).any()


def shots_at_edges(rng, corners, n):
    """Rays from inside to points on the edges of triangles, a tenth of them to the corners themselves."""
    triangle, corner = rng.integers(len(corners), size=n), rng.integers(3, size=n)
    share = np.where(rng.random(n) < 0.1, 0.0, rng.random(n))[:, None]
    target = corners[triangle, corner] * (1 - share) + corners[triangle, (corner + 1) % 3] * share
    origins = rng.uniform(-0.3, 0.3, (n, 3))
    return origins, target - origins


def box_corners(patches):
    corners = patches.corners()
    return np.concatenate([corners[:, [0, 1, 3]], corners[:, [2, 3, 1]]])


def count_leaks(device, n):
    rng = np.random.default_rng(11)
    leaks = 0
    closed = box()
    sphere = sphere_triangles(rng)
    for patches, corners in ((closed, box_corners(closed)), (from_triangles(sphere), sphere)):
        bvh = build_bvh(device, patches)
        for start in range(0, n // 2, 1_000_000):
            origins, directions = shots_at_edges(rng, corners, min(1_000_000, n // 2 - start))
            leaks += np.count_nonzero(trace_closest(bvh, origins, directions).patch == NONE)
            leaks += np.count_nonzero(~trace_any(bvh, origins, directions))
    return leaks


def test_nothing_leaks_between_neighbours(device):
    assert count_leaks(device, 200_000) == 0


@pytest.mark.slow
def test_nothing_leaks_between_neighbours_in_ten_million_rays(device):
    assert count_leaks(device, 10_000_000) == 0


def test_nothing_leaks_along_axes_inside_the_planes_of_boxes(device):
    """A grid of quads: rays along axes start on grid lines, so they run inside the planes of bounding boxes."""
    line = np.linspace(-1, 1, 9)[:-1]
    a, b = (g.ravel() for g in np.meshgrid(line, line))
    e = np.eye(3)
    parts = []
    for axis in range(3):
        x, y = e[(axis + 1) % 3], e[(axis + 2) % 3]
        for level in (-1.0, 1.0):
            parts.append((level * e[axis] + a[:, None] * x + b[:, None] * y, 0.25 * x, 0.25 * y))
    origin = np.concatenate([p[0] for p in parts])
    edge_u, edge_v = (np.concatenate([np.broadcast_to(p[k], p[0].shape) for p in parts]) for k in (1, 2))
    bvh = build_bvh(device, make_patches(origin, edge_u, edge_v, False))
    grid = np.linspace(-1, 1, 17)
    starts = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), -1).reshape(-1, 3)
    starts = starts[np.abs(starts).max(axis=1) < 1]
    for direction in (*e, *-e, *(e + np.roll(e, 1, axis=0)), *(e * 1e-30 + np.roll(e, 1, axis=0))):
        for sign in (1.0, -1.0):
            directions = np.broadcast_to(sign * direction, starts.shape) * np.where(direction == 0, -0.0, 1.0)
            hits = trace_closest(bvh, starts, directions)
            assert (hits.patch != NONE).all()
            assert trace_any(bvh, starts, directions).all()


def test_hits_do_not_depend_on_the_frame(device):
    """A scene far away and turned is hit alike, as coordinates are kept relative to its centre."""
    rng = np.random.default_rng(7)
    patches = random_patches(rng, 200)
    origins, directions = random_rays(rng, 20_000)
    turn = Rotation.random(random_state=3).as_matrix()
    away = np.array([1e6, -2e6, 3e5])
    moved = make_patches(
        patches.origin @ turn.T + away, patches.edge_u @ turn.T, patches.edge_v @ turn.T, patches.is_triangle
    )
    here = trace_closest(build_bvh(device, patches), origins, directions)
    there = trace_closest(build_bvh(device, moved), origins @ turn.T + away, directions @ turn.T)
    same = here.patch == there.patch
    assert np.count_nonzero(~same) <= 20
    hit = same & (here.patch != NONE)
    np.testing.assert_array_equal(here.side[hit], there.side[hit])
    assert np.quantile(np.abs(here.t[hit] - there.t[hit]), 0.99) < 5e-6


def test_offset_origins_do_not_meet_their_own_patch(device):
    """Points rounded to float32 and moved off their patch: no ray into the half space in front comes back to it."""
    rng = np.random.default_rng(9)
    patches = random_patches(rng, 300)
    bvh = build_bvh(device, patches)
    patch = rng.integers(300, size=40_000)
    u, v = 0.5 * rng.random((2, len(patch), 1))
    points = bvh.to_local(patches.origin[patch] + u * patches.edge_u[patch] + v * patches.edge_v[patch])
    normal = patches.normal[patch].astype(np.float32)
    scale = np.full(len(patch), bvh.scale, np.float32)
    off = device_call(device, "hr_bvh.h", "hr_offset_origin(p, n, scale)", "float3", p=points, n=normal, scale=scale)
    directions = rng.normal(size=off.shape)
    directions *= np.sign((directions * patches.normal[patch]).sum(axis=1, keepdims=True))
    hits = trace_closest(bvh, off + bvh.local_origin, directions)
    assert not (hits.patch == patch).any()


@pytest.mark.oclgrind
def test_a_few_rays_for_the_memory_checker(device):
    rng = np.random.default_rng(0)
    patches = random_patches(rng, 60)
    bvh = build_bvh(device, patches)
    origins, directions = random_rays(rng, 64)
    hits = trace_closest(bvh, origins, directions)
    np.testing.assert_array_equal(hits.patch, brute_force(patches, origins, directions)[0])
    np.testing.assert_array_equal(trace_any(bvh, origins, directions), hits.patch != NONE)


def test_rays_without_direction_or_number_miss(device):
    bvh = build_bvh(device, box())
    bad = np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 1.0], [np.inf, 0.0, 0.0]])
    assert (trace_closest(bvh, np.zeros((3, 3)), bad).patch[:2] == NONE).all()
    assert not trace_any(bvh, np.full((3, 3), np.nan), np.ones((3, 3))).any()


def test_no_rays(device):
    bvh = build_bvh(device, box())
    hits = trace_closest(bvh, np.empty((0, 3)), np.empty((0, 3)))
    assert len(hits.patch) == len(hits.t) == len(hits.u) == 0
    assert trace_any(bvh, np.empty((0, 3)), np.empty((0, 3))).shape == (0,)


def test_arrays_that_do_not_match_are_refused(device):
    bvh = build_bvh(device, box())
    with pytest.raises(ValueError, match="origins and directions"):
        trace_closest(bvh, np.zeros((2, 3)), np.ones((3, 3)))
    with pytest.raises(ValueError, match="each of 2 rays"):
        trace_any(bvh, np.zeros((2, 3)), np.ones((2, 3)), t_max=[1.0, 2.0, 3.0])
