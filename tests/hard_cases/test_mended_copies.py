"""A mended copy of a scene without faults is the same scene; units, axes, placing and pictures survive."""

from pathlib import Path

import numpy as np
import pytest
from cad import block, checked, grid, write_obj
from PIL import Image

from hradiosity.cli import main
from hradiosity.io.mending.scene_copy import SceneCopy
from hradiosity.io.mending.stitching import open_edges, stitched
from hradiosity.io.mending.toml_text import toml_text
from hradiosity.io.scene_toml import load_scene, scene_file

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def assert_same(one, other):
    """Patches, paints and lamps of two scenes, whose objects may be numbered differently."""
    assert one.objects == other.objects and one.name == other.name
    np.testing.assert_array_equal(one.bands.lower, other.bands.lower)
    for name in ("origin", "edge_u", "edge_v"):
        np.testing.assert_allclose(getattr(one.patches, name), getattr(other.patches, name), atol=1e-9)
    np.testing.assert_array_equal(one.patches.object, other.patches.object)
    np.testing.assert_array_equal(one.patches.solid, other.patches.solid)
    for mine, others in ((a.patches.material, b.patches.material) for a, b in [(one, other)]):
        np.testing.assert_allclose(one.reflectance[mine], other.reflectance[others], atol=1e-12)
    np.testing.assert_array_equal(one.emitters.patch, other.emitters.patch)
    for a, b in zip(one.emitters.luminaire, other.emitters.luminaire, strict=True):
        np.testing.assert_allclose(one.luminaires[a].exitance, other.luminaires[b].exitance, rtol=1e-9)
    for a, b in zip(one.sensors, other.sensors, strict=True):
        np.testing.assert_allclose(a.position, b.position, atol=1e-9)
    assert len(one.views) == len(other.views) and (one.sky is None) == (other.sky is None)


@pytest.mark.parametrize("name", sorted(path.parent.name for path in SCENES.glob("*/scene.toml")))
def test_the_copy_of_a_shipped_scene_is_that_scene(tmp_path, name):
    SceneCopy(scene_file(SCENES / name)).write(tmp_path)
    assert_same(load_scene(SCENES / name), load_scene(tmp_path))


STRANGE = """
[scene]
title = "a \\"strange\\" scene"
unit = "in"
up = "y"
bands = { ranges = [[400, 500], [550, 650]] }
[materials."dark red, matt"]
reflectance = { file = "sub/paint.csv", column = "b" }
[materials.plain]
reflectance = 0.5
sides = "front"
[luminaires.lamp]
spectrum = { constant = 1.0 }
luminous_flux_lm = 100
[[rectangle]]
corner = [0, 100, 0]
edge_u = [10, 0, 0]
edge_v = [0, 0, 10]
material = "plain"
luminaire = "lamp"
[[polygon]]
vertices = [[0, 0, 0], [0, 0, 50], [50, 0, 50], [60, 0, 20], [50, 0, 0]]
material = "dark red, matt"
[[box]]
centre = [30, 30, 30]
size = [10, 20, 5]
rotation_deg = 30
material = "plain"
omit = ["top"]
[[mesh]]
file = "things.obj"
unit = "cm"
up = "y"
material = "plain"
materials = { "block" = "dark red, matt" }
upsample = "mallett2019"
position = [5, 10, 15]
rotation_deg = 40
scale = 1.5
[[sensor]]
name = "on"
kind = "surface"
object = "things/block"
counts = [1, 1]
"""


@pytest.fixture
def strange(tmp_path):
    folder = tmp_path / "strange"
    (folder / "sub").mkdir(parents=True)
    (folder / "sub" / "paint.csv").write_text("nm,a,b\n380,0.1,0.2\n780,0.3,0.4\n")
    (folder / "scene.toml").write_text(STRANGE)
    write_obj(
        folder / "things.obj",
        {"block": block((0, 0, 0), (20, 30, 40)), "sheet": grid((50, 0, 0), (9, 0, 0), (0, 9, 0), 2)},
    )
    text = (folder / "things.obj").read_text().replace("o sheet", "mtllib a.mtl\no sheet\nusemtl wood")
    (folder / "things.obj").write_text(text)
    (folder / "a.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")
    Image.fromarray(np.full((4, 4, 3), [200, 120, 40], np.uint8)).save(folder / "wood.png")
    return folder


