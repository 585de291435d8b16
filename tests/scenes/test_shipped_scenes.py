"""Every scene that comes with the program can be used, and is what its text promises."""

import sys
from pathlib import Path

import numpy as np
import pytest

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import NONE

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenes"
SHIPPED = sorted(path.parent for path in SCENES.glob("*/scene.toml") if path.parent.name != "open_plan")
RESTING = 2e-6
"""What may rest on each other within rounding of the scene files, which state micrometres [m]."""


@pytest.fixture
def scripts(monkeypatch):
    """The scene-writing scripts, which import each other by bare names."""
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    import make_office
    import make_open_plan

    yield make_office, make_open_plan
    for name in ("furniture", "scene_text", "sensor_grid", "make_office", "make_open_plan"):
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def office():
    return load_scene(SCENES / "office")


def depth_inside(points, patches, solid):
    """(n,) depth of points below the nearest face of a convex solid [m]; negative outside."""
    own = patches.solid == solid
    height = np.einsum("psk,sk->ps", points[:, None] - patches.origin[own], patches.normal[own])
    return -height.max(axis=1)


def convex_solids(patches):
    """Solids all of whose corners lie behind all of their faces; a room is none."""
    corners = patches.corners()
    numbers = [number for number in np.unique(patches.solid) if number != NONE]
    return [n for n in numbers if depth_inside(corners[patches.solid == n].reshape(-1, 3), patches, n).min() > -1e-6]


@pytest.mark.parametrize("folder", SHIPPED, ids=lambda folder: folder.name)
def test_loads_with_light_and_readings(folder):
    scene = load_scene(folder)
    assert len(scene.emitters) > 0
    assert sum(len(sensor.position) for sensor in scene.sensors) > 0
    assert (scene.patches.area > 0).all()


def test_every_folder_is_a_scene_or_says_how_to_write_it():
    without = {path.name for path in SCENES.iterdir() if path.is_dir()} - {path.name for path in SHIPPED}
    assert without <= {"open_plan"}
    assert "make_open_plan.py" in (SCENES / "open_plan" / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("folder", [f for f in SHIPPED if f.name != "cornell_box"], ids=lambda folder: folder.name)
def test_no_sensor_point_is_inside_a_solid(folder):
    """The Cornell box is left out: its grid goes under the blocks on purpose."""
    scene = load_scene(folder)
    points = np.concatenate([sensor.position for sensor in scene.sensors])
    for solid in convex_solids(scene.patches):
        assert depth_inside(points, scene.patches, solid).max() < 0


def test_office_is_what_it_says(office):
    assert not [note for note in office.notes if note.kind == "warning"]
    assert len(office.patches) == 2148
    assert len(office.emitters) == 6
    assert {sensor.name: len(sensor.position) for sensor in office.sensors} == {"desk": 380, "eyes": 6}
    assert len(office.views) == 2
    assert len(np.unique(office.emitters.luminaire)) == 3
    assert np.allclose(office.patches.normal[office.emitters.patch], [0, 0, -1])
    varied = np.ptp(office.reflectance, axis=1) > 0.05
    assert varied.sum() >= 8
    heights = np.unique(office.sensors[0].position[:, 2])
    np.testing.assert_allclose(heights, 0.8)


def test_office_text_is_what_the_script_writes(scripts):
    make_office, _ = scripts
    assert (SCENES / "office" / "scene.toml").read_text(encoding="utf-8") == make_office.scene_text()


def overlap(patches, pair):
    """(n,) least overlap of pairs of coplanar parallelograms along the directions across their edges [m]."""
    first, second = pair
    between = patches.centroid[first] - patches.centroid[second]
    least = np.full(len(first), np.inf)
    for one in (first, second):
        for edge in (patches.edge_u[one], patches.edge_v[one]):
            across = np.cross(patches.normal[one], edge)
            across /= np.linalg.norm(across, axis=1, keepdims=True)
            reach = sum(
                np.abs(np.einsum("ij,ij->i", side[k], across))
                for side in (patches.edge_u, patches.edge_v)
                for k in (first, second)
            )
            least = np.minimum(least, 0.5 * reach - np.abs(np.einsum("ij,ij->i", between, across)))
    return least


def test_no_two_faces_of_the_office_share_a_place_and_a_side(office):
    """Contact (a leg on the floor) has opposite normals; equal ones in one plane would fight for visibility."""
    patches = office.patches
    normal, offset = patches.normal, np.einsum("ij,ij->i", patches.normal, patches.origin)
    first, second = np.triu_indices(len(patches), k=1)
    same = np.abs(offset[first] - offset[second]) < 5e-4
    first, second = first[same], second[same]
    same = np.einsum("ij,ij->i", normal[first], normal[second]) > 1 - 1e-9
    pair = first[same], second[same]
    assert len(pair[0]) > 100
    assert overlap(patches, pair).max() < RESTING


def test_solids_of_the_office_do_not_run_into_each_other(office):
    """No corner or face centre of one thing lies inside another."""
    patches = office.patches
    probes = np.concatenate([patches.corners().reshape(-1, 3), patches.centroid])
    owner = np.concatenate([np.repeat(patches.solid, 4), patches.solid])
    solids = convex_solids(patches)
    assert len(solids) == 357
    for solid in solids:
        others = owner != solid
        assert depth_inside(probes[others], patches, solid).max() < RESTING


def test_open_plan_is_what_it_says(scripts, tmp_path):
    _, make_open_plan = scripts
    make_open_plan.write_open_plan(tmp_path)
    scene = load_scene(tmp_path)
    assert 35_000 <= len(scene.patches) <= 40_000
    assert len(scene.emitters) == 120
    assert sum(len(sensor.position) for sensor in scene.sensors) == 5800
