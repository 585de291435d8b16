"""Hard cases 12 to 17: slivers, faces without area, bent ones, reversed ones, and sizes far apart."""

from itertools import pairwise

import numpy as np
import pytest
from check_rooms import HEADER, LAMP, SOUND, box, findings, grave, of_kind, points, rectangle
from direct_light import FEW, factors_read
from polygon_shapes import PAIRS, SQUARE, corners, facing_square
from rooms import SceneBuilder, cube
from scene_writing import OPEN_ROOM, faults, load, warnings

from hradiosity import Options, form_factor, load_scene, solve
from hradiosity.cli import main
from hradiosity.errors import SceneError
from hradiosity.reference.pair_factors import area_pair
from hradiosity.reference.point_factors import point_to_patch, points_to_polygon

CATALOGUE = {entry["id"]: entry for entry in PAIRS}
UP = np.array([0.0, 0.0, 1.0])


def sliver(width, height):
    """A triangle that is one metre long and looks down."""
    return np.array([[0, 0, height], [0, width, height], [1, 0, height]])


@pytest.mark.parametrize("width", [1e-3, 1e-6], ids="12-{:g}".format)
def test_case_12_form_factors_of_slivers(device, width):
    exact = area_pair(sliver(width, 0.5), SQUARE, 24)
    for method in ("auto", "contour"):
        found = form_factor(SQUARE, sliver(width, 0.5), method=method, device=device)
        assert found.value == pytest.approx(exact, rel=1e-4)
        back = form_factor(sliver(width, 0.5), SQUARE, method=method, device=device)
        assert back.value == pytest.approx(exact / (0.5 * width), rel=1e-4)


@pytest.mark.parametrize("name", ["S01", "S03", "S05"], ids="12-{}".format)
def test_case_12_slivers_of_the_catalogue(device, name):
    a, b = (corners(CATALOGUE[name], key) for key in ("poly1", "poly2"))
    for method in ("auto", "contour"):
        found = form_factor(a, b, method=method, device=device)
        assert found.value == pytest.approx(float(CATALOGUE[name]["F12"]), rel=1e-4)


@pytest.mark.parametrize("height", [2.0, 1.0, 0.5, 0.1])
@pytest.mark.parametrize("width", [1e-3, 1e-6], ids="12-{:g}".format)
def test_case_12_light_of_slivers(device, width, height):
    """1e-4, or 1e-7 of the exitance where single precision leaves no more."""
    places = np.random.default_rng(12).uniform(-0.5, 1.5, (200, 3)) * [1, 1, 0]
    plate = sliver(width, height)
    edges = plate[1] - plate[0], plate[2] - plate[0]
    exact = [point_to_patch(place, UP, plate[0], *edges, triangle=True, order=60) for place in places]
    np.testing.assert_allclose(factors_read(device, [plate], places, UP), exact, rtol=1e-4, atol=1e-7)


def test_case_12_a_wall_of_slivers_loses_no_light(device):
    """A floor fanned into triangles down to a micrometre wide, each of another paint: M = 1 − ρ makes E = 1."""
    rng = np.random.default_rng(12)
    b = cube(0.5)
    b.rows.pop(4)
    cuts = np.concatenate([[0.0], np.cumsum(rng.permutation([1e-6, 1e-6, 1e-4, 1e-3, 1e-3, 0.2, 0.3]))])
    ring = [(x, 1.0, 0.0) for x in (*cuts, 1.0)] + [(1.0, 0.5 + 1e-6, 0.0), (1.0, 0.5, 0.0), (1.0, 0.0, 0.0)]
    ring = np.array(ring[::-1])
    floor = [b.patch((0, 0, 0), u, v, b.material(rng.uniform(0.1, 0.9)), triangle=True) for u, v in pairwise(ring)]
    scene_area = sum(0.5 * np.linalg.norm(np.cross(*b.rows[k][1:3])) for k in floor)
    assert scene_area == pytest.approx(1.0, rel=1e-12)
    for patch in range(len(b.rows)):
        b.lamp(patch, 1.0 - b.materials[b.rows[patch][4]].reflectance)
    b.sensor([(0.5, 0.5, 0.5), (0.2, 0.9, 0.0), (0.9, 0.5, 1e-3), (0.5, 0.5, 1.0)], [UP, UP, UP, -UP])
    for glow, tolerance in ((True, 1e-4), (False, 2e-2)):
        solution = solve(b.scene(), Options(elements=300, gather_samples=1024, light_samples=64, glow=glow), device)
        np.testing.assert_allclose(solution.readings["s0"].irradiance, 1.0, rtol=tolerance)


