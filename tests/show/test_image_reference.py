"""Path-traced images, and images beside them."""

from dataclasses import replace

import numpy as np
from drawn import QUICK, camera, furnace, furnished_room

from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.radiosity import solve
from hradiosity.show.image import gather_image
from hradiosity.suites.images.comparison import blocks, compare_images, difference_map
from hradiosity.suites.images.reference import PathTracer

ROOM = camera((0.3, 0.3, 1.7), (2.2, 3.2, 0.8), field_of_view=85, width=48, height=32)


def test_path_traced_furnace(device):
    """M0 / (1 - rho) within the noise of the paths, 1 % on average over the picture."""
    scene = furnace(0.5, 2.0)
    view = camera((0.2, 0.25, 0.6), (0.9, 0.8, 0.4), field_of_view=90, width=16, height=12)
    xyz = PathTracer(scene, device).image(view, points=1, paths=64, seed=1)
    expected = 4.0 / np.pi * xyz_weights(scene.bands)[0]
    np.testing.assert_allclose(xyz.mean(axis=(0, 1)), expected, rtol=0.01)


def test_image_agrees_with_a_path_traced_one(device):
    """Over blocks of pixels, where little noise is left: half a unit of CIEDE2000 beyond the noise, luminance 2 %."""
    scene = furnished_room()
    solution = solve(replace(scene, views=(ROOM,)), replace(QUICK, rays_per_element=256, element_size=0.2), device)
    image = np.stack([gather_image(solution, device, ROOM, samples=64, seed=seed).xyz for seed in (0, 1)])
    tracer = PathTracer(scene, device)
    reference = np.stack([tracer.image(ROOM, points=3, paths=32, seed=seed) for seed in (0, 1)])
    found = compare_images(image, reference, float(np.quantile(image[0, ..., 1], 0.9)))
    print(found)
    assert found.block_delta_e_mean < found.block_noise_mean + 0.5
    assert found.delta_e_mean < 1.5 * found.noise_delta_e_mean + 0.5
    assert abs(found.luminance_bias) < 0.02 + 3 * found.luminance_bias_error


def test_equal_images_differ_by_nothing():
    light = np.random.default_rng(0).uniform(0, 300, (2, 20, 30, 3))
    light[1] = light[0]
    found = compare_images(light, light, 100.0)
    assert found.delta_e_mean == found.noise_delta_e_mean == found.block_delta_e_95 == found.luminance_bias == 0.0


def test_noise_alone_is_told_as_such():
    """Two images of one grey with the same noise: what their halves foretell is what they differ by."""
    random = np.random.default_rng(1)
    grey = np.array([47.5, 50.0, 54.4])
    image, reference = (grey * (1 + 0.05 * random.normal(size=(2, 200, 200, 1))) for _ in range(2))
    found = compare_images(image, reference, 100.0)
    assert abs(found.noise_delta_e_mean / found.delta_e_mean - 1.0) < 0.35
    assert found.block_delta_e_mean < 0.2 * found.delta_e_mean


def test_light_above_white_does_not_count():
    bright, brighter = np.full((1, 1, 3), 500.0), np.full((1, 1, 3), 900.0)
    assert difference_map(bright, brighter, 100.0)[0, 0] < 1e-9


def test_blocks_are_means():
    light = np.arange(2 * 17 * 24 * 3, dtype=float).reshape(2, 17, 24, 3)
    assert blocks(light).shape == (2, 2, 3, 3)
    np.testing.assert_allclose(blocks(light)[1, 0, 2], light[1, :8, 16:].mean(axis=(0, 1)))
