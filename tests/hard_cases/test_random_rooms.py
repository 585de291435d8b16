"""What holds in every room: closure, balance of flux, reciprocity, linearity, monotony; in every frame, for every band.

Each example is a room of its own in a frame of its own. Intervals hold 95 % of the time and there are hundreds of
readings, so that half widths count three times here, and half a per cent for coarse elements.
"""

from dataclasses import replace

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from polygon_shapes import SQUARE
from random_rooms import FRAMES, ROOMS, places_in

from hradiosity import Options, solve

SMALL = Options(elements=400, gather_samples=512, light_samples=64, rays_per_element=64, light_points=16, replicates=4)
WANTED = np.array([2.0, 5.0])
DIMMER = np.array([1.0, 1.0, 1.0, 0.5, 0.25])
"""Share of its reflectance that each paint has in each of five bands."""
LAMPS = np.array([[1.0, 0.0, 1.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0, 1.0]])
"""Exitance of two lamps in each of five bands."""


def examples(count):
    """The same rooms each time; whoever looks for new ones takes `derandomize` away. Looking for simpler rooms takes
    minutes.
    """
    few = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
    no_shrinking = (Phase.explicit, Phase.generate)
    return settings(max_examples=count, deadline=None, derandomize=True, suppress_health_check=few, phases=no_shrinking)


def any_paint(rng):
    return rng.uniform(0.02, 0.95, 2)


def dimmed_paint(rng):
    return rng.uniform(0.1, 0.95) * DIMMER


def within(difference, half_width, value):
    return (np.abs(difference) <= 3.0 * half_width + 5e-3 * value).all()


def inside(solution):
    """(n_rows,) area [m²] of the elements in the room; 0 for bottoms that stand flush on the floor and see nothing."""
    area = solution.elements.area * solution.surfaces.exposed
    space = solution.surfaces.space
    return np.where(space == np.bincount(space, area).argmax(), area, 0.0)


@examples(20)
@given(room=ROOMS, frame=FRAMES, glow=st.booleans())
def test_uniform_light_closes(device, room, frame, glow):
    """M = (1 − ρ) B on all sides of everything makes E = B at every place, in every band.

    In even light there is no noise; what a reading in six may miss is one of its 512 paths, lost where blocks touch.
    """
    b, size = room.builder(2, any_paint)
    for patch, (_, _, _, triangle, material, _) in enumerate(b.rows):
        b.lamp(patch, (1.0 - b.materials[material].reflectance) * WANTED, two_sided=triangle)
    b.sensor(*places_in(size, room.seed, 6))
    solution = solve(frame.place(b.scene()), replace(SMALL, glow=glow), device)
    readings = solution.readings["s0"]
    error = readings.irradiance / WANTED - 1.0
    assert within(error, readings.half_width / WANTED, 1.0)
    if glow:
        assert np.median(np.abs(error)) < 1e-5
        assert (np.abs(error) > 1e-4).mean() <= 1 / 6 and np.abs(error).max() < 2e-3
    area = inside(solution)
    mean = area @ solution.surfaces.irradiance / area.sum()
    np.testing.assert_allclose(mean, WANTED, rtol=1e-4 if glow else 2e-2)


def with_two_tiles(room):
    """A room with two black lamps of 0.1 m × 0.1 m, 10 mm off two walls that face each other, and readings on both."""
    b, size = room.builder(5, dimmed_paint)
    black = b.material(0.0)
    rng = np.random.default_rng(room.seed + 2)
    for wall, exitance in enumerate(LAMPS):
        x = (0.01, size[0] - 0.01)[wall]
        corner = rng.uniform((0.05, 0.72), (0.85, 0.84)) * size[1:]
        tile = np.insert(0.1 * SQUARE[:, :2] + corner, 0, x, axis=1)
        tile = tile[::-1] if wall else tile
        b.lamp(b.patch(tile[0], tile[1] - tile[0], tile[3] - tile[0], black), exitance)
        share = np.array([(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)])
        places = tile[0] + share[:, :1] * (tile[1] - tile[0]) + share[:, 1:] * (tile[3] - tile[0])
        b.sensor(places, (1.0 - 2.0 * wall, 0.0, 0.0), f"tile{wall}")
    b.sensor(*places_in(size, room.seed, 6), "room")
    return b.scene()


@examples(12)
@given(room=ROOMS, frame=FRAMES)
def test_laws_of_two_lamps(device, room, frame):
    """Five bands: one lamp, the other, both; both with half the reflectance, and with a quarter of it.

    What the lamps send out is absorbed, Σ A (1 − ρ) E = Σ A M; what one lamp gives the other, that gives back; light of
    two lamps is the sum of that of each; and more reflectance means more light everywhere.
    """
    solution = solve(frame.place(with_two_tiles(room)), replace(SMALL, light_points=64), device)
    area = inside(solution)
    reflectance = np.concatenate([solution.scene.reflectance, np.zeros((1, 5))])[solution.elements.row_material]
    absorbed = area @ ((1.0 - reflectance) * solution.surfaces.irradiance)
    direct = area @ solution.surfaces.direct
    np.testing.assert_allclose(absorbed, direct, rtol=5e-3)
    np.testing.assert_allclose(direct, 0.01 * frame.scale**2 * LAMPS.sum(axis=0), rtol=5e-2)
    one, other = (solution.readings[f"tile{wall}"] for wall in (0, 1))
    there, back = one.irradiance[:, 1].mean(), other.irradiance[:, 0].mean()
    assert within(there - back, np.hypot(one.half_width[:, 1].mean(), other.half_width[:, 0].mean()), there)
    for readings in solution.readings.values():
        light = readings.irradiance
        np.testing.assert_allclose(light[:, 0] + light[:, 1], light[:, 2], rtol=1e-3)
        assert (light[:, 2] >= light[:, 3]).all() and (light[:, 3] >= light[:, 4]).all()


def assert_same_light(one, other):
    """Four half widths: of hundreds of comparisons, the worst is far out in the tails of few replicates."""
    both = 4.0 / 3.0 * np.hypot(one.half_width, other.half_width)
    assert within(one.irradiance - other.irradiance, both, one.irradiance)


@examples(8)
@given(room=ROOMS, frame=FRAMES)
def test_no_frame_is_special(device, room, frame):
    """Size, place, position and order of faces change no reading by more than its interval."""
    scene = with_two_tiles(room)
    one, other = (solve(s, SMALL, device).readings["room"] for s in (scene, frame.place(scene)))
    assert_same_light(one, other)


@examples(5)
@given(room=ROOMS, frame=FRAMES, band=st.integers(0, 4))
def test_bands_do_not_touch_each_other(device, room, frame, band):
    scene = frame.place(with_two_tiles(room))
    only = slice(band, band + 1)
    alone = replace(
        scene,
        bands=type(scene.bands)(scene.bands.lower[only], scene.bands.upper[only]),
        materials=tuple(replace(m, reflectance=m.reflectance[only]) for m in scene.materials),
        luminaires=tuple(replace(lamp, exitance=lamp.exitance[only]) for lamp in scene.luminaires),
    )
    together = solve(scene, SMALL, device).readings["room"]
    single = solve(alone, SMALL, device).readings["room"]
    difference = single.irradiance[:, 0] - together.irradiance[:, band]
    half_width = np.hypot(single.half_width[:, 0], together.half_width[:, band])
    assert within(difference, half_width, together.irradiance[:, band])
