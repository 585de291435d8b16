"""Device functions of the unbiased paths, one by one."""

import numpy as np
from box_rooms import box_faces, patches_of, scene_of
from device_call import device_call

from hradiosity.device import load_source
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene

RNG = np.random.default_rng(11)


def test_balanced_gain_is_the_formula(device):
    """A k / (chance + A k) in double precision; at most 1, and 0 below either horizon."""
    n = 500
    d, normal, m = (RNG.standard_normal((n, 3)).astype(np.float32) for _ in range(3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    area, chance = RNG.uniform(0.01, 100.0, n).astype(np.float32), RNG.uniform(0.01, 1.0, n).astype(np.float32)
    gain = device_call(
        device, "hr_referee.h", "hr_balanced_gain(n, d, m, area, chance)", n=normal, d=d, m=m, area=area, chance=chance
    )
    offset = d.astype(float)
    cosines = np.maximum((normal * offset).sum(1), 0) * np.maximum(-(m * offset).sum(1), 0)
    arriving = area * cosines / np.pi / (offset**2).sum(1) ** 2
    np.testing.assert_allclose(gain, arriving / (chance + arriving), rtol=2e-5, atol=1e-7)
    assert (gain <= 1.0).all() and (gain > 0.0).any() and (gain == 0.0).any()


def test_lamps_are_drawn_as_often_as_is_said(device):
    """Over a fine comb of numbers the share of each lamp is its chance, and the chances add up to 1."""
    patches = patches_of(box_faces(3, 4, 2), [0] * 6)
    places = [5, 0, 3, np.array([2.0, 1.7, 1.2]), 1]
    scene = scene_of(patches, [[0.5]], [(place, 1.0) for place in places], np.zeros((0, 3)), np.zeros((0, 3)))
    on_device = upload_scene(device, scene, build_bvh(device, patches), occlusion=True)
    comb = ((np.arange(100_000) + 0.5) / 100_000).astype(np.float32)
    drawn = device.empty((len(comb),), np.uint32)
    chance = device.empty((len(comb), 5), np.float32)
    kernel = device.kernel_from_text(load_source(("include/hr_referee.h",)) + DRAW, "draw")
    kernel(
        len(comb),
        **on_device.bvh.patch_arguments(),
        **on_device.emitters,
        power=device.upload(np.array([1.0, 0.1, 0.0, 0.5, 2.0], np.float32)),
        number=device.upload(comb),
        drawn=drawn,
        chance=chance,
    )
    said = device.fetch(chance)[0]
    share = np.bincount(device.fetch(drawn), minlength=5) / len(comb)
    np.testing.assert_allclose(said.sum(), 1.0, rtol=1e-6)
    np.testing.assert_allclose(share, said, atol=1e-4)
    assert said.min() >= 0.02


DRAW = """
__kernel void draw(HR_EMITTER_PARAMS, HR_PATCH_PARAMS, __global const float *power, __global const float *number,
                   __global uint *drawn, __global float *chance, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const float3 x = (float3)(0.2f, 0.1f, -0.9f);
    const float3 n = (float3)(0.0f, 0.0f, 1.0f);
    float total;
    drawn[i] = hr_draw_lamp(x, n, 5, number[i], &total, power, HR_EMITTER, HR_PATCH);
    for (uint e = 0; e < 5; ++e)
        chance[5 * i + e] = hr_lamp_chance(hr_lamp_guess(x, n, e, power, HR_EMITTER, HR_PATCH), total, 5);
}
"""


def test_numbers_of_a_path_are_uniform_and_its_own(device):
    """Each of a path's numbers has mean 1/2 and variance 1/12, and no two of them go together."""
    k = np.arange(4096, dtype=np.uint32)
    calls = [
        ", ".join(f"hr_path_number(k, {depth}u, {min(place, 5)}u, 77u)" for place in range(8)) for depth in range(3)
    ]
    rows = [device_call(device, "hr_referee.h", f"(float8)({call})", "float8", k=k)[:, :6] for call in calls]
    numbers = np.concatenate(rows, axis=1).T
    assert (np.abs(numbers.mean(axis=1) - 0.5) < 5 * np.sqrt(1 / 12 / len(k))).all()
    correlation = np.corrcoef(numbers) - np.eye(len(numbers))
    assert (np.abs(correlation) < 5 / np.sqrt(len(k))).all()
