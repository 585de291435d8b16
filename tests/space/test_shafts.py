"""Proofs of sight: against every separating direction tried in double, and against many rays."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from ray_scenes import make_patches
from rooms import SceneBuilder, cube, moved
from scipy.spatial.transform import Rotation

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import NONE
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.shafts import FREE, HIDDEN, UNKNOWN, EmitterShapes, Receivers, point_sight, prove_sight, row_sight
from hradiosity.space.visibility import trace_any

OFFICE = Path(__file__).parents[2] / "scenes" / "office"
TURN = Rotation.from_euler("xyz", [31.0, -17.0, 58.0], degrees=True).as_matrix()
UP = np.array([0.0, 0.0, 1.0])


def quads(rng, n, height, size, normal_z):
    """(n, 4, 3) parallelograms about a height, counter-clockwise seen from normal_z, tilted by up to 20°."""
    centre = np.column_stack([rng.uniform(-1, 1, (n, 2)), np.full(n, height)])
    edge_u, edge_v = rng.normal(scale=size, size=(2, n, 3)) * [1.0, 1.0, 0.2]
    flip = np.cross(edge_u, edge_v)[:, 2] * normal_z < 0
    edge_u[flip], edge_v[flip] = edge_v[flip], edge_u[flip].copy()
    corners = centre[:, None] + np.stack([0 * edge_u, edge_u, edge_u + edge_v, edge_v], axis=1)
    normal = np.cross(edge_u, edge_v)
    return corners, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def reach_into_hull(hull, triangles, slack):
    """Which triangles (n, 3, 3) come within `slack` of the hull of points (8, 3): every direction in which two convex
    bodies can lie apart is a normal of a face of one, or normal to an edge of each."""
    beside = (triangles.min(axis=1) > hull.max(axis=0) - slack).any(axis=1)
    beside |= (triangles.max(axis=1) < hull.min(axis=0) + slack).any(axis=1)
    near = np.flatnonzero(~beside)
    triangles = triangles[near]
    pairs = np.array(list(combinations(range(8), 2)))
    edges = hull[pairs[:, 1]] - hull[pairs[:, 0]]
    faces = np.array([np.cross(hull[b] - hull[a], hull[c] - hull[a]) for a, b, c in combinations(range(8), 3)])
    sides = np.roll(triangles, -1, axis=1) - triangles
    own = np.cross(sides[:, 0], sides[:, 1])[:, None]
    crossed = np.cross(sides[:, :, None], edges[None, None]).reshape(len(triangles), 3 * len(edges), 3)
    normal = np.concatenate([np.broadcast_to(faces, (len(triangles), *faces.shape)), own, crossed], axis=1)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 1e-9)
    of_hull = normal @ hull.T
    of_triangle = normal @ triangles.transpose(0, 2, 1)
    gap = np.maximum(of_hull.min(2) - of_triangle.max(2), of_triangle.min(2) - of_hull.max(2))
    return near[gap.max(axis=1) < slack]


@pytest.mark.parametrize("n_obstacles", [3, 12, 30])
def test_proofs_agree_with_all_separating_directions_in_double(device, n_obstacles):
    """No false proof; and of the pairs that are truly free, nine in ten are proved."""
    rng = np.random.default_rng(n_obstacles)
    n = 300
    corners, normal = quads(rng, n, -1.0, 0.1, 1.0)
    lamp_corners, lamp_normal = quads(rng, n, 1.0, 0.2, -1.0)
    edges = rng.normal(scale=0.12, size=(2, n_obstacles, 3))
    obstacles = make_patches(rng.uniform(-0.8, 0.8, (n_obstacles, 3)), *edges, rng.random(n_obstacles) < 0.5)
    bvh = build_bvh(device, obstacles)
    none = np.full(n, NONE)
    lamps = EmitterShapes(lamp_corners, lamp_normal, none, np.zeros(n, bool))
    found = prove_sight(bvh, Receivers(corners, normal, none), lamps, np.arange(n), np.arange(n), most_visits=200)
    c = obstacles.corners()
    triangles = np.concatenate([c[:, [0, 1, 2]], c[~obstacles.is_triangle][:, [2, 3, 0]]])
    # The tolerance between touching and blocking is 2⁻²¹ of the scene's size.
    above = np.einsum("rek,rk->re", lamp_corners - corners[:, :1], normal).min(axis=1) > 0.0
    before = np.einsum("rek,rk->re", corners - lamp_corners[:, :1], lamp_normal).min(axis=1) > 0.0
    found = found[above & before]
    hulls = np.concatenate([corners, lamp_corners], axis=1)[above & before]
    blocked = np.array([len(reach_into_hull(hull, triangles, -1e-6)) > 0 for hull in hulls])
    surely_free = np.array([not len(reach_into_hull(hull, triangles, 1e-5)) for hull in hulls])
    assert not (found[blocked] == FREE).any()
    assert blocked.sum() > 15
    assert surely_free.sum() > 50
    assert (found[surely_free] == FREE).mean() > 0.9


def points_in(corners, rng):
    """A point spread evenly over each parallelogram or triangle (n, 4, 3), which repeats its last corner."""
    a, b = rng.random((2, len(corners), 1))
    triangle = (corners[:, 2] == corners[:, 3]).all(axis=1)[:, None]
    fold = triangle & (a + b > 1)
    a, b = np.where(fold, 1 - a, a), np.where(fold, 1 - b, b)
    along = corners[:, 3] - corners[:, 0]
    return corners[:, 0] + a * (corners[:, 1] - corners[:, 0]) + b * along


def hits_at_proved_pairs(device, scene, size, rays, seed=0):
    """Share of pairs of a cell and an emitter proved free, and how many of `rays` random rays between those hit."""
    patches = scene.patches
    bvh = build_bvh(device, patches)
    lit = find_lit_sides(scene, bvh)
    elements = build_elements(patches, lit.space, np.ones(len(scene.materials), bool), size)
    lamps = EmitterShapes.of(scene)
    sight = row_sight(bvh, patches, elements, lamps, lit)[elements.cell_row]
    rng = np.random.default_rng(seed)
    cell, emitter = np.nonzero(sight == FREE)
    which = rng.integers(0, len(cell), rays)
    cell, emitter = cell[which], emitter[which]
    side = elements.cell_side[cell].astype(int)
    normal = patches.normal[side // 2] * np.where(side % 2 == 1, -1.0, 1.0)[:, None]
    origin = points_in(cell_corners(patches, elements)[0][cell], rng)
    target = points_in(lamps.corners[emitter], rng)
    local = np.abs(bvh.to_local(origin)).max(axis=1)
    start = origin + (2.0**-20 * np.maximum(local, bvh.scale))[:, None] * normal
    way = target - origin
    lit_side = np.einsum("rk,rk->r", way, lamps.normal[emitter]) < 0
    used = (np.einsum("rk,rk->r", way, normal) > 0) & (lit_side | lamps.two_sided[emitter] | (lamps.patch[emitter] < 0))
    assert used.mean() > 0.9
    hit = trace_any(bvh, start[used], (target - start)[used], 1.0, side[used] // 2, lamps.patch[emitter][used])
    return (sight == FREE).mean(), int(hit.sum())


def furnished(rng, boxes=6):
    """A room with boxes on its floor, some of them touching a wall or each other, a lamp under the ceiling, a point
    source and a two-sided lamp."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (5, 4, 3), paint, inward=True)
    for k in range(boxes):
        low = np.array([0.0 if k == 0 else rng.uniform(0, 4), rng.uniform(0, 3), 0.0])
        size = rng.uniform([0.2, 0.2, 0.1], [1.0, 1.0, 1.2])
        b.box(low, low + size, paint, solid=True)
        if k == 1:
            b.box(low + [size[0], 0, 0], low + [size[0] + 0.3, size[1], 0.3], paint, solid=True)
    b.lamp(b.patch((2, 1.5, 2.9), (0, 1, 0), (1, 0, 0), paint), 1.0)
    b.lamp(b.patch((4, 3, 2.0), (0, 0.3, 0.1), (0.3, 0, 0.1), paint), 1.0, two_sided=True)
    b.point((1.0, 3.5, 2.2), 1.0)
    return b.scene()


