"""Patches are cut where others stand on them, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, cube, moved
from scipy.spatial.transform import Rotation

from hradiosity.model.geometry import NONE
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.contact_cuts import cut_at_contacts
from hradiosity.space.lit_sides import find_lit_sides

TURN = Rotation.from_rotvec([0.3, 0.9, -0.5]).as_matrix()
FLOOR = 4


def room(size=(5, 4, 3)):
    b = SceneBuilder()
    b.box((0, 0, 0), size, b.material(0.5), inward=True)
    return b


def pieces_of(cut, patch):
    """Areas and centroids of the pieces of a patch."""
    mine = cut.parent == patch
    return cut.scene.patches.area[mine], cut.scene.patches.centroid[mine]


def cut_areas(cut, patches):
    return np.bincount(cut.parent, cut.scene.patches.area, minlength=len(patches))


@pytest.mark.parametrize("shift", (0.0, 1e4))
def test_areas_planes_and_properties_stay(shift):
    b = room()
    rng = np.random.default_rng(3)
    for _ in range(12):
        x, y, w, d = rng.uniform(0.3, 3, 2).tolist() + rng.uniform(0.5, 0.9, 2).tolist()
        b.box((x, y, 0), (x + w, y + d, rng.uniform(0.2, 2)), 0)
        angle = rng.uniform(0, np.pi)
        b.patch((x, y, 0), (np.cos(angle), np.sin(angle), 0), (0, 0, 1), 0)
    b.patch((4, 3, 0), (0, 0.5, 0), (0, 0, 3), 0, triangle=True)
    scene = moved(b.scene(), rotation=TURN, shift=(shift, -shift, shift))
    scene = replace(scene, patches=replace(scene.patches, surface=np.arange(7, 7 + len(scene.patches), dtype=np.int32)))
    cut = cut_at_contacts(scene)
    before, after = scene.patches, cut.scene.patches
    assert len(after) > len(before) + 50
    assert np.allclose(cut_areas(cut, before), before.area, rtol=1e-12, atol=0)
    assert np.allclose(after.normal, before.normal[cut.parent], atol=1e-9)
    for name in ("material", "object", "surface", "solid"):
        assert np.array_equal(getattr(after, name), getattr(before, name)[cut.parent])
    height = np.einsum("ncd,nd->nc", after.corners() - before.origin[cut.parent, None], before.normal[cut.parent])
    assert np.abs(height).max() < 1e-12 * max(shift, 1) * 10


def test_a_sheet_that_parts_the_room_parts_floor_and_ceiling_once():
    b = room()
    b.patch((2, 0, 0), (0, 4, 0), (0, 0, 3), 0)
    cut = cut_at_contacts(b.scene())
    assert np.bincount(cut.parent).tolist() == [1, 1, 2, 2, 2, 2, 1]
    assert not cut.scene.patches.is_triangle.any()
    area, centre = pieces_of(cut, FLOOR)
    assert sorted(area) == pytest.approx([8, 12])
    assert sorted(centre[:, 0]) == pytest.approx([1, 3.5])
    assert [note.kind for note in cut.scene.notes] == ["info"]


def test_an_oblique_sheet_leaves_no_piece_on_both_sides():
    b = room()
    along = np.array([1.0, 0.7])
    b.patch((1.5, 0, 0), (*(4 / 0.7 * along), 0), (0, 0, 3), 0)
    cut = cut_at_contacts(b.scene())
    patches = cut.scene.patches
    mine = cut.parent == FLOOR
    corners = patches.corners()[mine][..., :2] - [1.5, 0]
    side = corners[..., 0] * along[1] - corners[..., 1] * along[0]
    assert ((side > -1e-9).all(axis=1) | (side < 1e-9).all(axis=1)).all()
    assert patches.area[mine].sum() == pytest.approx(20, rel=1e-12)


def test_a_triangular_floor_is_cut():
    b = SceneBuilder()
    b.material(0.5)
    b.patch((0, 0, 0), (4, 0, 0), (0, 4, 0), 0, triangle=True)
    b.patch((1, 0, 0), (0, 3, 0), (0, 0, 1), 0)
    cut = cut_at_contacts(b.scene())
    left = pieces_of(cut, 0)[1][:, 0] < 1
    assert pieces_of(cut, 0)[0][left].sum() == pytest.approx(8 - 4.5, rel=1e-12)


@pytest.mark.parametrize("height", (0.0, 1e-3, -0.05), ids=("on it", "1 mm above", "sunk in"))
def test_what_a_block_covers_is_a_piece_of_its_own(height):
    b = room()
    b.box((1, 1, height), (2.2, 2.5, 1.0), 0, solid=True)
    cut = cut_at_contacts(b.scene())
    area, centre = pieces_of(cut, FLOOR)
    under = (np.abs(centre[:, 0] - 1.6) < 0.6) & (np.abs(centre[:, 1] - 1.75) < 0.75)
    assert area[under].sum() == pytest.approx(1.8, rel=1e-9)
    assert len(area) == 5


def test_legs_tables_and_neighbours_cut_nothing():
    b = room()
    for x in (1.0, 1.7):
        b.box((x, 1.0, 0.0), (x + 0.04, 1.04, 0.7), 0, solid=True)
    b.box((0.9, 0.9, 0.7), (2.5, 1.8, 0.73), 0, solid=True)
    b.box((5, 0, 0), (6, 4, 3), 0)
    b.patch((0, 4, 0), (2, 0, 0), (0, 1, 0), 0)
    scene = b.scene()
    assert cut_at_contacts(scene).scene is scene


def test_lamps_stay_whole_and_are_found_again():
    b = room()
    b.patch((2, 0, 0), (0, 4, 0), (0, 0, 3), 0)
    b.lamp(5, 1.0)
    b.point((1, 1, 1), 1.0)
    scene = b.scene()
    cut = cut_at_contacts(scene)
    assert cut.parent[cut.scene.emitters.patch[0]] == 5
    assert (cut.parent == 5).sum() == 1
    assert cut.scene.emitters.patch[1] == NONE


def test_two_faces_of_a_thin_sheet_make_one_cut():
    b = room()
    for x in (2.0, 2.003):
        b.patch((x, 0, 0), (0, 4, 0), (0, 0, 3), 0)
    cut = cut_at_contacts(b.scene())
    assert (cut.parent == FLOOR).sum() == 2


def test_number_of_pieces_is_bounded():
    b = room((30, 30, 3))
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(0, 27, (400, 2)):
        b.box((x, y, 0), (x + 2, y + 2, 1), 0)
    scene = b.scene()
    cut = cut_at_contacts(scene)
    assert len(cut.scene.patches) <= 3 * len(scene.patches)
    assert np.allclose(cut_areas(cut, scene.patches), scene.patches.area, rtol=1e-12, atol=0)
    assert "too many" in cut.scene.notes[-1].message


def test_no_patches_are_no_trouble():
    scene = SceneBuilder().scene()
    assert cut_at_contacts(scene).scene is scene
    convex = cube().scene()
    assert cut_at_contacts(convex).scene is convex


def test_lit_spaces_come_out_separate(device):
    b = room()
    b.patch((2, 0, 0), (0, 4, 0), (0, 0, 3), 0)
    b.point((1, 1, 1), 1.0)
    cut = cut_at_contacts(b.scene())
    lit = find_lit_sides(cut.scene, build_bvh(device, cut.scene.patches))
    left = cut.scene.patches.centroid[:, 0] < 2 - 1e-9
    own = cut.parent < 6
    assert np.array_equal(lit.lit[own, 0], left[own])
    modelled = lit.of_parents(cut.parent)
    assert modelled.lit[:, 0].tolist() == [True, False, True, True, True, True, False]
    assert modelled.lit[6, 1]
