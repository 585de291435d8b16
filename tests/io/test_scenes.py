"""The scenes that come with the program, the room for beginners, and the manual."""

import json
from pathlib import Path

import numpy as np
import pytest

from hradiosity.errors import OutputError, SceneError
from hradiosity.io.new_room import write_new_room
from hradiosity.io.scene.schema import SceneFile, scene_json_schema
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import NONE

SCENES = Path(__file__).parents[2] / "scenes"


def readings(scene):
    return sum(len(sensor.position) for sensor in scene.sensors)


def test_cornell_box():
    scene = load_scene(SCENES / "cornell_box")
    assert readings(scene) == 275
    assert len(scene.bands) == 81
    patches = scene.patches
    np.testing.assert_allclose(patches.bounds(), [[0, -0.5592, 0], [0.556, 0, 0.5488]], atol=1e-15)
    light = scene.emitters.patch
    np.testing.assert_allclose(patches.normal[light], [[0, 0, -1]], atol=1e-15)
    assert patches.area[light].sum() == pytest.approx(0.130 * 0.105, rel=1e-12)
    ceiling = patches.area[patches.object == scene.objects.index("ceiling")].sum()
    assert ceiling + patches.area[light].sum() == pytest.approx(0.556 * 0.5592, rel=1e-12)
    assert scene.views[0].field_of_view == pytest.approx(2 * np.degrees(np.arctan(0.0125 / 0.035)), abs=1e-4)


@pytest.mark.parametrize("name", ["short_block", "tall_block"])
def test_cornell_blocks_face_outwards(name):
    scene = load_scene(SCENES / "cornell_box")
    own = scene.patches.object == scene.objects.index(name)
    outwards = scene.patches.centroid[own] - scene.patches.centroid[own].mean(axis=0)
    assert (np.einsum("ij,ij->i", outwards, scene.patches.normal[own]) > 0).all()
    assert (scene.patches.solid[own] != NONE).all()


def test_cornell_walls_face_inwards():
    patches = load_scene(SCENES / "cornell_box").patches
    walls = patches.solid == NONE
    inwards = np.array([0.278, -0.28, 0.274]) - patches.centroid[walls]
    assert (np.einsum("ij,ij->i", inwards, patches.normal[walls]) > 0).all()


def test_integrating_cube():
    scene = load_scene(SCENES / "integrating_cube")
    assert len(scene.emitters) == 6
    np.testing.assert_allclose(scene.materials[0].reflectance, 0.2 + 0.6 * np.arange(81) / 80, rtol=1e-12)
    np.testing.assert_allclose(scene.luminaires[0].exitance, scene.bands.width, rtol=1e-14)


def test_small_lamp():
    scene = load_scene(SCENES / "small_lamp")
    assert scene.materials[1].reflectance.max() == 0
    np.testing.assert_array_equal(scene.patches.normal, [[0, 0, 1], [0, 0, -1]])


def test_two_rooms():
    scene = load_scene(SCENES / "two_rooms")
    assert readings(scene) == 144
    assert (scene.sensors[0].position[:, 0] > 4.2).all()
    assert (scene.emitters.position[:, 0] < 4).all()
    patches = scene.patches
    rooms = patches.solid == NONE
    # Closed: the faces, without the lamp, enclose both rooms and the gap.
    enclosed = -(np.einsum("ij,ij->i", patches.centroid, patches.normal) * patches.area)[rooms].sum() / 3
    assert enclosed == pytest.approx(2 * 48 + 0.2 * 0.1 * 3, rel=1e-12)
    np.testing.assert_allclose((patches.normal * patches.area[:, None])[rooms].sum(axis=0), 0, atol=1e-12)


@pytest.mark.parametrize("scene", sorted(path.parent.name for path in SCENES.glob("*/scene.toml")))
def test_every_scene_loads_and_says_what_is_known_of_its_answer(scene):
    load_scene(SCENES / scene)
    assert (SCENES / scene / "README.md").is_file()


def test_new_room_is_a_valid_scene(tmp_path):
    file = write_new_room(tmp_path / "room")
    scene = load_scene(file)
    assert file.name == "scene.toml"
    assert [sensor.name for sensor in scene.sensors] == ["work plane", "desk", "eye"]
    assert all(note.kind == "info" for note in scene.notes)


def test_remarks_in_the_new_room_are_valid_keys(tmp_path):
    """Remarks that hold a table or a key can be used by taking the # away."""
    file = write_new_room(tmp_path / "room")
    text = file.read_text(encoding="utf-8")
    for table in ("# [materials.sofa]", '# name = "painting"', "# bands"):
        assert table in text
    start = text.index("# [materials.sofa]")
    sofa = text[start:].split("\n\n")[0].replace("# [", "[").replace("# reflectance", "reflectance")
    painting = text[text.index('# name = "painting"') :].split("\n\n")[0].replace("# ", "")
    file.write_text(f"{text}\n{sofa}\n[[sensor]]\n{painting}\n", encoding="utf-8")
    scene = load_scene(file)
    assert scene.materials[-1].name == "sofa"
    assert scene.sensors[-1].name == "painting"


def test_new_room_overwrites_nothing(tmp_path):
    (tmp_path / "mine.txt").write_text("keep")
    with pytest.raises(OutputError, match="exists already"):
        write_new_room(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_new_room_in_a_place_that_cannot_be(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="can't be written"):
        write_new_room(tmp_path / "file" / "room")


def test_schema_describes_every_key():
    schema = scene_json_schema()
    json.dumps(schema)
    assert set(schema["properties"]) == set(SceneFile.model_fields)
    for name, table in schema["$defs"].items():
        assert table.get("description"), name
        assert table["additionalProperties"] is False
        for key, value in table["properties"].items():
            assert value.get("description") or "const" in value, f"{name}.{key}"


def test_scene_error_holds_the_faults():
    with pytest.raises(SceneError) as caught:
        load_scene(SCENES / "no such scene")
    assert caught.value.faults[0].found == "no such file or folder"
