"""Cases 26 to 29: sensors in places where they see little, and rays along axes."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube, moved
from scipy.spatial.transform import Rotation
from truths import QUICK, assert_agrees, only, read, rectangle_factor, unbiased

from hradiosity.errors import SceneError
from hradiosity.radiosity import solve
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_closest


def room_with_table(position, normal):
    """A room with a solid table top 0.7 m up, and a lamp below the ceiling."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (4, 4, 2.5), paint, inward=True)
    b.box((1, 1, 0.7), (2, 2, 0.75), b.material(0.3), solid=True)
    b.lamp(b.patch((1.5, 1.5, 2.4), (0, 1, 0), (1, 0, 0), paint), 100.0)
    b.sensor(position, normal, "desk")
    return b.scene()


def test_case_26_a_sensor_inside_a_solid_is_refused(device):
    with pytest.raises(SceneError, match="sensor 'desk' is enclosed, seeing only the inside of 'object'"):
        solve(room_with_table((1.5, 1.5, 0.72), (0, 0, 1)), QUICK, device)


def test_case_26_a_sensor_a_millimetre_under_a_table_top_is_warned_of_and_reads_what_is_there(device):
    scene = room_with_table((1.5, 1.5, 0.699), (0, 0, 1))
    solution = solve(scene, QUICK, device)
    assert any("1 mm under 'object' and facing it" in note.message for note in solution.scene.notes)
    assert_agrees(only(solution), unbiased(scene, device, 65536), bias=0.1)


def test_case_26_only_the_enclosed_points_of_a_sensor_are_told(device):
    solution = solve(room_with_table([(1.5, 1.5, 0.72), (3, 3, 0.72)], (0, 0, 1)), QUICK, device)
    assert any("1 of 2 readings of sensor 'desk' are enclosed" in note.message for note in solution.scene.notes)
    inside, outside = only(solution).irradiance[:, 0]
    assert inside == 0.0 and outside > 0.0
    np.testing.assert_array_equal(only(solution).enclosed, [1.0, 0.0])


OFFSETS = (0.0, 1e-5, 1e-4, 1e-3)


@pytest.mark.parametrize(("x", "y"), [(2.0, 2.0), (2.0, 0.0), (0.0, 0.0)], ids=("surface", "edge", "corner"))
def test_case_27_on_a_surface_at_an_edge_and_in_a_corner(device, x, y):
    """Black cube of 4 m under a luminous ceiling: Lambert's formula, whatever the distance from floor and walls."""
    room = cube(0.0, side=4.0)
    room.lamp(5, 100.0)
    position = [(max(x, e), max(y, e), e) for e in OFFSETS]
    room.sensor(position, (0, 0, 1))
    found = read(room.scene(), device).irradiance[:, 0]
    exact = [100.0 * rectangle_factor(p, (0, 0, 1), (0, 0, 4), (4, 0, 0), (0, 4, 0)) for p in position]
    np.testing.assert_allclose(found, exact, rtol=1e-5)
    np.testing.assert_allclose(found, found[0], rtol=1e-3)


def test_case_27_reflected_light_in_a_corner_does_not_depend_on_the_offset(device):
    """Grey furnace: E = M / (1 − ρ) at surface, edge and corner, but for single paths that end in the edge itself."""
    room = cube(0.5, side=4.0)
    room.lamp(range(6), 1.0)
    places = ((2.0, 2.0), (2.0, 0.0), (0.0, 0.0))
    room.sensor([(max(x, e), max(y, e), e) for e in OFFSETS[1:] for x, y in places], (0, 0, 1))
    np.testing.assert_allclose(read(room.scene(), device).irradiance, 2.0, rtol=1e-3)


