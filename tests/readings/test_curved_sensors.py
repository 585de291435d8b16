"""Readings of cylinders, half cylinders, spheres, and of eyes with a limited field of view, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from device_call import device_call
from rooms import SceneBuilder, cube

from hradiosity.model.scene import Sensor, Sky
from hradiosity.model.sensor_kinds import FieldOfView, curved_sensor, masked_eyes
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.radiosity.referee import run_referee

UP = np.array([0.0, 0.0, 1.0])
KINDS = ("cylindrical", "semi-cylindrical", "spherical")
QUICK = Options(replicates=2, element_size=1.0, rays_per_element=64, gather_samples=4096, light_samples=1024)


def unit(*vector):
    return np.array(vector) / np.linalg.norm(vector)


def facing_for(axis):
    """Some direction across the axis."""
    return unit(*np.cross(axis, [0.3, 0.7, -0.2]))


def sensor_of(kind, place=(0.0, 0.0, 0.0), axis=UP, facing=None):
    places = np.atleast_2d(np.array(place, float))
    ahead = (
        None
        if kind != "semi-cylindrical"
        else np.tile(facing_for(axis) if facing is None else facing, (len(places), 1))
    )
    return curved_sensor(kind, places, kind, axis=axis, facing=ahead)


def weight_of(kind, directions, axis=UP, facing=None):
    """(n,) response w to light from unit directions, straight from the definitions."""
    along = directions @ axis
    sine = np.sqrt(np.maximum(1.0 - along**2, 0.0))
    if kind == "spherical":
        return np.full(len(directions), 0.25)
    if kind == "cylindrical":
        return sine / np.pi
    ahead = facing_for(axis) if facing is None else facing
    return (sine + directions @ ahead) / np.pi  # sin ε (1 + cos α)


def sphere_directions(n, seed=1):
    drawn = np.random.default_rng(seed).normal(size=(n, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def kernel_weight(device, sensor, directions):
    """(n,) weights of the first plane's table, by the device function."""
    table = np.zeros(len(directions), np.float32)
    table[:12] = sensor.parts.response[0]
    call = "hr_response(in_table, 0, d)"
    return device_call(device, "hr_response.h", call, table=table, d=directions.astype(np.float32))


