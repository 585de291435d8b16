"""Which walls are cut because light goes through the slot between them, and how finely."""

from pathlib import Path

import numpy as np
import pytest
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import Patches
from hradiosity.options import Options
from hradiosity.planning import make_plan
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.contact_cuts import cut_at_contacts
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.slots import EXTRA_ANYWAY, EXTRA_SHARE, MOST_CELLS, with_slots
from hradiosity.space.substructure import cut_substructure

SCENES = Path(__file__).parents[2] / "scenes"


def two_rooms(width, depth):
    """Two rooms of 1 m, with a wall between them that has a slot from floor to ceiling; and the slot's walls."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (2 + depth, 1, 1), paint, inward=True)
    left = b.box((1, 0, 0), (1 + depth, 0.5, 1), paint, solid=True)
    right = b.box((1, 0.5 + width, 0), (1 + depth, 1, 1), paint, solid=True)
    b.lamp(b.patch((0.25, 0.25, 0.98), (0, 0.5, 0), (0.5, 0, 0), paint), 1000.0)
    return b, (left[3], right[2])


def slots_of(device, scene):
    """(n_patches, 2) wanted cells; the most of a few seeds, since few rays don't always find light in a slot."""
    cut = cut_at_contacts(scene)
    bvh = build_bvh(device, cut.scene.patches)
    found = [find_lit_sides(cut.scene, bvh, seed=seed).of_parents(cut.parent).slots for seed in range(6)]
    return np.max(found, axis=0)


@pytest.mark.parametrize(("width", "depth", "cells"), [(0.001, 0.05, 16), (0.01, 0.1, 14), (0.02, 0.1, 8)])
def test_walls_of_a_slot_between_two_rooms(device, width, depth, cells):
    """Both walls, from room to room, in cells of three quarters of the width."""
    b, walls = two_rooms(width, depth)
    scene = b.scene()
    slots = slots_of(device, scene)
    patches = scene.patches
    for wall in walls:
        length = np.array([np.linalg.norm(patches.edge_u[wall]), np.linalg.norm(patches.edge_v[wall])])
        assert slots[wall][np.argmin(length)] == cells
    others = np.setdiff1d(np.arange(len(patches)), walls)
    across = np.stack([np.linalg.norm(e, axis=1) for e in (patches.edge_u, patches.edge_v)], axis=1) < 0.5
    assert not slots[others][across[others]].any()


@pytest.mark.parametrize("width", [0.1, 0.3])
def test_a_doorway_is_no_slot(device, width):
    b, walls = two_rooms(width, 0.05)
    assert not slots_of(device, b.scene())[list(walls)].any()


def test_gaps_that_join_nothing_are_no_slots(device):
    """A cupboard 1 cm off the wall, whose ends open into one room; books, with the dark behind them; a groove."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (3, 3, 3), paint, inward=True)
    b.box((0.01, 1, 0), (0.4, 2, 2), paint, solid=True)
    for k in range(3):
        b.box((1.0 + 0.05 * k, 0.03, 1.0), (1.045 + 0.05 * k, 0.2, 1.25), paint, solid=True)
    b.box((0.9, 0.0, 0.95), (1.25, 0.25, 1.0), paint, solid=True)
    b.box((0.9, 0.0, 1.25), (1.25, 0.25, 1.3), paint, solid=True)
    b.box((2.0, 2.0, 0.0), (2.2, 2.5, 0.3), paint, solid=True)
    b.box((2.21, 2.0, 0.0), (2.4, 2.5, 0.3), paint, solid=True)
    b.lamp(b.patch((1, 1, 2.9), (0, 1, 0), (1, 0, 0), paint), 1000.0)
    assert not slots_of(device, b.scene())[6:-1].any()


def test_slots_do_not_depend_on_place_turn_and_scale(device):
    b, walls = two_rooms(0.01, 0.1)
    plain = slots_of(device, b.scene())[list(walls)]
    turn = Rotation.from_euler("xyz", [0.3, 1.1, -0.4]).as_matrix()
    other = moved(b.scene(), turn, (1e4, -2e3, 500.0), 0.01)
    np.testing.assert_allclose(slots_of(device, other)[list(walls)], plain, atol=2)


def strips(n, triangles=False):
    """Squares of 1 m, or halves of them."""
    edge = np.eye(3)
    return Patches(
        origin=np.zeros((n, 3)),
        edge_u=np.tile(edge[0], (n, 1)),
        edge_v=np.tile(edge[1], (n, 1)),
        is_triangle=np.full(n, triangles),
        **{name: np.zeros(n, np.int32) for name in ("material", "object", "surface", "solid")},
    )


@pytest.mark.parametrize("triangles", [False, True])
@pytest.mark.parametrize(("n", "cut"), [(1, True), (200_000, False)])
def test_slots_add_no_more_than_their_share(n, cut, triangles):
    patches = strips(n, triangles)
    divisions = np.full((n, 2), 2, np.int64)
    wanted = np.full((n, 2), MOST_CELLS) if triangles else np.tile([MOST_CELLS, 0], (n, 1))
    raised = with_slots(patches, np.ones(n, np.int64), divisions, wanted)
    assert (raised >= divisions).all() and not (raised % 2).any()
    assert (raised[:, 0] == (MOST_CELLS if cut else 2)).all()
    cells = raised.prod(axis=1)
    assert cells.sum() <= 4 * n + max(EXTRA_SHARE * 4 * n, EXTRA_ANYWAY)


def test_patches_that_shoot_are_cut_where_light_goes_through(device):
    """Of the slot's walls, four widths deep, every patch is at most a width long; all others stay as they are."""
    room, walls = two_rooms(0.1, 0.4)
    scene = room.scene()
    lit = find_lit_sides(scene, build_bvh(device, scene.patches))
    two_sided = np.array([m.two_sided for m in scene.materials])
    coarse, cut = (
        cut_substructure(scene.patches, lit.space, two_sided, 0.5, slots).levels[0].divisions
        for slots in (None, lit.slots)
    )
    assert (np.flatnonzero((coarse != cut).any(axis=1)) == sorted(walls)).all()
    assert (0.4 / cut[list(walls)].max(axis=1) <= 0.1).all()


@pytest.mark.parametrize("name", ["cornell_box", "mesh_room", "office", "open_plan", "two_rooms"])
def test_ordinary_rooms_hardly_get_more_elements(device, name):
    if not (SCENES / name / "scene.toml").exists():
        pytest.skip("made by a script under examples/")
    scene = cut_at_contacts(load_scene(SCENES / name / "scene.toml")).scene
    lit = find_lit_sides(scene, build_bvh(device, scene.patches))
    size = make_plan(scene, Options(), lit).element_size
    two_sided = np.array([m.two_sided for m in scene.materials])
    without, found = (
        len(build_elements(scene.patches, lit.space, two_sided, size, slots=slots)) for slots in (None, lit.slots)
    )
    assert without <= found <= 1.03 * without
