"""Unbiased paths against exact solutions, and against paths that know of no lamp."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import (
    CASES,
    INWARD,
    SENSOR,
    box_faces,
    box_room,
    expected,
    patches_of,
    scene_of,
    solid_box,
)
from scipy.stats import norm
from scipy.stats import t as student

from hradiosity.model.scene import Sensor
from hradiosity.radiosity.referee import Referee, run_referee
from hradiosity.readings.path_scene import prepare_referee
from hradiosity.readings.paths import SCRAMBLES, PathTotals, trace_referee, trace_round
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_closest
from hradiosity.transport.device_scene import upload_scene

BANDS = 9
"""More than one group of eight, so that padding matters."""
CASE_NAMES = (
    "cube-iso-rho0.90",
    "cube-off-centre-B",
    "cube-lum-ceiling-A",
    "room443-panel-752",
    "room443-offset-mixed",
)


def referee(device, scene, paths, seed=0, **options):
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    (sensor,) = scene.sensors
    return trace_referee(on_device, scene, sensor.position, sensor.normal, paths=paths, seed=seed, **options)


def assert_unbiased(samples, truth, floor=0.0):
    """No value further off than Student's t with the scrambles' degrees of freedom lets one in 10 000 runs be.

    floor: relative error that single precision and the truth itself may have.
    """
    value, error = samples.irradiance, samples.standard_error
    truth = np.broadcast_to(truth, value.shape)
    n_independent = len(value)
    limit = student.ppf(1.0 - 0.5e-4 / n_independent, SCRAMBLES - 1)
    assert (np.abs(value - truth) <= limit * error + floor * np.abs(truth)).all()


def two_boxes_in_a_room(position=((0.5, 0.5, 0.01), (2.0, 2.4, 0.8)), normal=((0, 0, 1), (0, 0, 1))):
    """A room of 3 × 3 × 2.5 m with a low and a high solid box; the ceiling emits in 9 bands."""
    boxes = [
        box_faces(3, 3, 2.5),
        solid_box((0.8, 0.8, 0.0), (1.6, 1.4, 0.7)),
        solid_box((1.8, 1.6, 0), (2.4, 2.2, 1.6)),
    ]
    material = np.repeat([0, 1, 2], 6)
    solid = np.repeat([-1, 0, 1], 6)
    reflectance = np.array([np.linspace(0.2, 0.8, BANDS), np.linspace(0.7, 0.1, BANDS), np.full(BANDS, 0.5)])
    patches = patches_of(np.concatenate(boxes), material, solid)
    return scene_of(patches, reflectance, [(5, np.linspace(1.0, 2.0, BANDS))], position, normal)


def test_uniform_closure_in_a_furnished_room(device):
    """M_i = (1 − ρ_i) B makes the light B everywhere, whatever stands in the room."""
    scene = two_boxes_in_a_room()
    radiosity = np.linspace(3.0, 1.0, BANDS)
    emission = (1.0 - scene.reflectance[scene.patches.material]) * radiosity
    lit = scene_of(
        scene.patches, scene.reflectance, list(enumerate(emission)), scene.sensors[0].position, scene.sensors[0].normal
    )
    samples = referee(device, lit, 4096)
    assert_unbiased(samples, radiosity, floor=1e-5)
    assert (samples.standard_error < 0.015 * radiosity).all()
    assert samples.lost_weight == 0.0
    assert not samples.enclosed.any()


def test_point_source_in_a_black_cube(device):
    """E = I cos³θ / h²; nothing is random, so only single precision is left."""
    x = np.array([[2.0, 2.0, 0.0], [1.0, 2.0, 0.0], [0.1, 3.9, 0.0]])
    scene = scene_of(
        patches_of(box_faces(4, 4, 4), [0] * 6),
        np.zeros((1, BANDS)),
        [(np.full(3, 2.0), np.arange(1.0, 10.0))],
        x,
        [(0, 0, 1)] * 3,
    )
    samples = referee(device, scene, 64)
    distance = np.linalg.norm(x - 2.0, axis=1)
    exact = (2.0 / distance**3)[:, None] * np.arange(1.0, 10.0)
    np.testing.assert_allclose(samples.irradiance, exact, rtol=1e-5)


def test_small_lamp_over_a_large_floor(device):
    """A 2 cm lamp 2.5 m up is a point with M A / π along its normal, to (size/distance)² ≈ 6e-5."""
    lamp = np.array([((-0.01, -0.01, 2.5), (0, 0.02, 0), (0.02, 0, 0))])
    floor = np.array([((-50.0, -50.0, 0.0), (100.0, 0, 0), (0, 100.0, 0))])
    x = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (3.0, -4.0, 0.0)])
    scene = scene_of(
        patches_of(np.concatenate([floor, lamp]), [0, 0]), np.full((1, BANDS), 0.5), [(1, 1e6)], x, [(0, 0, 1)] * 3
    )
    samples = referee(device, scene, 4096)
    exact = 1e6 * 4e-4 / np.pi * 2.5**2 / (x**2 + np.array([0, 0, 2.5]) ** 2).sum(axis=1) ** 2
    assert_unbiased(samples, exact[:, None], floor=1e-4)


def test_sky_over_an_unobstructed_floor(device):
    """A horizontal reading sees all of the sky, E = π L; a vertical one sees half of it and half of the lit floor."""
    floor = patches_of([((-1e3, -1e3, 0), (2e3, 0, 0), (0, 2e3, 0))], [0])
    x = [(0, 0, 0.01), (0, 0, 0.01)]
    scene = scene_of(floor, np.full((1, BANDS), 0.4), [], x, [(0, 0, 1), (1, 0, 0)], sky=2.0)
    samples = referee(device, scene, 4096)
    assert_unbiased(samples, np.pi * 2.0 * np.array([[1.0], [0.5 + 0.5 * 0.4]]), floor=1e-4)


@pytest.mark.parametrize("name", CASE_NAMES)
def test_box_rooms(device, name):
    """Continuous solutions of box rooms, direct and indirect light together."""
    case = CASES[name]
    (readings,) = run_referee(box_room(case), device, 8192, seed=3).values()
    error = readings.illuminance_half_width / student.ppf(0.975, SCRAMBLES - 1)
    limit = student.ppf(1.0 - 0.5e-4 / len(error), SCRAMBLES - 1)
    off = np.abs(readings.illuminance - expected(case))
    assert (off <= limit * error + 2e-5 * expected(case)).all()
    assert (error < 0.02 * expected(case)).all()


def test_agrees_with_paths_that_only_meet_lamps(device):
    """Brute force in numpy: cosine bounces that collect what they hit, in a room with boxes under a bright ceiling."""
    scene = two_boxes_in_a_room()
    samples = referee(device, scene, 16384, seed=1)
    value, error = brute_force(build_bvh(device, scene.patches), scene, 100_000, np.random.default_rng(7))
    spread = np.hypot(samples.standard_error, error)
    assert (np.abs(samples.irradiance - value) < norm.ppf(1 - 1e-5) * spread).all()
    assert (spread < 0.03 * value).all()


def brute_force(bvh, scene, n, rng):
    """Mean and standard error (n_points, n_bands) by paths without next-event estimation; one emitting ceiling."""
    (sensor,) = scene.sensors
    (emitting,), (lamp,) = scene.emitters.patch, scene.luminaires
    normals = scene.patches.normal
    mean, error = [], []
    for x0, n0 in zip(sensor.position, sensor.normal):
        x, normal = np.tile(x0, (n, 1)), np.tile(n0, (n, 1)).astype(float)
        skip, weight = np.full(n, -1), np.ones((n, len(scene.bands)))
        total = np.zeros_like(weight)
        alive = np.arange(n)
        while len(alive):
            out = rng.standard_normal((len(alive), 3))
            out = normal[alive] + out / np.linalg.norm(out, axis=1, keepdims=True)
            hits = trace_closest(bvh, x[alive] + 1e-6 * normal[alive], out, skip_patch=skip[alive])
            shines = (hits.patch == emitting) & (hits.side == 0)
            total[alive[shines]] += weight[alive[shines]] * lamp.exitance
            x[alive] += hits.t[:, None] * out
            normal[alive] = normals[hits.patch] * np.where(hits.side == 0, 1.0, -1.0)[:, None]
            skip[alive] = hits.patch
            weight[alive] *= scene.reflectance[scene.patches.material[hits.patch]]
            going_on = rng.random(len(alive)) < 0.8
            weight[alive] /= 0.8
            alive = alive[going_on & (hits.side == 0)]
        mean.append(total.mean(axis=0))
        error.append(total.std(axis=0) / np.sqrt(n))
    return np.array(mean), np.array(error)


def test_error_falls_at_least_like_the_root_of_the_paths(device):
    """Sixteen times the paths, at most a quarter of the error; room for the scatter of an error with 15 degrees."""
    scene = two_boxes_in_a_room()
    few, many = (referee(device, scene, paths, seed=5) for paths in (1024, 16384))
    ratio = np.sqrt((few.standard_error**2).mean() / (many.standard_error**2).mean())
    assert ratio > 4.0 * 0.75


def test_a_band_is_the_same_alone(device):
    """Roulette looks at the brightest of nine bands; the fourth must still have the value it has alone."""
    scene = two_boxes_in_a_room()
    (sensor,), (lamp,) = scene.sensors, scene.luminaires
    alone = scene_of(
        scene.patches, scene.reflectance[:, 3:4], [(5, lamp.exitance[3:4])], sensor.position, sensor.normal
    )
    among, single = referee(device, scene, 16384, seed=2), referee(device, alone, 16384, seed=3)
    spread = np.hypot(among.standard_error[:, 3:4], single.standard_error)
    limit = student.ppf(1.0 - 0.5e-4, SCRAMBLES - 1)
    assert (np.abs(among.irradiance[:, 3:4] - single.irradiance) <= limit * spread).all()


def test_black_backs_and_enclosed_readings(device):
    """A one-sided sheet over the reading is black from behind; a reading inside a solid is dark, and says so."""
    room = box_faces(2, 2, 2)
    sheet = np.array([((-1.0, -1.0, 1.0), (4.0, 0, 0), (0, 4.0, 0))])
    box = solid_box((0.5, 0.5, 0.2), (0.9, 0.9, 0.6))
    solid = [-1] * 7 + [0] * 6
    patches = patches_of(np.concatenate([room, sheet, box]), [0] * 13, solid)
    places = [(1.5, 1.5, 0.5), (0.7, 0.7, 0.4), (1.5, 1.5, 1.5)]
    scene = scene_of(patches, np.full((1, BANDS), 0.5), [(5, 1.0)], places, [(0, 0, 1)] * 3, two_sided=False)
    samples = referee(device, scene, 256)
    assert not samples.irradiance[:2].any()
    assert (samples.irradiance[2] > 0.5).all()
    np.testing.assert_array_equal(samples.enclosed, [0.0, 1.0, 0.0])


def test_weight_left_at_the_depth_limit_is_reported(device):
    """In a closed room of ρ = 0.8 a path cut at its first hit keeps 0.8."""
    patches = patches_of(box_faces(1, 1, 1), [0] * 6)
    scene = scene_of(patches, np.full((1, BANDS), 0.8), [(5, 1.0)], [(0.5, 0.5, 0.5)], [(0, 0, 1)])
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    prepared = prepare_referee(on_device, scene)
    (sensor,) = scene.sensors
    total = PathTotals(1, BANDS)
    sums = trace_round(prepared, sensor.position, sensor.normal, first_path=0, n_paths=256, seed=0, depth_limit=1)
    total.add(sums, 256)
    assert total.samples().lost_weight == pytest.approx(0.8, rel=1e-6)


def test_same_seed_same_bits_and_interruption_keeps_rounds(device, monkeypatch):
    monkeypatch.setattr("hradiosity.readings.paths.ROUND_PATHS", 1 << 12)
    scene = box_room(CASES["cube-off-centre-B"])
    first, again = (run_referee(scene, device, 1024, seed=9)[SENSOR].irradiance for _ in range(2))
    np.testing.assert_array_equal(first, again)
    other = run_referee(scene, device, 1024, seed=10)[SENSOR].irradiance
    assert (other != first).any()
    stopped = Referee(scene, device, 1024, seed=9)
    state = next(stopped.states())
    assert 0 < state.paths < state.wanted == 1024
    half_way = stopped.readings()[SENSOR]
    assert (np.abs(half_way.irradiance / first - 1.0) < 0.5).all()


def test_no_lamps_and_no_sensors(device):
    patches = patches_of(box_faces(1, 1, 1), [0] * 6)
    dark = scene_of(patches, np.full((1, BANDS), 0.8), [], [(0.5, 0.5, 0.5)], [INWARD["floor"]])
    assert not run_referee(dark, device, 64)[SENSOR].irradiance.any()
    blind = replace(dark, sensors=(Sensor("none", np.zeros((0, 3)), np.zeros((0, 3))),))
    assert len(run_referee(replace(blind, sensors=()), device, 64)) == 0


def test_a_patch_with_two_emitters_is_refused(device):
    patches = patches_of(box_faces(1, 1, 1), [0] * 6)
    scene = scene_of(patches, np.full((1, BANDS), 0.8), [(5, 1.0), (5, 2.0)], [(0.5, 0.5, 0.5)], [(0, 0, 1)])
    with pytest.raises(ValueError, match="two emitters"):
        run_referee(scene, device, 64)