def test_case_27_exactly_in_an_edge_is_warned_of(device):
    """Half of the rays start behind the wall, and a reading of half of the light must not pass for the limit."""
    room = cube(0.5, side=4.0)
    room.lamp(range(6), 1.0)
    room.sensor([(2.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 1e-4, 0.0)], (0, 0, 1), "eye")
    solution = solve(room.scene(), QUICK, device)
    assert any("2 of 3 readings of sensor 'eye' are right in a surface" in n.message for n in solution.scene.notes)
    assert only(solution).irradiance[2, 0] == pytest.approx(2.0, rel=1e-3)


def test_case_28_a_sensor_that_faces_away_from_everything_reads_exactly_zero(device):
    b = SceneBuilder()
    b.patch((0, 0, 0), (4, 0, 0), (0, 4, 0), b.material(0.5))
    b.lamp(b.patch((1.5, 1.5, 2), (0, 1, 0), (1, 0, 0), 0), 100.0)
    b.sensor([(2, 2, 3), (5, 5, 0.5)], [(0, 0, 1), (1, 1, 0.1)])
    solution = solve(b.scene(), QUICK, device)
    readings = only(solution)
    assert not readings.irradiance.any() and not readings.half_width.any()
    assert not readings.illuminance.any() and not readings.illuminance_half_width.any()
    notes = [note.message for note in solution.scene.notes if "it reads exactly 0" in note.message]
    assert notes


BOXES = (((1, 1, 1), (2, 2, 2)), ((3, 1, 0.5), (4, 3, 1)), ((1, 3, 2), (2, 4, 4)))
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def test_case_29_rays_along_axes_and_in_planes_of_boxes(device):
    """0 · ∞ in the slab test: the same distances as by interval arithmetic on the boxes, and as in the turned scene."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (5, 5, 5), paint, inward=True)
    for low, high in BOXES:
        b.box(low, high, paint, solid=True)
    patches = b.scene().patches
    rng = np.random.default_rng(5)
    ticks = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5])
    origin = rng.choice(ticks, (4000, 3))
    direction = np.eye(3)[rng.integers(3, size=4000)] * rng.choice([-1.0, 1.0], (4000, 1))
    exact, clear = slab_distances(origin, direction)
    hits = trace_closest(build_bvh(device, patches), origin, direction)
    assert np.isfinite(hits.t).all() and (hits.patch >= 0).all()
    assert clear.sum() > 1000
    np.testing.assert_allclose(hits.t[clear], exact[clear], rtol=1e-6)
    in_planes = clear & (np.isin(origin, [1.0, 2.0, 3.0, 4.0]) & (direction == 0.0)).any(axis=1)
    assert in_planes.sum() > 500
    turned = trace_closest(
        build_bvh(device, moved(b.scene(), rotation=TURN).patches), origin @ TURN.T, direction @ TURN.T
    )
    np.testing.assert_allclose(turned.t[clear], hits.t[clear], rtol=1e-5)
    np.testing.assert_array_equal(turned.patch[clear], hits.patch[clear])


def slab_distances(origin, direction):
    """Distance to the nearest box face or wall in float64, and whether no box is only touched on the way."""
    axis = np.abs(direction).argmax(axis=1)
    sign = direction[np.arange(len(axis)), axis]
    along = origin[np.arange(len(axis)), axis]
    distance = np.where(sign > 0, 5.0 - along, along)
    clear = np.ones(len(origin), bool)
    for low, high in np.array(BOXES, float):
        across = np.delete(np.arange(3)[None].repeat(len(axis), 0).ravel(), np.arange(len(axis)) * 3 + axis).reshape(
            -1, 2
        )
        place = np.take_along_axis(origin, across, axis=1)
        inside = ((place > low[across]) & (place < high[across])).all(axis=1)
        touches = ((place >= low[across]) & (place <= high[across])).all(axis=1) & ~inside
        ahead = np.where(sign > 0, low[axis] - along, along - high[axis])
        behind = np.where(sign > 0, high[axis] - along, along - low[axis]) < 0.0
        clear &= ~touches & (~inside | (ahead > 0.0) | behind)
        distance = np.where(inside & (ahead > 0.0), np.minimum(distance, ahead), distance)
    return distance, clear
