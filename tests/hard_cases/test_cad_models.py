"""Models as they come out of CAD programs: what a check says about them, what a repair makes of them, and the light."""

import json
from dataclasses import replace

import numpy as np
import pytest
from cad import (
    EVEN,
    FAST,
    block,
    checked,
    grave,
    grid,
    header,
    joined,
    light,
    mesh,
    of_kind,
    points,
    write_obj,
)

from hradiosity.cli import main
from hradiosity.io.meshes import read_mesh
from hradiosity.model.geometry import NONE
from hradiosity.model.meshing import merge_triangles

ROOM = block((0, 0, 0), (4, 3, 2.5), inward=True)
EYES = points([(2, 1.5, 1.2), (0.6, 0.7, 0.4), (3.7, 2.6, 2.1)])
FINE = replace(FAST, replicates=3, elements=1500, gather_samples=1024)
ALL = {"room": "wall", "thing": "dark"}


@pytest.fixture
def write(tmp_path):
    """Writes a scene of meshes, all of which make the even field."""
    folder = tmp_path / "scene"
    folder.mkdir()

    def make(parts, more="", unit="m", sides="front", lamps=None, factor=1.0, shift=0.0):
        write_obj(folder / "cad.obj", parts, factor, shift)
        names = {name: ALL.get(name, "dark") for name in parts}
        text = header(sides=sides) + mesh("cad.obj", names, names if lamps is None else lamps, unit) + EYES + more
        (folder / "scene.toml").write_text(text)
        return folder

    return make


