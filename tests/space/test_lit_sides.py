"""Which sides light can reach, and which spaces they form."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity.model.scene import Sky
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.convexity import is_convex
from hradiosity.space.lit_sides import find_lit_sides


def lit_of(device, builder, **options):
    scene = builder.scene()
    return find_lit_sides(scene, build_bvh(device, scene.patches), **options)


def test_closed_room_is_lit_inside_only(device):
    room = cube()
    room.lamp(5, 1.0)
    found = lit_of(device, room)
    assert found.lit[:, 0].all() and not found.lit[:, 1].any()
    assert found.open.tolist() == [False]
    # 16 rays a face: 4V/S = 2/3 within a few parts in a hundred.
    assert found.free_path == pytest.approx(2 / 3, rel=0.1)


@pytest.mark.parametrize("solid", [True, False])
def test_box_on_the_floor_is_dark_inside(device, solid):
    room = cube()
    room.lamp(5, 1.0)
    box = room.box((0.3, 0.3, 0.001 * (not solid)), (0.6, 0.6, 0.3), room.material(0.5), solid=solid)
    found = lit_of(device, room)
    assert not found.lit[box, 1].any()
    assert found.lit[box[1:4] + box[5:], 0].all() and found.lit[:6, 0].all()


def test_two_sealed_rooms_of_which_one_has_a_lamp(device):
    rooms = SceneBuilder()
    grey = rooms.material(0.5)
    first = rooms.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    second = rooms.box((1.2, 0, 0), (2.2, 1, 1), grey, inward=True)
    rooms.lamp(first[5], 1.0)
    found = lit_of(device, rooms)
    assert found.lit[first, 0].all() and not found.lit[second].any() and not found.lit[first, 1].any()
    assert (found.space[second] == -1).all()
    rooms.lamp(second[5], 1.0)
    found = lit_of(device, rooms)
    assert found.lit[second, 0].all()
    assert len(np.unique(found.space[first, 0])) == 1 and len(found.open) == 2
    assert found.space[first[0], 0] != found.space[second[0], 0]


def test_lamp_on_the_outside(device):
    """The room's outer sides are lit, its inside is dark, and the space is open."""
    room = SceneBuilder()
    faces = room.box((0, 0, 0), (1, 1, 1), room.material(0.5), inward=True)
    lamp = room.patch((0, 0, 3), (0, 1, 0), (1, 0, 0), room.material(0.5))
    room.lamp(lamp, 1.0)
    found = lit_of(device, room)
    assert not found.lit[faces, 0].any() and found.lit[faces[5], 1]
    assert found.open[found.space[faces[5], 1]]


def test_point_source_lights_what_it_sees(device):
    room = cube()
    room.point((0.5, 0.5, 0.5), 1.0)
    assert lit_of(device, room).lit[:, 0].all()
    room = cube()
    room.point((2.0, 0.5, 0.5), 1.0)
    found = lit_of(device, room)
    assert found.lit[1, 1] and not found.lit[:, 0].any()


@pytest.mark.parametrize("both", [False, True])
def test_two_sided_lamp_lights_both_spaces(device, both):
    """Two boxes, one above the other, with a lamp for the floor between them."""
    rooms = SceneBuilder()
    grey = rooms.material(0.5)
    upper = rooms.box((0, 0, 0.5), (1, 1, 1), grey, inward=True)
    del rooms.rows[4]
    rooms.box((0, 0, 0), (1, 1, 0.5), grey, inward=True)
    del rooms.rows[-1]
    middle = rooms.patch((0, 0, 0.5), (0, 1, 0), (1, 0, 0), grey)
    rooms.lamp(middle, 1.0, two_sided=both)
    found = lit_of(device, rooms)
    assert found.lit[5:, 0].all()
    assert (found.lit[upper[:5], 0] == both).all() and found.lit[middle, 1] == both


def test_sky_lights_open_sides_only(device):
    room = cube()
    ground = room.patch((-20, -20, -0.5), (40, 0, 0), (0, 40, 0), room.material(0.2))
    room.sky = Sky(np.array([1.0]))
    found = lit_of(device, room)
    assert found.lit[ground, 0] and found.lit[:6, 1].all() and not found.lit[:6, 0].any()
    assert not found.lit[ground, 1]


def test_known_links_join_spaces(device):
    rooms = SceneBuilder()
    grey = rooms.material(0.5)
    first = rooms.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    second = rooms.box((1.2, 0, 0), (2.2, 1, 1), grey, inward=True)
    rooms.lamp(first[5], 1.0)
    found = lit_of(device, rooms, known_links=np.array([[2 * first[0], 2 * second[0]]]))
    assert found.lit[second, 0].all() and len(found.open) == 1


@pytest.mark.filterwarnings("error")
def test_nothing_there(device):
    nothing = SceneBuilder()
    assert lit_of(device, nothing).lit.shape == (0, 2)
    assert not lit_of(device, cube()).lit.any()


@pytest.mark.parametrize(
    ("points", "convex"),
    [([], True), ([[0.5] * 3], True), ([[0.5, 0.5, 0.0]], True), ([[0.5, 0.5, -0.1]], False), ([[2, 0, 0]], False)],
)
def test_convexity_counts_points_outside(points, convex):
    assert is_convex(cube().scene().patches, np.array(points, float).reshape(-1, 3)) == convex


def test_convexity_of_other_shapes():
    nowhere = np.zeros((0, 3))
    assert is_convex(SceneBuilder().scene().patches, nowhere)
    outward = SceneBuilder()
    outward.box((0, 0, 0), (1, 1, 1), outward.material(0.5))
    assert not is_convex(outward.scene().patches, nowhere)
    shelf = cube()
    shelf.patch((0, 0.2, 0.5), (0.3, 0, 0), (0, 0.3, 0), 0)
    assert not is_convex(shelf.scene().patches, nowhere)
    panel = cube()
    panel.patch((0.4, 0.4, 1.0), (0, 0.2, 0), (0.2, 0, 0), 0)
    assert is_convex(panel.scene().patches, nowhere)


def test_surface_far_from_a_point_source(device):
    """A plate that fills 1e-10 of the source's sky; and not its back, nor what stands behind it."""
    b = SceneBuilder()
    plate = b.patch((0, 0, 0), (4, 0, 0), (0, 4, 0), b.material(0.5))
    hidden = b.patch((1, 1, -1), (2, 0, 0), (0, 2, 0), b.material(0.5))
    b.point((2, -5e4, 8e4), 1.0)
    found = lit_of(device, b)
    assert found.lit[plate].tolist() == [True, False]
    b.point((2, -5e4, -8e4), 1.0)
    assert lit_of(device, b).lit[[plate, hidden], 1].all()
