"""Faces back to back that differ: each is met from its own side, and the light is that of walls with a thickness."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation

from hradiosity.options import Options
from hradiosity.radiosity import make_solver, solve
from hradiosity.radiosity.referee import Referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.parted import part_back_to_back
from hradiosity.space.visibility import trace_closest

OPTIONS = Options(elements=600, gather_samples=1024, light_samples=64, rays_per_element=128)
TURN = Rotation.from_euler("xyz", [0.3, 1.1, -0.4]).as_matrix()


def two_rooms(thickness, inward=(True, True), *, first_comes_last=False, lower=0.0):
    """A bright and a dark room, with a wall of that thickness between them, each with a lamp; objects 0 and 1."""
    b = SceneBuilder()
    paints = b.material(0.8), b.material(0.3)
    x = 2.0 + thickness
    rooms = [((0, 0, 0), (2, 3, 2.5), 0.5), ((x, 0, 0), (x + 2, 3, 2.5 - lower), x + 1.0)]
    owner = []
    for k in (1, 0) if first_comes_last else (0, 1):
        low, high, lamp = rooms[k]
        b.box(low, high, paints[k], inward=inward[k])
        b.lamp(b.patch((lamp, 1, high[2] - 0.1), (0, 0.5, 0), (0.5, 0, 0), paints[k]), 1000.0)
        owner += 7 * [k]
    b.sensor(
        [(1, 1.5, 1), (2, 1.5, 1), (1.99, 1.5, 1), (x, 1.5, 1), (x + 1.5, 2, 0.5)],
        [(0, 0, 1), (-1, 0, 0), (0, 0, 1), (1, 0, 0), (0, 0, 1)],
    )
    scene = b.scene()
    patches = replace(scene.patches, object=np.array(owner, np.int32))
    return replace(scene, patches=patches, objects=("bright", "dark"))


def readings(scene, device, options=OPTIONS):
    return solve(scene, options, device).readings["s0"].irradiance[:, 0]


@pytest.mark.parametrize(
    "layout",
    [
        {},
        {"first_comes_last": True},
        {"inward": (False, False)},
        {"inward": (True, False)},
        {"lower": 0.5},
    ],
    ids=["inward", "other order", "outward", "one of each", "unlike heights"],
)
def test_two_rooms_on_one_plane_read_as_with_a_wall_between(device, layout):
    """Before, the readings were 13 to 17 % too low."""
    right = readings(two_rooms(0.1, **layout), device)
    np.testing.assert_allclose(readings(two_rooms(0.0, **layout), device), right, rtol=5e-3)


def test_the_same_turned_and_far_off(device):
    right = readings(two_rooms(0.1), device)
    np.testing.assert_allclose(readings(moved(two_rooms(0.0), TURN, (1e5, 50, 3)), device), right, rtol=0.01)


def test_unbiased_paths_see_it_like_that_too(device):
    means = []
    for thickness in (0.0, 0.1):
        referee = Referee(two_rooms(thickness), device, 4096)
        for _ in referee.states():
            pass
        means.append(referee.readings()["s0"].irradiance.mean())
    assert means[0] == pytest.approx(means[1], rel=0.01)


def sheet(front, back, **other):
    """Two equal faces back to back above a floor; the first looks up."""
    b = SceneBuilder()
    paints = b.material(0.8), b.material(0.3), b.material(0.5, two_sided=False)
    b.box((0, 0, 0), (4, 4, 4), paints[0], inward=True)
    b.patch((1, 1, 2), (1, 0, 0), (0, 1, 0), paints[front], **other)
    b.patch((1, 1, 2), (0, 1, 0), (1, 0, 0), paints[back], **other)
    b.lamp(5, 1.0)
    return b.scene()


@pytest.mark.parametrize(("front", "back"), [(0, 1), (1, 0), (2, 2)])
def test_rays_meet_the_front_of_each_face_of_a_sheet(device, front, back):
    scene = part_back_to_back(sheet(front, back))
    (note,) = scene.notes
    assert note.message.startswith("1 m² of faces that lie back to back") and "15 µm" in note.message
    rng = np.random.default_rng(1)
    place = np.column_stack([1.0 + rng.random((500, 2)), np.full(500, 2.0)])
    way = rng.standard_normal((500, 3))
    hits = trace_closest(build_bvh(device, scene.patches), place - 0.5 * way, way)
    inside = np.abs(hits.t - 0.5) < 1e-3
    assert inside.sum() > 400 and (hits.side[inside] == 0).all()
    np.testing.assert_array_equal(hits.patch[inside], np.where(way[inside, 2] < 0.0, 6, 7))


@pytest.mark.parametrize(
    "scene",
    [
        sheet(0, 0),
        sheet(0, 1, solid=0),
        replace(two_rooms(0.1)),
        SceneBuilder().scene(),
    ],
    ids=["alike", "of a solid", "apart", "empty"],
)
def test_what_is_right_already_stays(scene):
    assert part_back_to_back(scene) is scene


def test_a_shelf_at_a_wall_keeps_its_own_back(device):
    """An open box whose back lies in the wall and looks into it: inside one sees the box."""
    b = SceneBuilder()
    paints = b.material(0.8), b.material(0.3)
    b.box((0, 0, 0), (4, 4, 4), paints[0], inward=True)
    b.box((0, 1, 1), (0.5, 2, 2), paints[1])
    b.rows.pop(7)
    b.lamp(5, 1.0)
    scene = b.scene()
    patches = replace(scene.patches, object=np.array(6 * [0] + 5 * [1], np.int32))
    scene = part_back_to_back(replace(scene, patches=patches, objects=("room", "shelf")))
    hit = trace_closest(build_bvh(device, scene.patches), np.array([[2.0, 1.4, 1.3]]), np.array([[-1.0, 0, 0]]))
    assert hit.patch[0] == 6


@pytest.mark.parametrize(("gap", "moved_apart"), [(1e-6, False), (0.0, True), (-1e-6, True)])
def test_faces_that_look_at_each_other_over_a_narrow_gap_stay(gap, moved_apart):
    """The first at z = 0 looks up, the second at z = gap looks down."""
    b = SceneBuilder()
    b.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), b.material(0.8))
    b.patch((0, 0, gap), (0, 1, 0), (1, 0, 0), b.material(0.3))
    scene = b.scene()
    parted = part_back_to_back(scene)
    assert (parted is not scene) == moved_apart
    if moved_apart:
        assert parted.patches.origin[0, 2] > 0.0 > gap + parted.patches.origin[1, 2]


def test_sensors_go_with_the_wall_that_they_lie_on(device):
    scene = two_rooms(0.0)
    moved_by = make_solver(scene, OPTIONS, device).scene.sensors[0].position - scene.sensors[0].position
    hair = moved_by[3, 0]
    assert 0.0 < hair < 2e-5 * 4.0
    np.testing.assert_allclose(moved_by, hair * np.array([[0, 0, 0], [-1, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0]]))
