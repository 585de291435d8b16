"""Directions that follow the light found before: the tables, the warp, and what they are good for."""

import numpy as np
import pytest
from device_call import device_call
from rooms import SceneBuilder

from hradiosity.model.scene import Sky
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.readings.guide import EVEN_SHARE, SIDE, guide_tables, shares_of
from hradiosity.readings.paths import trace_referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene


def warped(device, shares, u, v):
    """(n, 3) of the warp of points by one table."""
    table = np.resize(guide_tables(shares)[0], len(u))
    assert len(u) >= guide_tables(shares).shape[1]
    return device_call(
        device, "hr_guide.h", "hr_guide(in_table, u, v)", "float3",
        table=table, u=u.astype(np.float32), v=v.astype(np.float32),
    )  # fmt: skip


def even_points(n):
    """A grid of n × n points in the unit square."""
    at = (np.arange(n) + 0.5) / n
    return (part.ravel() for part in np.meshgrid(at, at))


def test_tables_add_up_on_every_level():
    shares = shares_of(np.random.default_rng(0).random((3, SIDE * SIDE)) ** 4)
    tables = guide_tables(shares)
    assert tables.shape == (3, 4 + 16 + 64 + 256 + 1024)
    for first, last in ((0, 4), (4, 20), (20, 84), (84, 340), (340, 1364)):
        np.testing.assert_allclose(tables[:, first:last].sum(axis=1), 1.0, rtol=1e-6)
    quarter = shares.reshape(3, SIDE, SIDE)[:, : SIDE // 2, SIDE // 2 :].sum(axis=(1, 2))
    np.testing.assert_allclose(tables[:, 1], quarter, rtol=1e-6)


def test_shares_are_bounded_below_and_even_without_light():
    one = np.zeros((1, SIDE * SIDE))
    np.testing.assert_allclose(shares_of(one), 1.0 / SIDE**2)
    one[0, 5 * SIDE + 7] = 3.0
    share = shares_of(one).reshape(SIDE, SIDE)
    assert share.min() == pytest.approx(EVEN_SHARE / SIDE**2, rel=1e-6)
    np.testing.assert_allclose(share[4:7, 6:9], EVEN_SHARE / SIDE**2 + (1 - EVEN_SHARE) / 9, rtol=1e-6)


def test_the_warp_follows_the_shares(device):
    """Of 400 × 400 even points each part gets its share, up to those that lie at its rim."""
    shares = shares_of(np.random.default_rng(1).random((1, SIDE * SIDE)) ** 3)
    found = warped(device, shares, *even_points(400))
    part = np.floor(found[:, :2] * SIDE).astype(int)
    counted = np.bincount(part[:, 1] * SIDE + part[:, 0], minlength=SIDE * SIDE) / len(found)
    np.testing.assert_allclose(counted, shares[0], atol=2e-4)
    np.testing.assert_allclose(1.0 / (found[:, 2] * SIDE**2), shares[0][part[:, 1] * SIDE + part[:, 0]], rtol=1e-5)


def test_weights_make_the_warp_even_again(device):
    """Means of weight times f are integrals over the square, here of polynomials."""
    shares = shares_of(np.random.default_rng(2).random((1, SIDE * SIDE)) ** 6)
    u, v, weight = warped(device, shares, *even_points(1000)).astype(np.float64).T
    for value, exact in ((u * 0 + 1, 1.0), (u, 0.5), (v * v, 1 / 3), (u * v, 0.25)):
        assert (weight * value).mean() == pytest.approx(exact, rel=1e-3)


def test_even_shares_change_nothing(device):
    u, v = even_points(50)
    found = warped(device, shares_of(np.zeros((1, SIDE * SIDE))), u, v)
    np.testing.assert_allclose(found, np.column_stack([u, v, np.ones(len(u))]), atol=2e-7)


def sky_window(width):
    """A black box with a square hole in its roof, under an even sky; a reading on the floor's middle."""
    b = SceneBuilder(1, sky=Sky(np.ones(1)))
    black, low, high = b.material(0.0), 0.5 - width / 2, 0.5 + width / 2
    for corner, eu, ev in (
        ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
        ((0, 1, 0), (0, 0, 1), (1, 0, 0)), ((0, 0, 0), (0, 1, 0), (1, 0, 0)),
        ((0, 0, 1), (1, 0, 0), (0, low, 0)), ((0, high, 1), (1, 0, 0), (0, low, 0)),
        ((0, low, 1), (low, 0, 0), (0, width, 0)), ((high, low, 1), (low, 0, 0), (0, width, 0)),
    ):  # fmt: skip
        b.patch(corner, eu, ev, black)
    b.sensor((0.5, 0.5, 0.001), (0, 0, 1))
    return b.scene()


def test_sky_through_a_small_hole(device):
    """A hole of 0.6 % of the view; E = π F with F = (4 / π) (a / √(1 + a²)) atan(a / √(1 + a²)) at height 1.

    Even directions would leave a standard error of 20 % with these 4096 paths, and none of less than 4 % by luck.
    """
    a = 0.05 / 0.999
    side = a / np.sqrt(1 + a * a)
    exact = 4 * side * np.arctan(side)
    found = [
        next(iter(solve(sky_window(0.1), Options(gather_samples=4096, seed=seed), device).readings.values())).irradiance
        for seed in range(4)
    ]
    np.testing.assert_allclose(found, exact, rtol=0.04)


def test_a_room_that_is_lit_through_a_gap(device):
    """Two rooms and a slit of 10 cm in the wall between: within the intervals, and these below 25 %."""
    b = SceneBuilder(1)
    white = b.material(0.7)
    left = b.box((0, 0, 0), (2, 2, 2), white, inward=True)
    right = b.box((2, 0, 0), (4, 2, 2), white, inward=True)
    keep = [i for i in range(len(b.rows)) if i not in (left[1], right[0])]
    b.rows = [b.rows[i] for i in keep]
    for y, width in ((0.0, 0.95), (1.05, 0.95)):
        b.patch((2, y, 0), (0, width, 0), (0, 0, 2), white)
    b.lamp(b.patch((0.5, 0.5, 1.95), (0, 1, 0), (1, 0, 0), white), 100.0)
    b.sensor([(3.0, 1.0, 0.8), (3.5, 0.3, 0.5), (2.3, 1.7, 1.5)], [(0, 0, 1), (-1, 0, 0), (0, -1, 0)])
    scene = b.scene()
    (readings,) = solve(scene, Options(), device).readings.values()
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    sensor = scene.sensors[0]
    truth = trace_referee(on_device, scene, sensor.position, sensor.normal, paths=65536, seed=3)
    allowed = 1.5 * readings.half_width + 3 * truth.standard_error + 0.03 * truth.irradiance
    assert (np.abs(readings.irradiance - truth.irradiance) < allowed).all()
    assert (readings.half_width < 0.25 * readings.irradiance).all()