@pytest.mark.parametrize(("width", "warned"), [(0.0005, 1), (1e-6, 1), (0.002, 0)], ids=["12-2000", "12-1e6", "12-500"])
def test_case_12_slivers_are_named(device, tmp_path, width, warned):
    thin = f'[[polygon]]\nname = "thin"\nvertices = [[1,1,1], [2,1,1], [2,{1 + width!r},1]]\nmaterial = "paint"\n'
    found = of_kind(findings(device, tmp_path, SOUND + thin), "sliver")
    assert len(found) == warned
    assert all("1 face of 'thin' more than 1000 times as long as wide" in finding.message for finding in found)


BROKEN_OBJ = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0.5 0 0
v 0 0 0
f 1 2 3
f 6 3 4
f 1 5 2
f 2 2 3
f 1 3 3
f 3 1 2
"""


def test_case_13_faces_without_area_are_dropped_and_counted(tmp_path):
    shape = '[[polygon]]\nname = "p"\nvertices = [[0,0,1], [1,0,1], [1,1,1], [2,0,1], [1,1,1]]\nmaterial = "paint"\n'
    scene = load(tmp_path, OPEN_ROOM + shape + "faces = [[0,1,2], [0,1,3], [1,1,2], [2,4,3], [0,1,4,2]]\n")
    assert any("3 faces without area dropped" in warning for warning in warnings(scene))
    own = scene.patches.object == scene.objects.index("p")
    assert scene.patches.area[own].sum() == pytest.approx(0.5 + 0.5, rel=1e-12)
    assert "2 faces without area" in faults(tmp_path, OPEN_ROOM + shape + "faces = [[0,1,3], [2,2,2]]\n")[0]
    line = '[[rectangle]]\ncorner = [0,0,1]\nedge_u = [1,2,3]\nedge_v = [2,4,6]\nmaterial = "paint"\n'
    assert "1 face without area" in faults(tmp_path, OPEN_ROOM + line)[0]


def test_case_13_meshes_are_mended_and_say_so(tmp_path):
    (tmp_path / "plate.obj").write_text(BROKEN_OBJ)
    mesh = '[[mesh]]\nname = "plate"\nfile = "plate.obj"\nunit = "m"\nup = "z"\nmaterial = "paint"\n'
    scene = load(tmp_path, OPEN_ROOM + mesh)
    notes = [note.message for note in scene.notes]
    for wanted in ("1 vertices merged", "3 faces without area left out", "1 faces that were there twice left out"):
        assert any(wanted in note for note in notes), notes
    own = scene.patches.object == scene.objects.index("plate/plate")
    np.testing.assert_allclose(scene.patches.area[own], [1.0], rtol=1e-12)


def bent_quad(warp):
    """A kite 1 m × 2 m whose short diagonal is bent by `warp` of its size (1 m from the middle to the far corners)."""
    lift = 2.0 * warp
    return np.array([[-1, 0, 2], [0, -0.5, 2 + lift], [1, 0, 2], [0, 0.5, 2 + lift]])


@pytest.mark.parametrize(
    ("warp", "warned"), [(5e-4, False), (2e-3, True), (0.2, True)], ids=["14-hardly", "14-a-little", "14-much"]
)
@pytest.mark.parametrize("how", ["polygon", "mesh"])
def test_case_14_bent_quads(tmp_path, how, warp, warned):
    """Cut along the shorter diagonal into two triangles of known area, and told from 1e-3 of the size on."""
    quad = bent_quad(warp)
    if how == "polygon":
        text = f'[[polygon]]\nname = "kite"\nvertices = {quad.tolist()}\nmaterial = "paint"\n'
    else:
        rows = "".join("v {:.9f} {:.9f} {:.9f}\n".format(*corner) for corner in quad)
        (tmp_path / "kite.obj").write_text(rows + "f 1 2 3 4\n")
        text = '[[mesh]]\nname = "kite"\nfile = "kite.obj"\nunit = "m"\nup = "z"\nmaterial = "paint"\n'
    scene = load(tmp_path, OPEN_ROOM + text)
    told = [warning for warning in warnings(scene) if "not flat" in warning]
    assert len(told) == warned
    assert all(f"{100 * warp:.2g} % of its size off" in warning for warning in told)
    own = scene.patches.object == len(scene.objects) - 1
    assert scene.patches.is_triangle[own].all() or not warned
    half = 0.5 * 1.0 * np.hypot(1.0, 2.0 * warp)
    np.testing.assert_allclose(scene.patches.area[own].sum(), 2.0 * half, rtol=1e-6)
    if warned:
        np.testing.assert_allclose(scene.patches.area[own], half, rtol=1e-6)


def test_case_14_concave_quads_are_cut_inside(tmp_path):
    arrow = '[[polygon]]\nname = "arrow"\nvertices = [[0,0,2], [2,1,2], [0,2,2], [0.5,1,2]]\nmaterial = "paint"\n'
    scene = load(tmp_path, OPEN_ROOM + arrow)
    own = scene.patches.object == scene.objects.index("arrow")
    np.testing.assert_allclose(scene.patches.area[own], [0.75, 0.75], rtol=1e-12)


WALLS = {
    "west": ((0, 0, 0), (0, 3, 0), (0, 0, 2.5)),
    "east": ((4, 0, 0), (0, 0, 2.5), (0, 3, 0)),
    "south": ((0, 0, 0), (0, 0, 2.5), (4, 0, 0)),
    "north": ((0, 3, 0), (4, 0, 0), (0, 0, 2.5)),
    "floor": ((0, 0, 0), (4, 0, 0), (0, 3, 0)),
    "ceiling": ((0, 0, 2.5), (0, 3, 0), (4, 0, 0)),
}


def room_of_walls(turned, material):
    text = HEADER.replace('sides = "front"', 'sides = "front"\n')
    for name, (corner, u, v) in WALLS.items():
        text += rectangle(name, corner, *((v, u) if name in turned else (u, v)), material=material)
    return text + LAMP + points("desk", [(1.0, 1.0, 0.7), (2.0, 1.5, 1.0)])


TURNED = [(), ("west",), ("floor", "north"), tuple(WALLS)]
TURNED_IDS = ["15-none", "15-one", "15-two", "15-all"]


@pytest.mark.parametrize("turned", TURNED, ids=TURNED_IDS)
def test_case_15_reversed_faces_are_listed_where_they_matter(device, tmp_path, turned):
    """One-sided paints are black behind: each reversed face is named with its area. Two-sided ones need no word."""
    found = of_kind(findings(device, tmp_path, room_of_walls(turned, "shield")), "reversed-faces")
    assert sorted(finding.object for finding in found) == sorted(turned)
    for finding in found:
        area = np.linalg.norm(np.cross(*WALLS[finding.object][1:]))
        assert finding.severity == "fault" and f"1 face of '{finding.object}' ({area:g} m²)" in finding.message
        assert "turn the faces round" in finding.fix
    assert grave(findings(device, tmp_path, room_of_walls(turned, "paint"))) == []


def test_case_15_what_reversed_faces_do_to_the_light(device, tmp_path):
    """Two-sided: nothing. One-sided: the run is refused and names each of them, and a mended copy reads right."""

    def read(folder):
        readings = solve(load_scene(folder / "scene.toml"), Options(elements=1500, gather_samples=2048), device)
        return readings.readings["desk"].irradiance[:, 0], readings.readings["desk"].half_width[:, 0]

    def written(name, turned, material):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "scene.toml").write_text(room_of_walls(turned, material))
        return folder

    right, width = read(written("right", (), "paint"))
    turned, turned_width = read(written("turned", tuple(WALLS), "paint"))
    assert (np.abs(turned - right) < 2.5 * np.hypot(width, turned_width) + 2e-3 * right).all()
    wrong = written("wrong", ("floor", "north"), "shield")
    with pytest.raises(SceneError) as refused:
        read(wrong)
    assert [fault.entry for fault in refused.value.faults] == ["floor", "north"]
    assert all("light on their back" in fault.found for fault in refused.value.faults)
    assert main(["check", str(wrong), "--repair", str(tmp_path / "mended")]) == 0
    black_outside, mended = read(written("one-sided", (), "shield")), read(tmp_path / "mended")
    np.testing.assert_array_equal(mended, black_outside)


def test_case_15_a_small_reversed_face_is_no_more_than_a_warning(device, tmp_path):
    """Below a hundredth of the surfaces the run goes on; so it does where the front is in the light as well."""
    text = room_of_walls((), "paint") + box("post", (3.5, 0.5, 0.5), (0.4, 2.0, 1.0))
    for side, kind in ((0.4, "black-back"), (1.0, "reversed-faces")):
        note = rectangle("note", (3.5, 1, 0.5), (0, side, 0), (0, 0, side), material="shield")
        assert next(f.kind for f in findings(device, tmp_path, text + note) if f.object == "note") == kind
    screen = rectangle("screen", (2.7, 1, 0.2), (0, 1, 0), (0, 0, 1), material="shield")
    found = findings(device, tmp_path, text + screen)
    assert [(f.kind, f.object) for f in found if f.severity != "info"] == [("black-back", "screen")]


def test_case_15_a_room_that_is_a_solid_is_refused(device, tmp_path):
    room = HEADER + box("room", (0, 0, 0), (4, 3, 2.5)) + LAMP + points("desk", [(1, 1, 0.7)])
    found = [finding for finding in findings(device, tmp_path, room) if finding.severity == "fault"]
    assert [finding.kind for finding in found] == ["lamp-in-solid", "sensor-in-solid"]
    assert all("'room'" in finding.message for finding in found)


def hall_with_a_screw(scale):
    """A black hall of 100 m under a luminous ceiling; on its floor a screw's head of 24 facets, 0.1 mm wide."""
    b = SceneBuilder()
    hall = b.box((0, 0, 0), (100, 100, 50), b.material(0.0), inward=True)
    b.lamp(hall[5], 1.0)
    steel = b.material(0.4)
    ring = 0.5 * scale * np.array([(np.cos(t), np.sin(t), 0.0) for t in 2 * np.pi * np.arange(25) / 24])
    middle = np.array([30.0, 40.0, scale])
    head = [b.patch(middle, u, v, steel, triangle=True) for u, v in pairwise(ring)]
    b.sensor([middle, (30.0, 40.0 + scale, 0.0), (60.0, 10.0, 0.0)], UP)
    return b.scene(), head, middle


