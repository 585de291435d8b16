"""Rectangles, polygons, boxes and meshes of a scene file become the patches that were meant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_writing import FLOOR, HEADER, LAMP, OPEN_ROOM, PAINT, PANEL, faults, load, warnings

from hradiosity.io.scene.frame import Frame, rotation
from hradiosity.model.geometry import NONE
from hradiosity.model.solids import find_solids

OTHER = "[materials.other]\nreflectance = 0.2\n"
CUBE = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
o crate
usemtl pine wood
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
usemtl steel
f 3 4 8 7
f 4 1 5 8
"""


def volume(patches):
    """Signed volume that patches enclose, by the divergence theorem."""
    return float((np.einsum("ij,ij->i", patches.centroid, patches.normal) * patches.area).sum() / 3)


def test_units_and_axes():
    frame = Frame("cm", "y")
    np.testing.assert_allclose(frame.points([[100.0, 200.0, 300.0]]), [[1.0, -3.0, 2.0]])
    x, y, z = frame.directions(np.eye(3))
    np.testing.assert_array_equal(np.cross(x, y), z)
    assert Frame("ft", "z").length(1.0) == 0.3048


@given(
    axis=st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.1),
    angle=st.floats(-360, 360),
)
def test_rotation_is_rigid_keeps_its_axis_and_turns_by_its_angle(axis, angle):
    turn = rotation(axis, angle)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(turn @ axis, axis, atol=1e-14)
    assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(np.radians(angle)), abs=1e-14)
    across = np.cross(axis, [0.3, -0.5, 0.8])
    assert np.dot(axis, np.cross(across, turn @ across)) * np.sin(np.radians(angle)) >= -1e-12


def test_quarter_turn_keeps_faces_parallel_to_the_axes():
    np.testing.assert_array_equal(rotation((0, 0, 1), 90), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])


def test_rectangle_is_one_patch(tmp_path):
    patches = load(tmp_path, OPEN_ROOM).patches
    assert not patches.is_triangle.any()
    np.testing.assert_array_equal(patches.normal, [[0, 0, 1], [0, 0, -1]])
    np.testing.assert_array_equal(patches.area, [8, 1])
    assert (patches.solid == NONE).all()


@settings(max_examples=20, deadline=None)
@given(
    place=st.sampled_from(["corner", "centre"]),
    angle=st.floats(-180, 180),
    axis=st.sampled_from(["", "rotation_axis = [1.0, 2.0, -0.5]\n"]),
    up=st.sampled_from(["z", "y"]),
    inside=st.booleans(),
)
def test_box_is_closed_and_has_its_volume(tmp_path_factory, place, angle, axis, up, inside):
    box = (
        f"[[box]]\n{place} = [0.3, -0.2, 1.1]\nsize = [1.0, 2.0, 3.0]\nrotation_deg = {angle:f}\n{axis}"
        f'inside = {str(inside).lower()}\nmaterial = "paint"\nluminaire = "lamp"\n'
    )
    text = HEADER.replace('"m"', f'"m"\nup = "{up}"') + PAINT + LAMP + box
    patches = load(tmp_path_factory.mktemp("box"), text).patches
    assert volume(patches) == pytest.approx(-6.0 if inside else 6.0, rel=1e-12)
    shells = find_solids(patches.corners(), patches.is_triangle, patches.object)
    assert ((shells.inward if inside else shells.solid) == 0).all()
    assert (patches.solid == (NONE if inside else 0)).all()


@pytest.mark.parametrize(
    ("up", "normals"),
    [
        ("z", {"left": [-1, 0, 0], "right": [1, 0, 0], "front": [0, -1, 0], "back": [0, 1, 0], "bottom": [0, 0, -1]}),
        ("y", {"left": [-1, 0, 0], "right": [1, 0, 0], "front": [0, 0, 1], "back": [0, 0, -1], "bottom": [0, -1, 0]}),
    ],
)
def test_names_of_box_faces(tmp_path, up, normals):
    text = HEADER.replace('"m"', f'"m"\nup = "{up}"') + PAINT + LAMP + PANEL
    text += '[[box]]\nname = "b"\ncorner = [0, 0, 0]\nsize = [1, 1, 1]\nmaterial = "paint"\n'
    for face in normals:
        text += f'[[sensor]]\nname = "{face}"\nkind = "surface"\nobject = "b"\nface = "{face}"\ncounts = [1, 1]\n'
    scene = load(tmp_path, text)
    for sensor in scene.sensors:
        np.testing.assert_array_equal(sensor.normal, [Frame("m", up).directions(normals[sensor.name])])


def test_box_turns_about_the_given_point(tmp_path):
    box = '[[box]]\n{} = [1, 1, 0]\nsize = [2, 1, 1]\nrotation_deg = 90\nmaterial = "paint"\nluminaire = "lamp"\n'
    low, high = load(tmp_path, HEADER + PAINT + LAMP + box.format("corner")).patches.bounds()
    np.testing.assert_allclose([low, high], [[0, 1, 0], [1, 3, 1]], atol=1e-15)
    low, high = load(tmp_path, HEADER + PAINT + LAMP + box.format("centre")).patches.bounds()
    np.testing.assert_allclose([low, high], [[0.5, 0, -0.5], [1.5, 2, 0.5]], atol=1e-15)


