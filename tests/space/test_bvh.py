"""The structure: every triangle in one leaf and inside its boxes, whatever the input."""

import numpy as np
import pytest
from device_call import device_call
from ray_scenes import box, make_patches, random_patches

from hradiosity.model.geometry import NONE
from hradiosity.space.bvh import LEAF_FLAG, STACK_SIZE, Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_any, trace_closest


def names_below(bvh: Bvh):
    """All triangle names, after checking that boxes hold what is below them; one list for each path from the root."""
    nodes = bvh.device.fetch(bvh.nodes).reshape(-1, 8, 8)
    leaves = bvh.device.fetch(bvh.leaves).reshape(-1, 10, 8)
    references = nodes[:, 6].view(np.uint32)
    names = []
    level = [(0, np.full(3, -np.inf), np.full(3, np.inf))]
    depth = 0
    while level:
        depth += 1
        below = []
        for node, low, high in level:
            for child in range(8):
                box_low, box_high = nodes[node, 0:6:2, child], nodes[node, 1:6:2, child]
                reference = int(references[node, child])
                if reference == LEAF_FLAG:
                    continue
                assert (box_low >= low).all() and (box_high <= high).all()
                if not reference & LEAF_FLAG:
                    below.append((reference, box_low, box_high))
                    continue
                leaf = leaves[reference - LEAF_FLAG]
                own = leaf[9].view(np.uint32)
                used = own != 0xFFFFFFFF
                corners = leaf[:9, used].reshape(3, 3, -1).swapaxes(0, 1)
                assert (corners > box_low[None, :, None]).all() and (corners < box_high[None, :, None]).all()
                names.extend(own[used].tolist())
        level = below
    assert depth == bvh.depth
    return sorted(names)


def all_names(patches):
    n = np.arange(len(patches))
    return sorted([*(2 * n), *(2 * n[~patches.is_triangle] + 1)])


@pytest.mark.parametrize("n", [1, 8, 9, 64, 65, 1000, 5000])
def test_each_triangle_is_in_one_leaf_inside_its_boxes(device, n):
    patches = random_patches(np.random.default_rng(n), n, size=0.05)
    assert names_below(build_bvh(device, patches)) == all_names(patches)


def degenerate_inputs():
    rng = np.random.default_rng(0)
    n = 3000
    zero = np.zeros((n, 3))
    x, y = zero + np.eye(3)[0], zero + np.eye(3)[1]
    yield "same triangle", make_patches(zero, x, y, True)
    size = rng.uniform(0.1, 1, (n, 1))
    yield "same centre", make_patches(-size * [1, 1, 0], 2 * size * [1, 0, 0], 2 * size * [0, 1, 0], False)
    steps = 2.0 ** -np.arange(120)[:, None]
    yield "halving", make_patches(steps * [1, 0, 0], steps * [0.1, 0, 0], steps * [0, 0.1, 0], True)
    line = np.arange(n)[:, None] * [1.0, 0, 0]
    yield "row", make_patches(line, x, y, False)
    sizes = np.repeat([[1e4], [1e-7]], n, axis=0)
    yield "huge and tiny", make_patches(np.tile(zero, (2, 1)), sizes * np.eye(3)[0], sizes * np.eye(3)[1], True)


@pytest.mark.parametrize("patches", [pytest.param(p, id=name) for name, p in degenerate_inputs()])
def test_any_input_builds(device, patches):
    bvh = build_bvh(device, patches)
    found = names_below(bvh)
    assert len(found) == len(set(found))
    assert set(found) <= set(all_names(patches))
    above = patches.centroid[np.unique(np.array(found) // 2)] + [0, 0, 1.0]
    assert trace_any(bvh, above, np.broadcast_to([0.0, 0, -1], above.shape)).mean() > 0.5


def test_a_million_tiny_patches_build(device):
    rng = np.random.default_rng(1)
    n = 500_000
    patches = make_patches(
        rng.uniform(-1, 1, (n, 3)), rng.normal(scale=1e-6, size=(n, 3)), rng.normal(scale=1e-6, size=(n, 3)), False
    )
    bvh = build_bvh(device, patches)
    aim = patches.centroid[:1000]
    origins = aim + 1e-3 * patches.normal[:1000]
    assert 7 * bvh.depth + 8 <= STACK_SIZE
    # Float32 of a scene of size 1 can't hold patches of 1e-6 exactly; most are still hit in the middle.
    assert (trace_closest(bvh, origins, aim - origins).patch == np.arange(1000)).mean() > 0.5


def test_nothing_is_missed_by_everything(device):
    bvh = build_bvh(device, make_patches(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3)), np.empty(0, bool)))
    rays = np.random.default_rng(0).normal(size=(2, 100, 3))
    assert (trace_closest(bvh, *rays).patch == NONE).all()
    assert not trace_any(bvh, *rays).any()
    assert bvh.scale == 1.0


