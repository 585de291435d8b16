"""What solids cover that stand on floors, at walls and at each other: footprints, whichever way the room is turned."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube, moved
from scipy.spatial.transform import Rotation

from hradiosity.radiosity.shooting import shooting_points
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.flush import flush_reach
from hradiosity.space.hierarchy import COVERED, build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import trace_rows

X0, Y0, FLOOR = 0, 2, 4
RAYS = 4096
TURNS = [None, *range(4)]


def furnished(*boxes) -> SceneBuilder:
    room = cube()
    room.lamp(5, 1.0)
    wood = room.material(0.3)
    for low, high in boxes:
        room.box(low, high, wood, solid=True)
    return room


def turned(scene, turn):
    if turn is None:
        return scene
    return moved(scene, Rotation.random(random_state=turn).as_matrix(), (3.0, -40.0, 7.0), 1.7)


def covered_shares(device, scene):
    """Covered share of each front, in patch order, of the shown fronts, one element each."""
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    elements = build_elements(scene.patches, lit.space, np.array([True] * len(scene.materials)), 1e3, grouping=False)
    rows = trace_rows(upload_scene(device, scene, bvh, occlusion=True), upload_elements(device, elements), RAYS, 1).row
    side = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    share = np.zeros(len(scene.patches))
    share[side[side % 2 == 0] // 2] = (rows == COVERED).mean(axis=1)[side % 2 == 0]
    return share


ROOMS = {
    "nothing": ([], {}),
    "box on the floor": ([((0.3, 0.2, 0), (0.7, 0.6, 0.4))], {FLOOR: 0.16}),
    "cupboard in a corner": (
        [((0, 0, 0), (0.5, 0.4, 0.9))],
        {FLOOR: 0.2, X0: 0.36, Y0: 0.45},
    ),
    "picture on a wall": ([((0, 0.3, 0.4), (0.02, 0.7, 0.9))], {X0: 0.2}),
    "two boxes that touch": (
        [((0, 0, 0), (0.3, 0.4, 0.5)), ((0.3, 0, 0), (0.7, 0.4, 0.5))],
        {FLOOR: 0.28, X0: 0.2, Y0: 0.35, 7: 1.0, 12: 1.0},
    ),
    "boxes in a pile": (
        [((0.2, 0.2, 0), (0.6, 0.6, 0.3)), ((0.2, 0.2, 0.3), (0.4, 0.6, 0.5))],
        {FLOOR: 0.16, 11: 0.5, 16: 1.0},
    ),
}


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("name", ROOMS)
def test_covered_areas_are_footprints(device, name, turn):
    """Points are nets: 4096 of them count a rectangle to within some 64 on its rim, mostly far fewer."""
    boxes, footprints = ROOMS[name]
    share = covered_shares(device, turned(furnished(*boxes).scene(), turn))
    for patch in range(6):
        assert share[patch] == pytest.approx(footprints.get(patch, 0.0), abs=0.005), patch
    for patch in range(6, len(share)):
        # Faces that lie in a wall have no lit row; those that another box hides may have one, which is then covered.
        if share[patch] > 0.0:
            assert share[patch] == pytest.approx(footprints.get(patch, 0.0), abs=0.005), patch


@pytest.mark.parametrize("turn", TURNS)
def test_points_that_shoot_lie_beside_the_solids(device, turn):
    scene = turned(furnished(((0, 0, 0), (0.9, 0.9, 0.95))).scene(), turn)
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    grid = build_elements(
        scene.patches, lit.space, np.array([True] * len(scene.materials)), 0.05 * (1 if turn is None else 1.7)
    )
    points = shooting_points(bvh, scene.patches, grid, np.arange(len(grid)), np.random.default_rng(1))
    floor = points.exposed & (points.patch == FLOOR)
    patches = scene.patches
    local = points.position[floor] - patches.origin[FLOOR]
    edges = np.stack([patches.edge_u[FLOOR], patches.edge_v[FLOOR]])
    uv = local @ edges.T / (edges**2).sum(axis=1)
    assert floor.sum() > 20
    assert (uv.max(axis=1) > 0.9 - 1e-5).all()


def test_only_sides_that_a_solid_touches_from_inside_are_flush():
    """The wall's front, and of two boxes the faces in common; a face never for its own solid."""
    scene = furnished(((0.2, 0.2, 0), (0.5, 0.5, 0.5)), ((0.5, 0.2, 0.2), (0.6, 0.5, 0.5))).scene()
    reach = flush_reach(scene.patches)
    big, small = np.sqrt(0.09 + 0.09 + 0.25), np.sqrt(0.01 + 0.09 + 0.09)
    expected = np.zeros((18, 2))
    expected[FLOOR, 0] = big
    expected[7, 0], expected[12, 0] = small, big
    # Faces side by side in one plane (y0, y1, z1) have no area in common.
    np.testing.assert_allclose(reach, expected, rtol=2e-3)


def test_back_of_a_sheet_that_shows_the_room_is_flush():
    room = SceneBuilder()
    paint = room.material(0.5)
    room.patch((0, 0, 0), (0, 1, 0), (1, 0, 0), paint)
    room.box((0.2, 0.2, 0), (0.5, 0.5, 0.5), paint, solid=True)
    reach = flush_reach(room.scene().patches)
    assert reach[0, 0] == 0.0
    assert reach[0, 1] == pytest.approx(np.sqrt(0.09 + 0.09 + 0.25), rel=2e-3)


def test_without_solids_nothing_is_flush():
    assert not flush_reach(cube().scene().patches).any()