def test_units_axes_placing_spectra_and_pictures_survive(strange, tmp_path):
    (tmp_path / "copy").mkdir()
    SceneCopy(strange / "scene.toml").write(tmp_path / "copy")
    scene, copied = load_scene(strange), load_scene(tmp_path / "copy")
    assert_same(scene, copied)
    assert sum(not material.measured for material in copied.materials) == 1


KINDS = ("rectangle-1", "polygon-1", "box-1", "things/block")


def test_things_move_and_turn_in_metres_of_the_scene(strange, tmp_path):
    """One of each kind by another step, z up, whatever the unit, axis and turn of the file; then they turn round."""
    before = load_scene(strange)
    steps = np.zeros((len(before.objects), 3))
    scene = SceneCopy(strange / "scene.toml")
    for number, name in enumerate(KINDS):
        owner = before.objects.index(name)
        steps[owner] = [0.01 + 0.1 * number, 0.02, 0.03 - 0.05 * number]
        scene.move(name, steps[owner])
    scene.write(tmp_path)
    after = load_scene(tmp_path)
    step = after.patches.centroid - before.patches.centroid
    np.testing.assert_allclose(step, steps[before.patches.object], atol=1e-9)
    for name in KINDS:
        scene.turn(name, np.arange((before.patches.object == before.objects.index(name)).sum()))
    (tmp_path / "turned").mkdir()
    scene.write(tmp_path / "turned")
    turned = load_scene(tmp_path / "turned")
    for name in KINDS:
        own = before.patches.object == before.objects.index(name)
        np.testing.assert_allclose(flux(turned, own), -flux(after, own), atol=1e-9)


def flux(scene, own):
    """(3,) sum of area x normal x centroid, axis by axis: a signed volume that changes sign with the faces."""
    patches = scene.patches
    return np.einsum("ij,i->j", (patches.normal * patches.centroid)[own], patches.area[own])


def test_toml_text_is_read_as_it_was():
    import tomllib

    tables = {
        "scene": {"unit": "m", "title": 'q"uote \\ \x7f\n é', "n": 3, "f": 1e-300, "yes": True},
        "materials": {"a b": {"reflectance": {"steps": [[380, 500.5, 0.1]]}}, "c": {"reflectance": 0.2}},
        "box": [{"size": [1, 2, 3], "faces": {"top": "a b"}, "omit": []}, {"inside": False}],
    }
    assert tomllib.loads(toml_text(tables, "two\nlines")) == tables


def test_stitching_leaves_a_closed_body_alone():
    points, faces = block((0, 0, 0), (1, 1, 1))
    _, triangles, source = stitched(points, faces, 1e-3)
    np.testing.assert_array_equal(triangles, faces)
    np.testing.assert_array_equal(source, np.arange(12))


@pytest.mark.parametrize("gap", [1e-6, 1e-4, 9e-4])
def test_stitching_closes_what_was_pulled_apart(gap):
    """Each triangle of a subdivided cube moves by a random step: one closed body of the same volume again."""
    sheets = [
        grid((0, 0, 0), (0, 1, 0), (1, 0, 0), 4),
        grid((0, 0, 1), (1, 0, 0), (0, 1, 0), 3),
        grid((0, 0, 0), (1, 0, 0), (0, 0, 1), 5),
        grid((0, 1, 0), (0, 0, 1), (1, 0, 0), 2),
        grid((0, 0, 0), (0, 0, 1), (0, 1, 0), 4),
        grid((1, 0, 0), (0, 1, 0), (0, 0, 1), 3),
    ]
    rng = np.random.default_rng(3)
    corners = np.concatenate([vertices[faces] for vertices, faces in sheets]).reshape(-1, 3)
    corners = corners + gap / 4 * rng.uniform(-1, 1, corners.shape)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    assert len(open_edges(triangles)[0]) == triangles.size
    points, closed, source = stitched(corners, triangles, gap)
    assert len(open_edges(closed)[0]) == 0
    assert np.linalg.norm(points - corners, axis=1).max() <= gap
    a, b, c = points[closed].transpose(1, 0, 2)
    assert abs(np.einsum("ij,ij->", np.cross(a, b), c) / 6) == pytest.approx(1.0, abs=6 * gap)
    assert source.max() < len(triangles)


def test_a_scene_that_needs_nothing_is_copied(device, tmp_path, capsys):
    assert main(["check", str(SCENES / "two_rooms"), "--repair", str(tmp_path / "copy")]) == 0
    assert "nothing was to be mended" in capsys.readouterr().out
    checked(device, tmp_path / "copy")
