"""Cameras, picking, outlines and marks of the window."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.io.scene_drawing import draw_scene
from hradiosity.model.scene import View
from hradiosity.show.camera import view_axes
from hradiosity.show.window.marks import camera_lines, lamp_places, sensor_lines, sensor_marks
from hradiosity.show.window.navigation import Pose, overview, pose_of_view
from hradiosity.show.window.outlines import FacingOutlines, edge_flags, element_levels, hierarchy_levels
from hradiosity.show.window.picking import CutPlane, pick, pick_cell
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_closest

ANGLES = st.floats(-1.5, 1.5)
START = Pose(np.array([1.0, -2.0, 3.0]), 0.3, -0.4, 2.5, 0.9)


@given(ANGLES, ANGLES)
def test_orbiting_keeps_the_point_and_its_distance(yaw, pitch):
    turned = START.orbited(yaw, pitch)
    np.testing.assert_allclose(turned.focus, START.focus, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(turned.position - START.focus), START.distance)


@given(ANGLES, ANGLES)
def test_axes_are_square_to_each_other(yaw, pitch):
    pose = START.turned(yaw, pitch)
    axes = np.stack([pose.forward, pose.right, pose.up])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(pose.right, pose.forward), pose.up, atol=1e-12)


@given(st.floats(0.0, 300.0), st.floats(0.0, 200.0), st.floats(0.1, 50.0))
def test_rays_and_places_in_the_window_belong_together(x, y, depth):
    ray = START.rays(np.array([x]), np.array([y]), 300, 200)
    np.testing.assert_allclose(START.project(START.position + depth * ray, 300, 200), [[x, y]], atol=1e-8)


def test_walking_stays_level():
    assert START.walked(1.0, 2.0, 0.0).position[2] == START.position[2]
    assert START.walked(0.0, 0.0, 0.5).position[2] == START.position[2] + 0.5


@pytest.mark.parametrize("aspect", [0.7, 4 / 3, 2.0])
@pytest.mark.parametrize("direction", [[1, 0, 0], [0.3, -0.5, 0.2], [0, 0, -1]])
def test_the_window_shows_what_a_view_shows(direction, aspect):
    direction = np.array(direction, float) / np.linalg.norm(direction)
    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    view = View("v", np.array([1.0, 2.0, 3.0]), direction, up, 70.0, 640, 480)
    pose = pose_of_view(view, aspect, 1.0)
    forward, right, down = view_axes(view)
    size = (round(600 * aspect), 600)
    corners = view.position + forward + np.array([-right - down, right - down, right + down, -right + down])
    places = pose.project(corners, *size)
    assert (places >= -2.0).all() and (places <= np.array(size) + 2.0).all()
    widest = np.ptp(places, axis=0) / size
    assert widest.max() == pytest.approx(1.0, abs=0.01), "and hardly more"
    assert places[0, 0] < places[1, 0] and places[0, 1] > places[3, 1]


def test_the_overview_holds_all():
    low, high = np.array([0.0, 0.0, 0.0]), np.array([4.0, 1.0, 2.0])
    pose = overview(low, high, 1.5)
    corners = np.stack(np.meshgrid(*np.stack([low, high]).T), axis=-1).reshape(-1, 3)
    places = pose.project(corners, 900, 600)
    assert (places >= 0.0).all() and (places <= [900, 600]).all()


def test_rays_hit_what_the_ray_structure_says(room, device):
    """Against the device's rays, which share no code; backs of the room's walls are not there to be hit."""
    cells = draw_scene(room).cells
    rng = np.random.default_rng(5)
    origin = np.array([1.7, 0.9, 1.1])
    directions = rng.standard_normal((200, 3))
    bvh = build_bvh(device, room.patches)
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    found = trace_closest(bvh, np.broadcast_to(origin, unit.shape).copy(), unit, 100.0)
    for patch, side, direction in zip(found.patch, found.side, unit, strict=True):
        cell, along = pick_cell(cells, origin, direction, None)
        assert (cells.patch[cell], cells.side[cell]) == (patch, side)
        assert np.isfinite(along)


def test_a_section_hides_from_picking(room):
    cells = draw_scene(room).cells
    origin, direction = np.array([1.5, 1.0, 5.0]), np.array([0.0, 0.0, -1.0])
    lamp, _ = pick_cell(cells, origin, direction, None)
    assert room.objects[cells.object[lamp]] == "lamp"
    below, along = pick_cell(cells, origin, direction, CutPlane(np.array([0.0, 0.0, 1.0]), 2.0))
    assert room.objects[cells.object[below]] == "room"
    assert along == pytest.approx(5.0)


def test_sensors_win_unless_they_are_hidden(room):
    drawn = draw_scene(room)
    pose = pose_of_view(room.views[0], 1.5, 1.0)
    marks = sensor_marks(drawn)
    for number, place in enumerate(pose.project(marks, 900, 600)):
        if (place > 0).all() and (place < [900, 600]).all():
            found = pick(drawn.cells, marks, pose, tuple(place + [3.0, -2.0]), (900, 600), None)
            assert (found.kind, found.number) == ("sensor", number)
    outside = overview(np.zeros(3), np.array([3.0, 2.0, 2.5]), 1.5)
    below = Pose(np.array([1.5, 1.0, -3.0]), 0.0, 1.5, 2.0, 1.0)
    place = below.project(drawn.sensors.position[:1], 900, 600)[0]
    hidden = pick(drawn.cells, drawn.sensors.position[:1] - [0.0, 0.0, 2.0], outside, (450.0, 300.0), (900, 600), None)
    assert hidden is None or hidden.kind == "cell"
    assert pick(drawn.cells, np.zeros((0, 3)), below, tuple(place), (900, 600), None).kind == "cell"


def test_outlines_of_coarser_levels_are_among_the_finer_ones(subject):
    cells = subject.cells
    levels = [edge_flags(cells, level) for level in range(hierarchy_levels(cells) + 1)]
    for finer, coarser in pairwise(levels):
        assert (coarser <= finer).all()
    assert levels[0][~cells.is_triangle].all(), "each cell is an element here"
    whole = levels[-1]
    on_border = np.zeros_like(whole)
    for k in range(4):
        start, end = cells.place[:, k], cells.place[:, (k + 1) % 4]
        for axis in (0, 1):
            line = (start[:, axis] == end[:, axis]) & np.isin(start[:, axis], [0]) | (
                (start[:, axis] == end[:, axis]) & (start[:, axis] == cells.grid[:, axis])
            )
            on_border[:, k] |= line.astype(np.uint8)
    np.testing.assert_array_equal(whole[~cells.is_triangle], on_border[~cells.is_triangle])
    assert not levels[0][cells.is_triangle, 3].any()


def test_outlines_are_those_of_cells_that_face_the_eye(subject):
    cells = subject.cells
    low, high = cells.bounds
    outlines = FacingOutlines(cells, edge_flags(cells, 0))
    for eye in (0.5 * (low + high), high + (high - low)):
        faced = np.einsum("nk,nk->n", cells.normal, eye - cells.corners[:, 0]) > 0.0
        lines = outlines.seen_from(eye)
        assert 0 < faced.sum() < len(cells)
        edges = {
            (int(cells.patch[k]), int(cells.side[k]), *sorted((tuple(place[i]), tuple(place[(i + 1) % n]))))
            for k in np.flatnonzero(faced)
            for n in [3 if cells.is_triangle[k] else 4]
            for place in [cells.place[k].tolist()]
            for i in range(n)
        }
        assert len(lines.start) == len(edges), "each cell is an element here, and neighbours share an edge"
        assert (np.linalg.norm(lines.end - lines.start, axis=1) > 0.0).all()
        assert outlines.seen_from(eye + 1e-9) is None, "nothing is drawn anew"


def test_levels_count_halvings(subject):
    cells = subject.cells
    level = element_levels(cells)
    assert (2.0**level >= cells.grid.max(axis=1) / cells.width).all()
    assert (2.0 ** (level - 1) < cells.grid.max(axis=1) / cells.width).all()


def test_marks_stand_where_things_are(subject, room):
    places, normals = lamp_places(subject.cells)
    np.testing.assert_allclose(places, [[1.5, 1.0, 2.4]], atol=1e-9)
    np.testing.assert_allclose(normals, [[0.0, 0.0, -1.0]], atol=1e-9)
    lines, sensors = sensor_lines(subject.drawn), subject.drawn.sensors
    assert len(lines.start) == 3 * len(sensors)
    np.testing.assert_allclose(lines.start[: len(sensors)], sensors.position)
    marks = sensor_marks(subject.drawn)
    np.testing.assert_allclose(marks[:6], sensors.position[:6])
    np.testing.assert_allclose(marks[6:], lines.end[6:8], err_msg="two lines of sight from one eye")
    assert len(camera_lines(room.views, 4.0).start) == 10 * len(room.views)
