"""What later lookups do to readings, found out by a few paths."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.planning import make_plan
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.readings.effort import Effort
from hradiosity.readings.guide import Guides
from hradiosity.readings.later_lookups import MOST_TRIED, Lookups, TriedLookups, some_of, try_lookups
from hradiosity.readings.path_tracing import PathRules, upload_points
from hradiosity.readings.sensors import read_points
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.lit_sides import find_lit_sides

RULES = PathRules(1, 0.5, 2.0)
PAINT = 0.6


def lit_room(device):
    """A bare room of one paint, its light on the elements, and places on its floor."""
    room = SceneBuilder(1)
    paint = room.material([PAINT])
    room.box((0, 0, 0), (3, 4, 2.5), paint, inward=True)
    room.lamp(room.patch((1.2, 1.5, 2.4), (0, 1, 0), (0.6, 0, 0), paint), [1000.0])
    scene = room.scene()
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    options = Options(elements=300, rays_per_element=256)
    solver = SurfaceSolver(device, scene, bvh, lit, make_plan(scene, options, lit), options, Record())
    light = solver.replicate(7)
    x, y = np.meshgrid(np.linspace(0.5, 2.5, 6), np.linspace(0.5, 3.5, 6))
    position = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.8)])
    return solver, light, position, np.tile([0.0, 0.0, 1.0], (x.size, 1))


@pytest.fixture(scope="module")
def room(device):
    return lit_room(device)


def tried(room, seed=1):
    solver, light, position, normal = room
    points = upload_points(solver.on_device, position, normal)
    guides = Guides.even(len(position))
    return try_lookups(solver.on_device, solver.on_device_elements, light, points, guides, RULES, seed)


def test_two_more_reflections_leave_the_square_of_the_reflectance(room):
    """Of the light that is looked up; here light is much the same all over, but for the ceiling that no lamp lights."""
    found = tried(room)
    gain = np.median(found.gain, axis=0)
    assert found.hits.tolist() == [1, 3, 5, 7]
    np.testing.assert_allclose(gain, PAINT ** -(found.hits - 1.0), rtol=0.25)
    assert (np.diff(found.price) > 0.0).all() and found.price[1] == pytest.approx(3.0, rel=0.2)


def test_noise_is_that_of_readings(room):
    """Their spread over many seeds, one path each: evenly spread ones have less. The trial has 128 of each point."""
    solver, light, position, normal = room
    n, spread = len(position), []
    for lookup in (1, 3):
        effort = Effort.even((n, 1), 256, 1, lookup)
        reflected = [
            read_points(
                solver.on_device, solver.on_device_elements, light, position, normal, effort, rules=RULES, seed=seed
            ).irradiance[:, 0]
            for seed in range(150)
        ]
        spread.append(np.var(reflected, axis=0, ddof=1).mean())
    expected = np.median(tried(room).noise[:, 1])
    assert spread[1] / spread[0] == pytest.approx(expected, rel=0.3)
    assert expected > 1.2


def test_the_same_seed_tells_the_same(room):
    np.testing.assert_array_equal(tried(room).noise, tried(room).noise)


def test_readings_that_were_not_tried_are_like_the_median():
    usual = TriedLookups.none(1, 5)
    found = Lookups(
        usual.lookups.hits,
        np.array([[1.0, 2.0, 3.0, 4.0], [1.0, 4.0, 5.0, 6.0], [1.0, 9.0, 9.0, 9.0]]),
        np.array([[1.0, 2.0, 4.0, 8.0], [1.0, 1.0, 1.0, 1.0], [1.0, 3.0, 9.0, 27.0]]),
        np.array([1.0, 2.0, 3.0, 4.0]),
    )
    more = usual.with_more(np.array([0, 2, 4]), found)
    assert more.known.tolist() == [True, False, True, False, True]
    np.testing.assert_array_equal(more.lookups.noise[:4], [[1.0, 4.0, 5.0, 6.0]] * 4)
    np.testing.assert_array_equal(more.lookups.noise[4], found.noise[2])
    np.testing.assert_array_equal(more.lookups.gain[[1, 3]], [[1.0, 2.0, 4.0, 8.0]] * 2)
    np.testing.assert_array_equal(more.lookups.price, found.price)
    again = TriedLookups.of_arrays(more.arrays)
    np.testing.assert_array_equal(again.lookups.noise, more.lookups.noise)


@pytest.mark.parametrize("first", [1, 2, 3])
def test_what_is_usual_is_told_over_the_lookup_that_there_is(first):
    usual = Lookups.usual(first, 2)
    assert usual.hits[0] == first and (np.diff(usual.hits) > 0).all()
    for some in (usual.noise[0], usual.gain[0], usual.price):
        assert some[0] == 1.0 and (np.diff(some) >= 0.0).all() and len(some) == len(usual.hits)
    assert usual.level(np.array([first, 7])).tolist() == [0, len(usual.hits) - 1]


def test_no_more_are_tried_than_tell_enough():
    assert len(some_of(np.arange(5))) == 5
    many = some_of(np.arange(10_000) + 3)
    assert len(many) == MOST_TRIED and many[0] == 3 and many[-1] == 10_002


def test_gain_follows_each_reading():
    lookups = replace(Lookups.usual(1, 2), gain=np.array([[1.0, 2.0, 4.0, 8.0], [1.0, 3.0, 9.0, 27.0]]))
    assert lookups.gain_at(np.array([7, 3])).tolist() == [8.0, 3.0]