def test_case_16_a_screw_in_a_hall(device):
    """Light on the screw, beside it and far away by Lambert's formula; the screw is one element, and loses nothing."""
    scale = 1e-4
    scene, head, middle = hall_with_a_screw(scale)
    ceiling = 100.0 * facing_square(0.5)
    solution = solve(scene, FEW, device)
    readings = solution.readings["s0"]
    exact = points_to_polygon(readings.position, readings.normal, ceiling)
    np.testing.assert_allclose(readings.irradiance[:, 0], exact, rtol=1e-5)
    elements = solution.elements
    assert len(np.unique(elements.cell_row[elements.first_cell[head, 0]])) == 1
    assert solution.surfaces.irradiance[elements.cell_row[elements.first_cell[head[0], 0]], 0] == pytest.approx(
        exact[0], rel=1e-3
    )
    point = points_to_polygon(middle[None], UP[None], ceiling)[0]
    for method in ("auto", "contour"):
        found = form_factor(scale * SQUARE + middle, ceiling, method=method, device=device)
        assert found.value == pytest.approx(point, rel=1e-5)
        back = form_factor(ceiling, scale * SQUARE + middle, method=method, device=device)
        assert back.value == pytest.approx(point * scale**2 / 1e4, rel=1e-5)


CHIPS = {
    "17-1mm": ((500, 500, 1), 1e-3, ["size-range"]),
    "17-3mm": ((500, 500, 1), 3e-3, []),
    "17-1mm-corner": ((990, 990, 1), 1e-3, ["size-range", "unresolved-detail"]),
    "17-10mm-corner": ((990, 990, 1), 1e-2, ["unresolved-detail"]),
}