def test_no_ray_between_proved_pairs_meets_anything(device):
    rng = np.random.default_rng(7)
    for shift, turn in (((0.0, 0.0, 0.0), None), ((0.0, 0.0, 0.0), TURN), ((3000.0, -2000.0, 500.0), TURN)):
        share, hits = hits_at_proved_pairs(device, moved(furnished(rng), turn, shift), 0.4, 200_000)
        assert hits == 0
        assert share > 0.2
    share, hits = hits_at_proved_pairs(device, load_scene(OFFICE), 0.5, 500_000)
    assert hits == 0
    assert share > 0.1


@pytest.mark.parametrize("turn", [None, TURN], ids=["upright", "turned"])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (1000.0, 2000.0, 50.0)], ids=["at origin", "far off"])
def test_everything_is_proved_in_a_convex_room(device, turn, shift):
    """Elements that touch walls and the lamp included; those in the lamp's plane lie behind it."""
    b = cube()
    b.lamp(b.patch((0.4, 0.4, 1.0), (0, 0.2, 0), (0.2, 0, 0), 0), 1.0)
    b.rows[5] = ((0, 0, 1), (0, 1, 0), (0.4, 0, 0), False, 0, NONE)
    for origin, edge_u, edge_v in (
        ((0.6, 0, 1), (0, 1, 0), (0.4, 0, 0)),
        ((0.4, 0, 1), (0, 0.4, 0), (0.2, 0, 0)),
        ((0.4, 0.6, 1), (0, 0.4, 0), (0.2, 0, 0)),
    ):
        b.patch(origin, edge_u, edge_v, 0)
    scene = moved(b.scene(), turn, shift)
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    elements = build_elements(scene.patches, lit.space, np.ones(len(scene.materials), bool), 0.13)
    sight = row_sight(bvh, scene.patches, elements, EmitterShapes.of(scene), lit)[:, 0]
    side = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    below = side // 2 < 5
    assert (sight[below] == FREE).all()
    assert (sight[~below] == HIDDEN).all()