def test_box_with_other_faces(tmp_path):
    box = (
        '[[box]]\ncorner = [0, 0, 0]\nsize = [1, 2, 3]\nmaterial = "paint"\n'
        'faces = { sides = "other", left = "paint" }\nluminaires = { top = "lamp" }\nomit = ["bottom"]\n'
    )
    scene = load(tmp_path, HEADER + PAINT + OTHER + LAMP + box)
    names = [scene.materials[i].name for i in scene.patches.material]
    upright = np.abs(scene.patches.normal[:, 2]) < 0.5
    assert names == ["paint", "other", "other", "other", "paint"]
    assert (scene.patches.solid == NONE).all()
    assert len(scene.patches) == 5
    assert upright.sum() == 4
    np.testing.assert_array_equal(scene.patches.normal[scene.emitters.patch], [[0, 0, 1]])
    np.testing.assert_array_equal(scene.emitters.position, [[0.5, 1.0, 3.0]])


def test_box_face_without_material(tmp_path):
    faces_but_one = 'faces = { sides = "paint", top = "paint" }\nluminaire = "lamp"\n'
    box = f"[[box]]\ncorner = [0, 0, 0]\nsize = [1, 2, 3]\n{faces_but_one}"
    assert "no material for bottom" in faults(tmp_path, HEADER + PAINT + LAMP + box)[0]
    assert faults(tmp_path, HEADER + PAINT + LAMP + box + 'omit = ["bottom"]\n') == []


def test_concave_polygon_keeps_area_and_is_one_surface(tmp_path):
    shape = '[[polygon]]\nvertices = [[0,0,0], [3,0,0], [3,1,0], [1,1,0], [1,2,0], [0,2,0]]\nmaterial = "paint"\n'
    patches = load(tmp_path, HEADER + PAINT + LAMP + PANEL + shape).patches
    own = patches.object == 1
    assert patches.area[own].sum() == pytest.approx(4.0, rel=1e-14)
    np.testing.assert_array_equal(patches.normal[own], np.tile([0, 0, 1], (own.sum(), 1)))
    assert len(np.unique(patches.surface[own])) == 1
    assert len(np.unique(patches.surface)) == 2


def test_bent_quad_is_reported(tmp_path):
    shape = '[[polygon]]\nvertices = [[0,0,0], [1,0,0], [1,1,{}], [0,1,0]]\nmaterial = "paint"\n'
    bent = load(tmp_path, OPEN_ROOM + shape.format("0.1"))
    assert "not flat" in warnings(bent)[0]
    assert len(bent.patches) == 4
    assert warnings(load(tmp_path, OPEN_ROOM + shape.format("0.0001"))) == []


def test_crossing_edges(tmp_path):
    shape = '[[polygon]]\nvertices = [[0,0,0], [2,2,0], [2,0,0], [0,1,0]]\nmaterial = "paint"\n'
    assert "cross" in faults(tmp_path, OPEN_ROOM + shape)[0]


def test_polygons_with_common_vertices(tmp_path):
    pyramid = '[[polygon]]\nvertices = [[0,0,0], [1,0,0], [1,1,0], [0,1,0], [0.5,0.5,1]]\nmaterial = "paint"\n'
    closed = "faces = [[3,2,1,0], [0,1,4], [1,2,4], [2,3,4], [3,0,4]]\n"
    patches = load(tmp_path, OPEN_ROOM + pyramid + closed).patches
    assert list(patches.solid) == [NONE, NONE, 0, 0, 0, 0, 0]
    assert len(np.unique(patches.surface)) == 7
    standing = closed.replace("[3,2,1,0], ", "")
    assert (load(tmp_path, OPEN_ROOM + pyramid + standing).patches.solid == NONE).all()
    assert (load(tmp_path, OPEN_ROOM + pyramid + standing + "solid = true\n").patches.solid[2:] == 0).all()
    assert (load(tmp_path, OPEN_ROOM + pyramid + closed + "solid = false\n").patches.solid == NONE).all()
    assert "names vertex 5" in faults(tmp_path, OPEN_ROOM + pyramid + "faces = [[0, 1, 5]]\n")[0]


def test_solids_of_different_objects_differ(tmp_path):
    box = '[[box]]\ncorner = [{}, 0, 0]\nsize = [1, 1, 1]\nmaterial = "paint"\n'
    scene = load(tmp_path, OPEN_ROOM + box.format(0) + box.format(2))
    assert sorted(set(scene.patches.solid.tolist())) == [NONE, 0, 1]
    assert scene.objects == ("floor", "panel", "box-1", "box-2")


def test_some_faces_without_area_are_dropped_with_a_warning(tmp_path):
    shape = '[[polygon]]\nvertices = [[0,0,0], [1,0,0], [1,1,0], [2,0,0]]\nmaterial = "paint"\n'
    shape += "faces = [[0,1,2], [0,1,3], [1,1,2]]\n"
    scene = load(tmp_path, OPEN_ROOM + shape)
    assert "2 faces without area dropped" in warnings(scene)[0]
    assert len(scene.patches) == 3


