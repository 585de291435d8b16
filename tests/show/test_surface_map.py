"""Maps of the illuminance on surfaces: no leak, and nothing but what is asked for."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity import Options
from hradiosity.radiosity import make_solver
from hradiosity.show.surface_map import map_objects, map_surfaces
from hradiosity.suites.maps.points import floor_sides, spread_points

UP = (0.0, 0.0, 1.0)
LOW, HIGH = np.array([0.7, 0.55]), np.array([1.45, 1.3])
FLOOR, CEILING = 4, 5


def room(gap, *, closed):
    """A box over the floor of a room whose ceiling shines; without its bottom unless it is closed.

    gap : between box and floor [m]
    """
    b = SceneBuilder()
    b.box((0, 0, 0), (2, 2, 2), b.material(0.7), inward=True)
    faces = b.box((*LOW, gap), (*HIGH, gap + 0.6), b.material(0.6), solid=closed)
    if not closed:
        del b.rows[faces[FLOOR]]
    b.lamp(CEILING, 100.0)
    inside = [(1.0, 1.0, 0.0), (0.701, 0.551, 0.0), (1.449, 1.0, 0.0)]
    if gap or not closed:
        b.sensor(inside, UP, "under")
    b.sensor([(0.3, 0.3, 0.0)], UP, "beside")
    return b.scene()


def solved_map(device, scene, error):
    solver = make_solver(scene, Options(elements=600, gather_samples=128, light_samples=64), device)
    list(solver.states())
    solution = solver.solution()
    sides = floor_sides(solution.scene, (solver.lit.space >= 0).ravel())
    found = map_surfaces(solution, solver.on_device, sides, error)
    return solution, found


def all_of_the_floor(solution):
    scene = solution.scene
    return spread_points(scene, floor_sides(scene, np.arange(2 * len(scene.patches)) % 2 == 0), 4000)


def under(points):
    return ((points.position[:, :2] > LOW) & (points.position[:, :2] < HIGH)).all(axis=1)


@pytest.mark.parametrize("closed", [False, True], ids=["without-bottom", "closed"])
def test_the_floor_under_a_box_that_stands_on_it_is_exactly_dark(device, closed):
    solution, found = solved_map(device, room(0.0, closed=closed), 0.02)
    points = all_of_the_floor(solution)
    lux, flat = (found.at(points.side, points.u, points.v, flat=kind) for kind in (False, True))
    dark = under(points)
    assert dark.sum() > 300
    # The floor was cut where the box stands, and no light was found to reach that piece: it has no map.
    for light in (lux, flat):
        assert (np.isnan(light[dark]) | (light[dark] == 0.0)).all()
    assert lux[~dark].min() > 0.0
    sides = np.unique(points.side[dark])
    row = solution.elements.cell_row[np.isin(solution.elements.cell_side, sides)]
    assert (solution.surfaces.irradiance[row] == 0.0).all()
    if not closed:
        assert (solution.readings["under"].irradiance == 0.0).all()
    assert solution.readings["beside"].irradiance.min() > 0.0


def test_a_gap_of_a_millimetre_lets_in_what_it_should(device):
    """Light that has come one box height in has met floor and bottom hundreds of times: nothing is left of it."""
    solution, found = solved_map(device, room(1e-3, closed=True), 0.02)
    points = all_of_the_floor(solution)
    lux = found.at(points.side, points.u, points.v)
    deep = ((points.position[:, :2] > LOW + 0.15) & (points.position[:, :2] < HIGH - 0.15)).all(axis=1)
    bright = np.nanmean(lux[~under(points)])
    assert np.nanmax(lux[deep], initial=0.0) < 1e-3 * bright
    assert solution.readings["under"].illuminance[0] < 1e-3 * solution.readings["beside"].illuminance[0]


def test_map_of_an_object(device):
    """Its leaves cover the object and nothing else; at their corners is what sensors there read."""
    b = SceneBuilder()
    room = b.box((0, 0, 0), (2, 2, 2), b.material(0.7), inward=True)
    b.lamp(room[CEILING], 100.0)
    scene = b.scene()
    solver = make_solver(scene, Options(elements=300, gather_samples=512, light_samples=128), device)
    list(solver.states())
    solution = solver.solution()
    found = map_objects(solution, device, ["object"], error=0.05)
    sides = found.corners[:, 2] - found.corners[:, 0]
    area = np.linalg.norm(np.cross(sides, found.corners[:, 3] - found.corners[:, 1]), axis=1) / 2
    assert area.sum() == pytest.approx(24.0, rel=1e-3)
    assert found.n_leaves == len(found.corner_lux)
    floor = np.abs(found.corners[:, :, 2]).max(axis=1) < 1e-9
    middle = floor & (np.abs(found.corners[:, :, :2] - 1.0).max(axis=(1, 2)) < 0.6)
    read = solution.read(found.corners[middle, 0], UP)
    np.testing.assert_allclose(found.corner_lux[middle, 0], read.illuminance, rtol=0.05)
    with pytest.raises(ValueError, match="no object 'table'"):
        map_objects(solution, device, ["table"])
    with pytest.raises(ValueError, match="needs the name of an object; the scene has object"):
        map_objects(solution, device, [])


def test_few_points_are_read_for_many_leaves(device):
    """Shadow edges take leaves, reflected light few of them; both add up to what sensors read."""
    b = SceneBuilder()
    b.box((0, 0, 0), (2, 2, 2), b.material(0.5), inward=True)
    b.patch((0.7, 0.6, 1.0), (0.5, 0, 0), (0, 0.5, 0), b.material(0.5))
    b.lamp(b.patch((0.9, 0.9, 1.9), (0, 0.2, 0), (0.2, 0, 0), b.material(0.5)), 100.0)
    scene = b.scene()
    found = solved_map(device, scene, 0.01)[1]
    assert found.n_leaves > 3 * found.reflected.leaves.is_leaf.sum()
    spread = spread_points(scene, floor_sides(scene, np.arange(2 * len(scene.patches)) % 2 == 0), 200)
    lux = found.at(spread.side, spread.u, spread.v)
    read = make_solver(scene, Options(elements=600, gather_samples=4096, light_samples=4096), device)
    list(read.states())
    sure = read.solution().read(spread.position, UP).illuminance
    assert np.sqrt(((lux - sure) ** 2).mean()) < 0.015 * sure.mean()


def test_points_are_spread_evenly_over_the_floor(device):
    scene = room(0.0, closed=True)
    sides = floor_sides(scene, np.arange(2 * len(scene.patches)) % 2 == 0)
    assert list(sides) == [2 * FLOOR]
    points = spread_points(scene, sides, 4096)
    counts = np.histogram2d(*points.position[:, :2].T, bins=8)[0]
    assert np.abs(counts - 64).max() <= 6
    assert np.abs(points.position[:, 2]).max() < 1e-12