def floor_and_lamp(*obstacles, two_sided=False):
    b = SceneBuilder()
    paint = b.material(0.5)
    b.patch((-2, -2, 0), (4, 0, 0), (0, 4, 0), paint)
    b.lamp(b.patch((-0.5, -0.5, 2), (0, 1, 0), (1, 0, 0), paint), 1.0, two_sided=two_sided)
    for origin, edge_u, edge_v in obstacles:
        b.patch(origin, edge_u, edge_v, paint)
    return b.scene()


def at(device, scene, position, normal):
    bvh = build_bvh(device, scene.patches)
    position = np.atleast_2d(np.asarray(position, float))
    return point_sight(bvh, EmitterShapes.of(scene), position, np.broadcast_to(normal, position.shape))[:, 0]


def test_a_thin_wire_across_a_shaft_leaves_it_unknown(device):
    wire = ((-3.0, 0.1, 1.0), (6.0, 0.0, 0.0), (0.0, 1e-4, 0.0))
    beside = ((-3.0, 1.9, 1.0), (6.0, 0.0, 0.0), (0.0, 1e-4, 0.0))
    assert at(device, floor_and_lamp(wire), [0.3, 0.2, 0.0], UP) == UNKNOWN
    assert at(device, floor_and_lamp(beside), [0.3, 0.2, 0.0], UP) == FREE
    b = floor_and_lamp(wire)
    corners = np.array([[[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.0]]])
    receivers = Receivers(corners, UP[None], np.zeros(1, int))
    for scene, expected in ((b, UNKNOWN), (floor_and_lamp(beside), FREE)):
        bvh = build_bvh(device, scene.patches)
        assert prove_sight(bvh, receivers, EmitterShapes.of(scene), np.zeros(1, int), np.zeros(1, int)) == expected


def test_hidden_is_only_what_lies_behind(device):
    points = [[0.0, 0.0, 0.5], [0.0, 0.0, 3.0], [0.0, 0.0, 3.0], [3.0, 0.0, 2.0]]
    normals = [-UP, -UP, UP, -UP]
    one_sided, two_sided = (
        [at(device, floor_and_lamp(two_sided=both), p, n)[0] for p, n in zip(points, normals)] for both in (False, True)
    )
    assert one_sided == [HIDDEN, HIDDEN, HIDDEN, HIDDEN]
    assert two_sided == [HIDDEN, FREE, HIDDEN, HIDDEN]


def test_the_search_gives_up(device):
    rng = np.random.default_rng(1)
    n = 400
    edges = rng.normal(scale=0.01, size=(2, n, 3))
    around = rng.uniform(1.5, 1.9, (n, 3)) * [1, 1, 0.5]
    scene = floor_and_lamp(*zip(around, *edges))
    bvh = build_bvh(device, scene.patches)
    receivers, lamps, first = Receivers.points(np.zeros((1, 3)), UP[None]), EmitterShapes.of(scene), np.zeros(1, int)
    assert prove_sight(bvh, receivers, lamps, first, first, most_visits=1) == UNKNOWN
    assert prove_sight(bvh, receivers, lamps, first, first) == FREE
