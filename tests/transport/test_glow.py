"""Which lamps are left to the rays that meet them, and what is left over for shadow rays."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity.options import Options
from hradiosity.planning import make_plan, spectral_columns
from hradiosity.radiosity import solve
from hradiosity.readings.paths import trace_referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_scene
from hradiosity.transport.glow import glow_of, sampled_scene, weak_emitters


def weak_of(device, scene):
    lit = find_lit_sides(scene, build_bvh(device, scene.patches), seed=0)
    return weak_emitters(scene, lit)


def office_like(screen_exitance):
    """A room with a bright lamp, and three screens that shine little."""
    room = cube(0.6, bands=3, side=3.0)
    grey = room.material(0.3)
    room.lamp(room.patch((1.2, 1.2, 2.95), (0, 0.6, 0), (0.6, 0, 0), grey), [500.0, 400.0, 300.0])
    for x in (0.5, 1.3, 2.1):
        room.lamp(room.patch((x, 1.0, 0.8), (0.5, 0, 0), (0, 0, 0.3), grey), screen_exitance)
    room.sensor([(0.75, 0.7, 0.95), (1.5, 0.5, 1.2), (2.0, 2.0, 0.8)], [(0, 1, 0), (0, 1, 0), (0, 0, 1)])
    return room.scene()


def test_screens_are_weak_and_the_lamp_is_not(device):
    assert weak_of(device, office_like(5.0)).tolist() == [False, True, True, True]


def test_the_only_light_of_a_band_is_never_weak(device):
    """In the last band the lamp is dark: what the screens add there is all there is."""
    scene = office_like([5.0, 5.0, 5.0])
    lamp = replace(scene.luminaires[0], exitance=np.array([500.0, 400.0, 0.0]))
    scene = replace(scene, luminaires=(lamp, *scene.luminaires[1:]))
    assert not weak_of(device, scene).any()


def test_walls_that_shine_alike_are_all_weak_together(device):
    """Each wall alone stands out; all six together make no difference between directions."""
    room = cube(0.5)
    room.lamp(range(6), 1.0)
    assert weak_of(device, room.scene()).all()
    one = cube(0.5)
    one.lamp(5, 1.0)
    assert not weak_of(device, one.scene()).any()


def test_point_sources_and_open_scenes_keep_their_shadow_rays(device):
    room = cube(0.5)
    room.lamp(range(6), 1.0)
    room.point((0.5, 0.5, 0.5), 1e-9)
    assert weak_of(device, room.scene()).tolist() == [True] * 6 + [False]
    plate = SceneBuilder()
    plate.lamp(plate.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), plate.material(0.5)), 1.0)
    assert not weak_of(device, plate.scene()).any()


def test_paints_of_shining_sides():
    """Sides that shine get a paint for their material and lamp, the others keep their material."""
    b = SceneBuilder(2)
    dark, bright = b.material(0.1), b.material([0.7, 0.8])
    faces = [b.patch((i, 0, 0), (1, 0, 0), (0, 1, 0), paint) for i, paint in enumerate((dark, bright, bright, dark))]
    b.lamp(faces[:2], [1.0, 2.0])
    b.lamp(faces[2], [3.0, 4.0], two_sided=True)
    scene = b.scene()
    columns = spectral_columns(scene)
    glow = glow_of(scene, columns, np.array([True, True, True]))
    shown = glow.exitance[glow.paint] @ columns.expansion
    np.testing.assert_allclose(shown[:, 0], [[1, 2], [1, 2], [3, 4], [0, 0]])
    np.testing.assert_allclose(shown[:, 1], [[0, 0], [0, 0], [3, 4], [0, 0]])
    np.testing.assert_array_equal(glow.material[glow.paint], np.array([[0, 0], [1, 1], [1, 1], [0, 0]]))
    assert len(sampled_scene(scene, np.array([True, False, True])).emitters) == 1


@pytest.mark.parametrize("glow", [None, False])
def test_readings_beside_screens_hold_the_truth(device, glow):
    """Against unbiased paths, screens left to rays and sampled."""
    scene = office_like([40.0, 20.0, 30.0])
    sensor = scene.sensors[0]
    (readings,) = solve(scene, Options(glow=glow), device).readings.values()
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    truth = trace_referee(on_device, scene, sensor.position, sensor.normal, paths=65536, seed=3)
    allowed = 1.5 * readings.half_width + 3 * truth.standard_error + 0.003 * truth.irradiance
    assert (np.abs(readings.irradiance - truth.irradiance) < allowed).all()


def test_the_plan_names_the_effect(device):
    scene = office_like(5.0)
    lit = find_lit_sides(scene, build_bvh(device, scene.patches), seed=0)
    plan = make_plan(scene, Options(), lit)
    (effect,) = (e for e in plan.effects if e.name == "glow")
    assert effect.needed and "3 of 4 lamps" in effect.because and plan.n_emitters == 1
    forced = make_plan(scene, Options(glow=False), lit)
    assert not forced.weak_emitters.any() and forced.n_emitters == 4
