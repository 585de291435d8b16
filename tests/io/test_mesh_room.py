"""The example scene made of mesh files: what its script writes, and what is read from it."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import NONE

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "scenes" / "mesh_room"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("make_mesh_room", ROOT / "examples" / "make_mesh_room.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_files_are_what_the_script_writes(script, tmp_path):
    script.main(tmp_path)
    for written in tmp_path.iterdir():
        assert written.read_bytes() == (FOLDER / written.name).read_bytes(), written.name


def test_room_is_closed_and_furniture_is_solid(script):
    """Volumes by the divergence theorem: an L of 22 m² seen from inside, lamps, boards and legs from outside."""
    scene = load_scene(FOLDER)
    patches = scene.patches
    flux = patches.area * np.einsum("ij,ij->i", patches.centroid, patches.normal) / 3.0
    volume = dict(zip(scene.objects, np.bincount(patches.object, flux)))
    stool = 0.4 * 0.4 * 0.06 + 4 * 0.03 * 0.03 * 0.39
    expected = {
        "room/L room": -22.0 * script.HEIGHT,
        "room/light panel A": np.prod(script.PANEL_SIZE),
        "room/light panel B": np.prod(script.PANEL_SIZE),
        "furniture/table": 1.6 * 0.8 * 0.03 + 4 * 0.05 * 0.05 * 0.71,
        "furniture/stool by the window": stool,
        "furniture/stool by the door": stool,
    }
    assert volume == pytest.approx(expected, rel=1e-6)
    assert (patches.solid[patches.object == 0] == NONE).all()
    assert len(np.unique(patches.solid[patches.object > 0])) == 2 + 3 * 5
    below = patches.normal[scene.emitters.patch]
    np.testing.assert_allclose(below, [[0, 0, -1], [0, 0, -1]], atol=1e-12)
