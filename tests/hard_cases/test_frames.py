"""Hard cases 18 to 21: the same scene elsewhere, turned, in another unit, its faces in another order."""

import numpy as np
import pytest
from polygon_shapes import box_quads, hinged_square
from random_rooms import shuffled
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation

from hradiosity import Options, form_factor, form_factor_matrix, solve

OPTIONS = Options(elements=1200, gather_samples=2048, light_samples=256, rays_per_element=64, light_points=16)
BESIDE_THE_SCREEN = 4
"""The one of the readings that sees part of a lamp."""
QUADS = box_quads(2, (2.0, 1.0, 0.5))


def furnished(reflects=True):
    """A room, a block and a screen in it and two lamps, in two bands; all lengths are multiples of 1/4."""
    b = SceneBuilder(2)
    paint = [b.material(rho if reflects else 0.0) for rho in ((0.7, 0.5), (0.3, 0.6), (0.5, 0.5), (0.8, 0.2))]
    b.box((0, 0, 0), (4, 3, 2.5), [paint[k % 4] for k in range(6)], inward=True)
    b.box((0.5, 0.75, 0), (1.5, 2, 0.75), paint[1], solid=True)
    b.patch((2.5, 0.5, 0.25), (1, 0.25, 0), (0, 0.25, 1.5), paint[3], triangle=True)
    b.lamp(b.patch((1.5, 1, 2.25), (0, 1, 0), (1, 0, 0), paint[2]), (10.0, 20.0))
    b.lamp(b.patch((3.5, 2.5, 1.75), (0, 0.25, 0.25), (0.25, 0, 0), paint[2]), (40.0, 10.0))
    places = [(2, 1, 0), (3.25, 1.5, 0.75), (1, 1.25, 0.75), (0.25, 1.5, 0.25), (2.75, 0.25, 1), (0, 2.5, 1.25)]
    b.sensor(places, [(0, 0, 1), (0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 0.6, 0.8), (1, 0, 0)])
    return b.scene()


def read(scene, device, options=OPTIONS):
    (readings,) = solve(scene, options, device).readings.values()
    return readings


@pytest.fixture(scope="module")
def here(device):
    """The readings of the scene as it is."""
    return read(furnished(), device)


def assert_same_light(one, other):
    """Two independent estimates: within 2.5 times their common half width, as those of few replicates vary."""
    difference = np.abs(one.irradiance - other.irradiance)
    assert (difference < 2.5 * np.hypot(one.half_width, other.half_width) + 2e-3 * one.irradiance).all()
    assert (difference < 0.03 * one.irradiance).all()


@pytest.mark.parametrize("shift", [(1e3, -1e3, 1e3), (1e6, -1e6, 1e5)], ids=["18-1e3", "18-1e6"])
def test_case_18_the_scene_far_away(device, here, shift):
    found = read(moved(furnished(), shift=np.array(shift)), device)
    np.testing.assert_allclose(found.irradiance, here.irradiance, rtol=1e-6)
    np.testing.assert_allclose(found.half_width, here.half_width, rtol=1e-3)


@pytest.mark.parametrize("shift", [1e3, 1e6], ids="18-{:g}".format)
def test_case_18_form_factors_far_away(device, shift):
    """A micrometre lies in the rounding of coordinates of 1e6 m already: 1e-10 of the sizes here."""
    near = form_factor_matrix(QUADS, method="contour", device=device).value
    far = form_factor_matrix(QUADS + [shift, -shift, shift], method="contour", device=device).value
    np.testing.assert_allclose(far, near, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("seed", range(4), ids="19-{}".format)
def test_case_19_turned_at_random(device, here, seed):
    turn = Rotation.random(random_state=seed).as_matrix()
    assert_same_light(here, read(moved(furnished(), rotation=turn), device))


def test_case_19_form_factors_turned_at_random(device):
    exact = form_factor_matrix(QUADS, method="contour", device=device).value
    for seed in range(4):
        turn = Rotation.random(random_state=seed).as_matrix()
        found = form_factor_matrix(QUADS @ turn.T, method="contour", device=device).value
        np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("factor", [2.0**-10, 2.0**10], ids=["20-1/1024", "20-1024"])
def test_case_20_scaled_by_a_power_of_two(device, here, factor):
    found = read(moved(furnished(), factor=factor), device)
    np.testing.assert_allclose(found.irradiance, here.irradiance, rtol=1e-6)


@pytest.mark.parametrize("factor", [1e-3, 1e3], ids="20-{:g}".format)
def test_case_20_metres_taken_for_millimetres(device, here, factor):
    assert_same_light(here, read(moved(furnished(), factor=factor), device))
    near = form_factor(QUADS[0], hinged_square(120.0), method="contour", device=device).value
    found = form_factor(factor * QUADS[0], factor * hinged_square(120.0), method="contour", device=device).value
    assert found == pytest.approx(near, rel=1e-10)


def test_the_shuffled_scene_is_the_same_scene():
    scene = furnished()
    other = shuffled(scene, 1).patches
    np.testing.assert_allclose(np.sort(other.area), np.sort(scene.patches.area), rtol=1e-12)
    for rows in (scene.patches, other):
        order = np.lexsort(np.round(rows.centroid, 9).T)
        flow = rows.normal[order] * rows.area[order, None]
        expected = scene.patches.normal * scene.patches.area[:, None]
        np.testing.assert_allclose(flow, expected[np.lexsort(np.round(scene.patches.centroid, 9).T)], atol=1e-12)
    assert not np.array_equal(other.origin, scene.patches.origin)


@pytest.mark.parametrize("seed", [1, 2], ids="21-{}".format)
def test_case_21_faces_in_another_order(device, here, seed):
    """Direct light to rounding; what is sampled within the intervals: another corner, other points of a lamp."""
    black = furnished(reflects=False)
    one, other = read(black, device), read(shuffled(black, seed), device)
    sampled = np.arange(len(one)) == BESIDE_THE_SCREEN
    np.testing.assert_allclose(other.irradiance[~sampled], one.irradiance[~sampled], rtol=1e-6)
    one, other = (np.stack([r.irradiance[sampled], r.half_width[sampled]]) for r in (one, other))
    assert (np.abs(one[0] - other[0]) < 2.5 * np.hypot(one[1], other[1])).all()
    assert_same_light(here, read(shuffled(furnished(), seed), device))


def test_case_21_polygons_in_another_order(device):
    order = np.random.default_rng(21).permutation(len(QUADS))
    turned = np.array([np.roll(QUADS[k], k % 4, axis=0) for k in order])
    exact = form_factor_matrix(QUADS, method="contour", device=device).value
    found = form_factor_matrix(turned, method="contour", device=device).value
    np.testing.assert_allclose(found, exact[np.ix_(order, order)], rtol=1e-10, atol=1e-13)