def test_patches_without_area_are_left_out(device):
    patches = make_patches([[0, 0, 0]] * 3, [[1, 0, 0]] * 3, [[0, 1, 0], [2, 0, 0], [0, 0, 0]], [True, False, True])
    assert names_below(build_bvh(device, patches)) == [0]


def test_coordinates_that_are_no_numbers_are_refused(device):
    with pytest.raises(ValueError, match="finite"):
        build_bvh(device, make_patches([[0, np.nan, 0]], [[1, 0, 0]], [[0, 1, 0]], True))


def test_same_patches_give_the_same_bits(device):
    patches = random_patches(np.random.default_rng(4), 3000)
    first, second = (build_bvh(device, patches) for _ in range(2))
    np.testing.assert_array_equal(device.fetch(first.nodes).view(np.uint32), device.fetch(second.nodes).view(np.uint32))
    np.testing.assert_array_equal(
        device.fetch(first.leaves).view(np.uint32), device.fetch(second.leaves).view(np.uint32)
    )


def test_geometry_for_kernels_is_local(device):
    patches = box(half=2.0)
    moved = make_patches(patches.origin + np.array([1e6, 0, 0]), patches.edge_u, patches.edge_v, patches.is_triangle)
    bvh = build_bvh(device, moved)
    arrays = {name: device.fetch(array) for name, array in bvh.patch_arguments().items()}
    np.testing.assert_array_equal(bvh.local_origin, [1e6, 0, 0])
    assert bvh.scale == 2.0
    np.testing.assert_array_equal(arrays["patch_origin"], patches.origin)
    np.testing.assert_array_equal(arrays["patch_normal"], patches.normal)
    assert not arrays["patch_kind"].any()


def test_products_are_not_fused(device):
    """x y - y x is 0 bit for bit only when neither product is fused into the difference."""
    x, y = np.random.default_rng(0).normal(size=(2, 10_000)).astype(np.float32)
    difference = device_call(device, "hr_types.h", "x * y - y * x", x=x, y=y)
    np.testing.assert_array_equal(difference.view(np.uint32), 0)


def test_offset_origin_moves_by_its_share_of_the_size(device):
    rng = np.random.default_rng(0)
    p = rng.uniform(-3, 3, (1000, 3)).astype(np.float32)
    n = rng.normal(size=(1000, 3))
    n = (n / np.linalg.norm(n, axis=1, keepdims=True)).astype(np.float32)
    scale = rng.uniform(0.1, 4, 1000).astype(np.float32)
    moved = device_call(device, "hr_bvh.h", "hr_offset_origin(p, n, scale)", "float3", p=p, n=n, scale=scale)
    length = 2.0**-20 * np.maximum(np.abs(p).max(axis=1), scale)
    np.testing.assert_allclose(moved - p.astype(float), length[:, None] * n, atol=2.0**-23)
    assert (np.abs(moved - p).max(axis=1) > 0).all()


@pytest.mark.parametrize("portable", [False, True])
def test_lanes_and_bits(device, portable):
    header = "hr_lanes.h"
    definitions = {"HR_PORTABLE_LANES": 1} if portable else {}
    truth = -((np.arange(256)[:, None] >> np.arange(8)) & 1).astype(np.int32)
    bits = device_call(device, header, "hr_lanes(truth)", "uint", truth=truth, definitions=definitions)
    np.testing.assert_array_equal(bits, np.arange(256))
    some = np.arange(1, 256, dtype=np.uint32)
    lowest = device_call(device, header, "hr_lowest_bit(x)", "uint", x=some, definitions=definitions)
    np.testing.assert_array_equal(1 << lowest, some & -some.astype(np.int64))


def test_main_axis_and_reciprocal(device):
    v = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32)
    axis = device_call(device, "hr_lanes.h", "hr_main_axis(v)", "uint", v=v)
    np.testing.assert_array_equal(axis, np.abs(v).argmax(axis=1))
    largest = device_call(device, "hr_lanes.h", "hr_largest_magnitude(v)", v=v)
    np.testing.assert_array_equal(largest, np.abs(v).max(axis=1))
    d = np.array([0.0, -0.0, 1e-30, -1e-30, 0.25, -4.0], np.float32)
    reciprocal = device_call(device, "hr_bvh.h", "hr_finite_reciprocal(d)", d=d)
    np.testing.assert_allclose(reciprocal, [1e18, 1e18, 1e18, -1e18, 4.0, -0.25], rtol=2.0**-23)


def test_host_and_kernels_agree_on_the_stack(device):
    assert device_call(device, "hr_bvh.h", "HR_BVH_STACK", "uint", x=np.zeros(1, np.float32))[0] == STACK_SIZE