@pytest.fixture
def crate(tmp_path):
    (tmp_path / "crate.obj").write_text(CUBE)
    return HEADER + PAINT + OTHER + LAMP + PANEL + '[[mesh]]\nfile = "crate.obj"\nunit = "cm"\nup = "y"\n'


def test_mesh_is_placed_and_mapped(tmp_path, crate):
    text = crate + (
        'materials = { "pine wood" = "paint", steel = "other" }\nposition = [1, 2, 3]\nrotation_deg = 90\nscale = 100\n'
        'luminaires = { steel = "lamp" }\n'
    )
    scene = load(tmp_path, text)
    own = scene.patches.object == scene.objects.index("crate/crate")
    patches = scene.patches
    assert own.sum() == 6
    assert not patches.is_triangle.any()
    assert (patches.solid[own] == 0).all()
    low, high = patches.corners()[own].reshape(-1, 3).min(axis=0), patches.corners()[own].reshape(-1, 3).max(axis=0)
    # y up: the unit cube is x 0..1, y −1..0, z 0..1 here; a quarter turn takes (x, y) to (−y, x).
    np.testing.assert_allclose([low, high], [[1, 2, 3], [2, 3, 4]], atol=1e-6)
    assert sorted(scene.materials[i].name for i in patches.material[own]) == ["other"] * 2 + ["paint"] * 4
    emitting = scene.emitters.patch[1:]
    assert {scene.materials[i].name for i in patches.material[emitting]} == {"other"}


def test_mesh_in_a_file_of_another_unit_and_axis(tmp_path, crate):
    text = crate.replace('unit = "m"', 'unit = "mm"\nup = "y"', 1)
    text += 'material = "paint"\nposition = [1000, 2000, 3000]\nscale = 100\n'
    scene = load(tmp_path, text)
    own = scene.patches.object == scene.objects.index("crate/crate")
    corners = scene.patches.corners()[own].reshape(-1, 3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [[1, -4, 2], [2, -3, 3]], atol=1e-6)


def test_entry_for_an_object_wins_over_its_material(tmp_path, crate):
    scene = load(tmp_path, crate + 'materials = { crate = "other", "pine wood" = "paint", steel = "paint" }\n')
    own = scene.patches.object == scene.objects.index("crate/crate")
    assert {scene.materials[i].name for i in scene.patches.material[own]} == {"other"}


@pytest.mark.parametrize(
    ("entries", "expected"),
    [
        ('materials = { steel = "paint" }', "'pine wood' without a material of the scene"),
        ('materials = { stele = "paint" }\nmaterial = "paint"', "did you mean 'steel'?"),
        ('materials = { steel = "pant" }\nmaterial = "paint"', "did you mean 'paint'?"),
        ('luminaires = { steel = "lamb" }\nmaterial = "paint"', "did you mean 'lamp'?"),
        ('luminaires = { brass = "lamp" }\nmaterial = "paint"', "no object or material 'brass'"),
        ('material = "pant"', "did you mean 'paint'?"),
    ],
)
def test_mesh_names(tmp_path, crate, entries, expected):
    found = faults(tmp_path, crate + entries + "\n")
    assert len(found) == 1
    assert expected in found[0]


def test_missing_mesh_and_missing_unit(tmp_path, crate):
    assert "did you mean 'crate.obj'?" in faults(tmp_path, crate.replace("crate.obj", "crte.obj"))[0]
    assert "mesh[0].unit: is missing" in faults(tmp_path, crate.replace('unit = "cm"\n', ""))[0]
    assert "mesh[0].up: is missing" in faults(tmp_path, crate.replace('up = "y"\n', ""))[0]


def test_damaged_mesh_says_who_asked_for_it(tmp_path, crate):
    (tmp_path / "crate.obj").write_text("v 0 0 0\n")
    found = faults(tmp_path, crate + 'material = "paint"\n')
    assert len(found) == 1
    assert "crate.obj" in found[0]
    assert "mesh[0].file" in found[0]


def test_texture_is_refused_unless_one_paint_is_named_for_it(tmp_path, crate):
    (tmp_path / "crate.mtl").write_text("newmtl pine wood\nmap_Kd pine.png\nnewmtl steel\nKd 1 1 1\n")
    (tmp_path / "crate.obj").write_text("mtllib crate.mtl\n" + CUBE)
    found = faults(tmp_path, crate + 'material = "paint"\n')
    assert len(found) == 1
    assert "'pine wood' in crate.obj has a texture, which is not simulated" in found[0]
    scene = load(tmp_path, crate + 'materials = { "pine wood" = "other" }\nmaterial = "paint"\n')
    assert "has a texture" in warnings(scene)[0]


def test_floor_comes_first(tmp_path):
    assert load(tmp_path, HEADER + PAINT + LAMP + PANEL + FLOOR).objects == ("panel", "floor")