@pytest.mark.parametrize(("place", "edge", "expected"), CHIPS.values(), ids=CHIPS)
def test_case_17_millimetres_in_a_kilometre(device, tmp_path, place, edge, expected):
    chip = rectangle("chip", place, (edge, 0, 0), (0, edge, 0))
    room = HEADER + box("hall", (0, 0, 0), (1000, 1000, 10), "inside = true")
    room += rectangle("panel", (500, 500, 9), (0, 50, 0), (50, 0, 0), luminaire="lamp")
    found = findings(device, tmp_path, room + chip)
    assert grave(found) == expected
    assert all(finding.object == "chip" for finding in found if finding.severity == "warning")
    for finding in of_kind(found, "size-range"):
        assert "a face 1 mm wide" in finding.message and "a ratio above 1e+06" in finding.message
    for finding in of_kind(found, "unresolved-detail"):
        assert "coordinates there have steps of" in finding.message and "their shape is off by up to" in finding.effect


@pytest.mark.parametrize("place", [(500.0, 500.0), (0.0, 0.0), (990.25, 9.75)], ids="17-{}".format)
def test_case_17_the_light_of_a_millimetre_in_a_kilometre(device, place):
    """A chip of 1 mm shines down from 1 m on a floor of 1 km; a step of coordinates at its far end is 0.06 mm."""
    b = SceneBuilder()
    black = b.material(0.0)
    b.patch((0, 0, 0), (1000, 0, 0), (0, 1000, 0), black)
    chip = 1e-3 * facing_square(0.0) + [*place, 1.0]
    b.lamp(b.patch(chip[0], chip[1] - chip[0], chip[3] - chip[0], black), 1.0)
    points_below = np.array([*place, 0.0]) + [(5e-4, 5e-4, 0.0), (0.5, 0.2, 0.0)]
    b.sensor(points_below, UP)
    found = solve(b.scene(), FEW, device).readings["s0"].irradiance[:, 0]
    np.testing.assert_allclose(found, points_to_polygon(points_below, np.tile(UP, (2, 1)), chip), rtol=3e-4)