def repaired(folder, capsys):
    """The mended copy's folder, and what was said about it."""
    original = {path: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    main(["check", str(folder), "--json", "--repair", str(folder.parent / "mended")])
    assert {path: path.read_bytes() for path in folder.iterdir()} == original
    return folder.parent / "mended", json.loads(capsys.readouterr().out)["repair"]


def assert_even(values, tolerance=2e-3):
    np.testing.assert_allclose(values, EVEN, rtol=tolerance)


@pytest.mark.parametrize("shift", [0.0, 1e5])
def test_millimetres_at_large_coordinates(device, write, shift):
    """The room of 4 m lies 100 m from the origin of a file in mm: nothing is welded, lost or found to be wrong."""
    parts = {"room": ROOM, "thing": block((1, 1, 0.1), (1.8, 1.6, 0.9))}
    offset = f"position = {[-1e-3 * shift] * 3}\n"
    folder = write(parts, unit="mm", factor=1e3, shift=shift)
    text = (folder / "scene.toml").read_text().replace('up = "z"\n', f'up = "z"\n{offset}')
    (folder / "scene.toml").write_text(text)
    scene, findings = checked(device, folder)
    assert grave(findings) == [] and not of_kind(findings, "open-body")
    assert len(scene.patches) == 12 and (scene.patches.solid[6:] != NONE).all()
    np.testing.assert_allclose(scene.patches.bounds(), [[0, 0, 0], [4, 3, 2.5]], atol=1e-9)
    assert_even(light(device, folder))


@pytest.mark.parametrize("n", [1, 32])
def test_triangles_of_quads_are_merged_back(device, tmp_path, n):
    """n² squares, cut along diagonals by the exporter, are n² patches of one surface again."""
    write_obj(tmp_path / "sheet.obj", {"sheet": grid((1e3, 2e3, 0), (4e3, 1e3, 0), (0, 0, 2e3), n)})
    (part,) = read_mesh(tmp_path / "sheet.obj", "mm", "z").parts
    pieces = merge_triangles(part.vertices, part.triangles)
    assert len(pieces.origin) == n * n and not pieces.is_triangle.any()
    assert len(np.unique(pieces.surface)) == 1


def test_thousands_of_duplicate_faces(device, write, capsys):
    """A block of 1536 squares is in the file twice: named with number and area, left out once, and the light right."""
    sides = [
        grid((1, 1, 0.5), (0, 1, 0), (1, 0, 0), 16),
        grid((1, 1, 1.2), (1, 0, 0), (0, 1, 0), 16),
        grid((1, 1, 0.5), (1, 0, 0), (0, 0, 0.7), 16),
        grid((1, 2, 0.5), (0, 0, 0.7), (1, 0, 0), 16),
        grid((1, 1, 0.5), (0, 0, 0.7), (0, 1, 0), 16),
        grid((2, 1, 0.5), (0, 1, 0), (0, 0, 0.7), 16),
    ]
    thing = joined(*sides)
    folder = write({"room": ROOM, "thing": thing, "thing again": thing})
    _, findings = checked(device, folder)
    (finding,) = of_kind(findings, "duplicate-faces")
    assert "'cad/thing' and 'cad/thing again' are the same faces twice: 4.8 m² in 1536 pairs" in finding.message
    assert finding.effect and finding.fix == "delete one of the two"
    assert len(finding.patches) == 1536
    mended, said = repaired(folder, capsys)
    assert "left out 1536 faces of 'cad/thing again'" in said["mended"][0]
    scene, findings = checked(device, mended)
    assert grave(findings) == [] and len(scene.patches) == 1542
    assert_even(light(device, mended))


def test_faces_twice_in_one_object_are_left_out_while_reading(device, write):
    thing = block((1, 1, 0.5), (2, 2, 1.2))
    folder = write({"room": ROOM, "thing": joined(*[thing] * 50)})
    scene, findings = checked(device, folder)
    assert any("588 faces that were there twice left out" in note.message for note in scene.notes)
    assert grave(findings) == [] and len(scene.patches) == 12
    assert_even(light(device, folder))


def test_inside_out_furniture(device, write, capsys):
    """A one-sided paint on a cupboard inside out is black; the copy has the light of a cupboard that is a [[box]]."""
    low, high = (1, 0.5, 0.3), (3, 2.5, 2.2)
    folder = write({"room": ROOM, "thing": block(low, high, inward=True)}, lamps={"room": "wall"})
    text = (folder / "scene.toml").read_text()
    text = text.replace("dark = { reflectance = 0.3 }", 'dark = { reflectance = 0.8, sides = "front" }')
    text = text.replace(EYES, points([(0.5, 1.5, 1), (3.5, 1.5, 1)], (0, 1, 0)))
    (folder / "scene.toml").write_text(text)
    _, findings = checked(device, folder)
    (turned,) = of_kind(findings, "inside-out")
    assert (turned.object, len(turned.patches)) == ("cad/thing", 6)
    assert "6 faces point inwards" in turned.message and "black" in turned.effect
    assert turned.fix == "turn its faces round" and turned.size == pytest.approx(np.linalg.norm([2, 2, 1.9]))
    np.testing.assert_allclose(turned.place, [2, 1.5, 1.25])
    mended, said = repaired(folder, capsys)
    assert said["mended"] == ["inside-out: turned the faces of 'cad/thing' round"]
    scene, findings = checked(device, mended)
    assert grave(findings) == [] and (scene.patches.solid[6:] != NONE).all()
    box = f'[[box]]\nname = "b"\ncorner = {list(low)}\nsize = [2.0, 2.0, 1.9]\nmaterial = "dark"\n'
    write_obj(folder / "cad.obj", {"room": ROOM})
    (folder / "scene.toml").write_text(text.replace(', "thing" = "dark"', "") + box)
    right = light(device, folder, FINE)
    np.testing.assert_allclose(light(device, mended, FINE), right, rtol=5e-3)
    assert (right < 0.95 * EVEN).all()


def test_a_wall_without_thickness_between_two_rooms(device, write, capsys):
    """Each room has its own paint on the common wall and an even field of its own, in the copy too."""
    left = joined(block((0, 0, 0), (2, 3, 2.5), inward=True))
    right = joined(block((2, 0, 0), (4, 3, 2.5), inward=True))
    folder = write({"room": left, "thing": right})
    text = (folder / "scene.toml").read_text().replace("constant = 0.7", "constant = 1.4")
    (folder / "scene.toml").write_text(text.replace(EYES, points([(1, 1.5, 1.2), (3, 1.5, 1.2), (1.99, 1, 1)])))
    _, findings = checked(device, folder)
    (finding,) = of_kind(findings, "coincident-back-to-back")
    assert "7.5 m²" in finding.message and "to the side of its own object" in finding.effect
    assert finding.severity == "info" and finding.fix == "if that is the wrong side: give the wall a thickness"
    np.testing.assert_allclose(finding.place, [2, 1.5, 1.25], atol=1e-9)
    wanted = np.array([EVEN, 2 * EVEN, EVEN])
    np.testing.assert_allclose(light(device, folder), wanted, rtol=2e-3)
    mended, said = repaired(folder, capsys)
    assert any("by 1 mm off" in line for line in said["mended"]), said
    _, findings = checked(device, mended)
    assert grave(findings) == []
    np.testing.assert_allclose(light(device, mended), wanted, rtol=2e-3)


def test_a_luminaire_flush_with_the_ceiling(device, write, capsys):
    """In a black room the reading below is the lamp's exitance times a known form factor, once it hangs 1 mm lower."""
    panel = grid((1.5, 1, 2.5), (0, 1, 0), (1, 0, 0), 1)
    folder = write({"room": ROOM, "panel": panel}, lamps={"panel": "lamp"})
    text = (folder / "scene.toml").read_text().replace('"room" = "wall"', '"room" = "black"')
    (folder / "scene.toml").write_text(text.replace(EYES, points([(1.5, 1, 0.5), (2, 1.5, 0.5)])))
    _, findings = checked(device, folder)
    (finding,) = of_kind(findings, "lamp-in-surface")
    assert "1 m²" in finding.message and "'cad/room' and 'cad/panel'" in finding.message
    assert finding.effect.startswith("the lamp may be hidden") and finding.fix.startswith("move the lamp 1 mm off")
    np.testing.assert_allclose(finding.place, [2, 1.5, 2.5], atol=1e-9)
    mended, said = repaired(folder, capsys)
    assert said["mended"] == ["lamp-in-surface: moved 'cad/panel' by 1 mm off 'cad/room', at (2, 1.5, 2.5) m"]
    _, findings = checked(device, mended)
    assert grave(findings) == []
    below_corner, below_middle = form_factor(1, 1, 1.999), 4 * form_factor(0.5, 0.5, 1.999)
    np.testing.assert_allclose(light(device, mended), EVEN * np.array([below_corner, below_middle]), rtol=2e-3)


def form_factor(a, b, c):
    """From a point to a parallel rectangle a × b at the distance c, one corner of which is above the point."""
    x, y = a / c, b / c
    root_x, root_y = np.hypot(1, x), np.hypot(1, y)
    return (x / root_x * np.arctan(y / root_x) + y / root_y * np.arctan(x / root_y)) / (2 * np.pi)


def cracked_room(gap, lift=0.0):
    """The room with a wall of two parts that ends ``gap`` below the ceiling, and its T-junction with the floor."""
    vertices, faces = ROOM
    wall = np.isclose(vertices[faces][:, :, 0], 0).all(axis=1)
    a, b, c = [0, 0, lift], [0, 1.3, lift], [0, 3, 0]
    top = 2.5 - gap
    part = np.array([a, b, [0, 1.3, top], [0, 0, top], c, [0, 3, top]], float)
    pieces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    return joined((vertices, faces[~wall]), (part, pieces))


def test_an_exact_t_junction_loses_no_light(device, write):
    folder = write({"room": cracked_room(0.0)})
    _, findings = checked(device, folder)
    assert of_kind(findings, "leak") == [] and grave(findings) == []
    assert_even(light(device, folder))


def test_cracks_at_t_junctions_are_named_and_closed(device, write, capsys):
    """A wall ends 0.8 mm below the ceiling and stands on a kinked edge: light leaks there, less than 0.1 %."""
    folder = write({"room": cracked_room(8e-4, lift=5e-4)})
    _, findings = checked(device, folder)
    (leak,) = of_kind(findings, "leak")
    assert leak.object == "cad/room" and "through a crack near" in leak.message and 0.0 < leak.size < 0.1
    assert leak.place[0] == pytest.approx(0.0, abs=0.05)
    assert "too low" in leak.effect and leak.fix.startswith("close the gap")
    mended, said = repaired(folder, capsys)
    scene, findings = checked(device, mended)
    assert grave(findings) == []
    assert any("closed cracks" in line for line in said["mended"]), said
    assert of_kind(findings, "leak") == [] and "closed space" in of_kind(findings, "space")[0].message
    corners = scene.patches.corners()
    assert np.abs(np.einsum("ij,ij->i", scene.patches.normal, corners[:, 0]) @ scene.patches.area) == pytest.approx(
        3 * 4 * 3 * 2.5, rel=1e-3
    )
    assert_even(light(device, mended))


def test_cracks_between_walls_that_are_objects_of_their_own(device, write, capsys):
    """Six walls, each a little smaller than its place: the gaps of 0.6 mm go, and the light is even."""
    vertices, faces = ROOM
    walls = {}
    for number in range(6):
        own = faces[[number, number + 6]]
        middle = vertices[own].reshape(-1, 3).mean(axis=0)
        walls[f"wall {number}"] = (middle + (vertices - middle) * (1 - 3e-4), own)
    folder = write(walls, lamps=dict.fromkeys(walls, "wall"))
    text = (folder / "scene.toml").read_text().replace('" = "dark"', '" = "wall"')
    (folder / "scene.toml").write_text(text)
    _, findings = checked(device, folder)
    assert len(of_kind(findings, "leak")) == 1
    mended, said = repaired(folder, capsys)
    assert any(line.startswith("leak: closed cracks") for line in said["mended"]), said
    _, findings = checked(device, mended)
    assert grave(findings) == [] and "closed space" in of_kind(findings, "space")[0].message
    assert_even(light(device, mended))


def test_a_crack_too_wide_to_be_closed_is_said(device, write, capsys):
    folder = write({"room": cracked_room(0.02)})
    _, findings = checked(device, folder)
    (leak,) = of_kind(findings, "leak")
    assert leak.place[2] == pytest.approx(2.49, abs=0.02) and leak.place[0] == pytest.approx(0.0, abs=0.05)
    assert "too low" in leak.effect and leak.fix.startswith("close the gap")
    _, said = repaired(folder, capsys)
    assert any(line.startswith("leak of 'cad/room'") and "wider than 1 mm" in line for line in said["refused"]), said


def test_slivers_of_boolean_operations(device, write, capsys):
    """A cut 0.2 mm beside an edge leaves triangles 10 000 times as long as wide, which go into their neighbours."""
    vertices, faces = ROOM
    floor = np.isclose(vertices[faces][:, :, 2], 0).all(axis=1)
    a, b, c, d = [0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]
    cut = np.array([a, b, c, d, [2, 2e-4, 0], [2, 1.5, 0]], float)
    pieces = np.array([[0, 1, 4], [1, 5, 4], [1, 2, 5], [2, 3, 5], [3, 0, 5], [0, 4, 5]])
    folder = write({"room": joined((vertices, faces[~floor]), (cut, pieces))})
    _, findings = checked(device, folder)
    (finding,) = of_kind(findings, "sliver")
    assert "1 face of 'cad/room'" in finding.message and "4 m × 0.0002 m" in finding.message
    assert finding.size == pytest.approx(4.0) and finding.effect and finding.fix
    np.testing.assert_allclose(finding.place, [2, 0, 0], atol=1e-3)
    mended, said = repaired(folder, capsys)
    assert any(line.startswith("sliver") for line in said["mended"]), said
    scene, findings = checked(device, mended)
    assert grave(findings) == []
    assert scene.patches.area.sum() == pytest.approx(2 * (12 + 10 + 7.5), rel=1e-3)
    assert_even(light(device, mended))


def chairs(count, faces_a_leg):
    """Seats with four round legs each."""
    n = faces_a_leg // 4
    angle = 2 * np.pi * np.arange(n) / n
    ring = 0.02 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    leg = np.concatenate([np.c_[ring, np.zeros(n)], np.c_[ring, np.full(n, 0.44)], [[0, 0, 0], [0, 0, 0.44]]])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    tube = np.concatenate([np.stack([i, j, n + j], axis=1), np.stack([i, n + j, n + i], axis=1)])
    caps = [np.stack([np.full(n, 2 * n), j, i], axis=1), np.stack([np.full(n, 2 * n + 1), n + i, n + j], axis=1)]
    faces = np.concatenate([tube, *caps])
    legs = [(leg + [x, y, 0], faces) for x in (0.04, 0.36) for y in (0.04, 0.36)]
    chair = joined(block((0, 0, 0.441), (0.4, 0.4, 0.47)), *legs)
    rows = int(np.ceil(np.sqrt(count)))
    return joined(
        *[(chair[0] + [0.3 + 0.7 * (k % rows), 0.3 + 0.7 * (k // rows), 1e-3], chair[1]) for k in range(count)]
    )


@pytest.mark.slow
def test_two_hundred_thousand_faces_of_chair_legs(device, write):
    """100 chairs whose legs have 500 faces each stand in an even field: E is the same between the legs."""
    thing = chairs(100, 500)
    assert len(thing[1]) > 200_000
    hall = block((0, 0, 0), (7.5, 7.5, 3), inward=True)
    folder = write({"room": hall, "thing": thing})
    text = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(text.replace(EYES, points([(3.0, 3.0, 0.2), (0.5, 0.5, 0.3), (5, 5, 1.5)])))
    scene, findings = checked(device, folder)
    assert grave(findings) == []
    assert (scene.patches.solid[scene.patches.object == 1] != NONE).all()
    assert_even(light(device, folder), 0.01)


def test_a_folder_that_holds_something_is_left_alone(write, capsys):
    folder = write({"room": ROOM})
    (folder.parent / "mended").mkdir()
    (folder.parent / "mended" / "thesis.txt").write_text("years")
    assert main(["check", str(folder), "--repair", str(folder.parent / "mended")]) == 2
    assert "name a new folder" in capsys.readouterr().err
    assert main(["check", str(folder), "--repair", str(folder)]) == 2
    assert main(["check", str(folder), "--repair", str(folder / "cad.obj" / "x")]) == 2
    assert "x can't be written" in capsys.readouterr().err
    assert [path.name for path in (folder.parent / "mended").iterdir()] == ["thesis.txt"]