def solved(scene, device, options=QUICK):
    readings = solve(scene, options, device).readings
    return {name: found.irradiance[:, 0] for name, found in readings.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("axis", [UP, unit(1.0, -2.0, 0.5)])
def test_planes_and_weights_make_the_response(device, kind, axis):
    """Σ_j g(ω) max(n_j · ω, 0) is w(ω) for every direction."""
    sensor = sensor_of(kind, axis=axis)
    directions = sphere_directions(2000)
    g = kernel_weight(device, sensor, directions)
    planes = np.maximum(directions @ sensor.normal.T, 0.0).sum(axis=1)
    np.testing.assert_allclose(g * planes, weight_of(kind, directions, axis), atol=2e-6)
    assert g.max() < 2.01 / np.pi


def test_field_of_view_is_an_ellipse_in_each_quarter(device):
    field = FieldOfView(50.0, 70.0, 90.0, 60.0)
    ahead, up = unit(1.0, 2.0, 0.0), UP
    eye = masked_eyes(Sensor("e", np.zeros((1, 3)), ahead[None]), field, up)
    directions = sphere_directions(3000)
    found = kernel_weight(device, eye, directions)
    left = directions @ np.cross(up, ahead)
    above = directions @ up
    angle = np.degrees(np.arccos(np.clip(directions @ ahead, -1, 1)))
    off = np.hypot(left, above)
    x = angle * left / off / np.where(left > 0, 90.0, 60.0)
    y = angle * above / off / np.where(above > 0, 50.0, 70.0)
    inside = x**2 + y**2
    clear = np.abs(inside - 1) > 1e-3
    np.testing.assert_array_equal(found[clear], (inside < 1)[clear])


@pytest.mark.parametrize("weak", ["auto", "off"])
def test_in_a_furnace_all_kinds_read_the_same(device, weak):
    builder = cube(0.5)
    builder.lamp(list(range(6)), 1.0)
    builder.sensor((0.4, 0.3, 0.6), unit(1, 2, -1), "plane")
    builder.sensors += [sensor_of(kind, (0.4, 0.3, 0.6), unit(1.0, 0.4, 2.0)) for kind in KINDS]
    whole = masked_eyes(Sensor("eye", np.array([[0.4, 0.3, 0.6]]), UP[None]), FieldOfView(), unit(1, 0, 0))
    options = replace(QUICK, element_size=0.25, glow=weak != "off")
    found = solved(replace(builder.scene(), sensors=(*builder.sensors, whole)), device, options)
    np.testing.assert_allclose(list(found.values()), 2.0, rtol=2e-3)


def below_and_above(kind, axis):
    """Under a uniform sky with black ground: ∫ w dω over the upper half, by even points on the sphere."""
    directions = sphere_directions(400_000, 3)
    above = directions[:, 2] > 0.0
    return 4.0 * np.pi * (weight_of(kind, directions, axis) * above).mean()


def open_ground(sensors, sky=1.0):
    builder = SceneBuilder()
    builder.patch((-1, -1, -1), (2, 0, 0), (0, 2, 0), builder.material(0.0))
    builder.sky = Sky(np.array([sky]))
    return replace(builder.scene(), sensors=tuple(sensors))


def test_under_an_even_sky(device):
    """An upright cylinder, half cylinder and any sphere get half of what a level plane gets, π L."""
    found = solved(open_ground([sensor_of(kind) for kind in KINDS]), device)
    np.testing.assert_allclose(np.array(list(found.values())), 0.5 * np.pi, rtol=5e-3)
    lying = unit(1.0, 0.0, 0.0)
    found = solved(open_ground([sensor_of(kind, axis=lying) for kind in KINDS[:2]]), device)
    for kind in KINDS[:2]:
        assert found[kind] == pytest.approx(below_and_above(kind, lying), rel=5e-3)


@pytest.mark.parametrize("half_angle", [20.0, 45.0, 80.0])
def test_a_round_field_of_view_looks_at_the_sky(device, half_angle):
    """E = π L sin²β."""
    field = FieldOfView(half_angle, half_angle, half_angle, half_angle)
    eye = masked_eyes(Sensor("eye", np.zeros((1, 3)), UP[None]), field, unit(1, 0, 0))
    (found,) = solved(open_ground([eye]), device).values()
    assert found == pytest.approx(np.pi * np.sin(np.radians(half_angle)) ** 2, rel=4e-3)


def lamp_scene(sensors, corner=(-0.5, -0.3, 1.5), width=1.0, depth=0.6, points=()):
    """A black lamp that shines down, and nothing else that reflects."""
    builder = SceneBuilder()
    black = builder.material(0.0)
    lamp = builder.patch(corner, (0, depth, 0), (width, 0, 0), black)
    builder.lamp(lamp, 1.0)
    builder.patch((-50, -50, -9), (100, 0, 0), (0, 100, 0), black)
    for position, intensity in points:
        builder.point(position, intensity)
    return replace(builder.scene(), sensors=tuple(sensors))


def by_summation(weight, place, corner, width, depth, n=800):
    """∫ w L dω over the lamp of `lamp_scene`, L = 1/π, by the midpoint rule in double precision."""
    u, v = np.meshgrid((np.arange(n) + 0.5) / n * width, (np.arange(n) + 0.5) / n * depth, indexing="ij")
    to_lamp = np.stack([corner[0] + u, corner[1] + v, np.full_like(u, corner[2])], axis=-1).reshape(-1, 3) - place
    square = (to_lamp**2).sum(axis=1)
    directions = to_lamp / np.sqrt(square)[:, None]
    return (weight(directions) * directions[:, 2] / square).sum() * (width / n) * (depth / n) / np.pi


@pytest.mark.parametrize("place", [(0.1, 0.0, 0.0), (2.0, 1.0, 0.5), (-3.0, 4.0, -2.0), (0.2, 0.1, 1.3)])
@pytest.mark.parametrize("kind", KINDS)
def test_under_a_lamp(device, kind, place):
    """From far and near; the last place is 0.2 m below a lamp of 1 m."""
    axis = unit(0.3, -0.2, 1.0)
    scene = lamp_scene([sensor_of(kind, place, axis)])
    expected = by_summation(lambda d: weight_of(kind, d, axis), place, (-0.5, -0.3, 1.5), 1.0, 0.6)
    assert solved(scene, device, replace(QUICK, glow=False))[kind] == pytest.approx(expected, rel=4e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_beside_a_point_source(device, kind):
    """E = I w / r²."""
    place, source = np.array([0.5, -0.25, 0.25]), np.array([2.0, 1.0, 1.0])
    scene = lamp_scene([sensor_of(kind, place)], corner=(-0.5, -0.3, -8.0), points=[(source, 3.0)])
    way = source - place
    expected = 3.0 * weight_of(kind, unit(*way)[None])[0] / (way @ way)
    assert solved(scene, device)[kind] == pytest.approx(expected, rel=1e-5)


def test_half_a_lamp_is_out_of_view(device):
    """The middle of the lamp is straight ahead; the right half of the field is shut, nearly."""
    eye = Sensor("open", np.zeros((1, 3)), UP[None])
    shut = masked_eyes(replace(eye, name="shut"), FieldOfView(right=1e-4), unit(1, 0, 0))
    narrow = masked_eyes(replace(eye, name="narrow"), FieldOfView(left=1e-4, right=1e-4), unit(1, 0, 0))
    found = solved(lamp_scene([eye, shut, narrow]), device, replace(QUICK, glow=False))
    assert found["shut"] == pytest.approx(0.5 * found["open"], rel=2e-3)
    assert found["narrow"] < 1e-3 * found["open"]


def test_solver_and_unbiased_paths_agree_in_a_furnished_room(device):
    """With shadows, a lamp near by, several lamps, and light reflected from all sides."""
    builder = cube([0.7, 0.3, 0.5, 0.6, 0.2, 0.8], side=3.0)
    grey = builder.material(0.5)
    builder.lamp(builder.patch((1.0, 1.0, 2.9), (0, 0.5, 0), (0.8, 0, 0), grey), 10.0)
    builder.lamp(builder.patch((0.05, 1.0, 1.0), (0, 0.4, 0), (0, 0, 0.4), grey), 5.0)
    builder.box((1.2, 1.2, 0.0), (1.8, 1.9, 0.9), grey, solid=True)
    places = [(0.5, 1.2, 1.2), (2.5, 2.5, 0.4)]
    sensors = [sensor_of(kind, places) for kind in KINDS]
    gaze = Sensor("eye", np.array(places), np.array([unit(-1, 0, 0), unit(0, -1, 0)]))
    scene = replace(builder.scene(), sensors=(*sensors, masked_eyes(gaze, FieldOfView(50, 70, 80, 60), UP)))
    options = Options(replicates=6, element_size=0.3, gather_samples=2048, light_samples=256, seed=4)
    found = solve(scene, options, device).readings
    truth = run_referee(scene, device, 1 << 15, seed=9)
    for name, readings in found.items():
        assert len(readings) == 2
        off = np.abs(readings.irradiance - truth[name].irradiance)
        assert (off <= 1.5 * np.hypot(readings.half_width, truth[name].half_width)).all(), name
        assert (readings.half_width < 0.06 * readings.irradiance).all()
