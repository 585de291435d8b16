"""Triangles to patches, polygons to patches, closed shells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.meshing import Pieces, merge_triangles
from hradiosity.model.polygons import planarity_defect, polygon_to_patches
from hradiosity.model.solids import find_solids
from hradiosity.model.welding import weld

BOX_VERTICES = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
BOX_QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
seeds = st.integers(0, 2**32 - 1)


def box_triangles(rng):
    """Twelve triangles: each face cut along either diagonal, corners turned, rows shuffled."""
    quads = np.array([np.roll(quad, rng.integers(4)) for quad in BOX_QUADS])
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return rng.permutation(np.array([np.roll(t, rng.integers(3)) for t in triangles]))


def placed(vertices, rng):
    """Vertices turned at random and moved by up to 100 m along each axis."""
    return Rotation.random(rng=rng).apply(vertices) + rng.uniform(-100, 100, 3)


def as_patches(pieces: Pieces, objects=0):
    n = len(pieces.origin)
    zeros = np.zeros(n, dtype=np.int32)
    return Patches(*pieces[:4], zeros, zeros + np.int32(objects), pieces.surface, zeros)


def vector_areas(pieces: Pieces):
    return np.where(pieces.is_triangle, 0.5, 1.0)[:, None] * np.cross(pieces.edge_u, pieces.edge_v)


def shells(vertices, triangles, objects=None):
    """find_solids on unmerged triangles."""
    corners = vertices[triangles][:, [0, 1, 2, 2]]
    objects = np.zeros(len(triangles), dtype=np.int32) if objects is None else objects
    return find_solids(corners, np.ones(len(triangles), dtype=bool), objects)


@given(seed=seeds, size=st.tuples(*[st.floats(0.01, 10.0)] * 3))
@settings(max_examples=40, deadline=None)
def test_boxes_become_six_parallelograms(seed, size):
    rng = np.random.default_rng(seed)
    vertices, triangles = placed(BOX_VERTICES * size, rng), box_triangles(rng)
    pieces = merge_triangles(vertices, triangles)
    assert len(pieces.origin) == 6 and not pieces.is_triangle.any()
    assert len(np.unique(pieces.surface)) == 6
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    before = 0.5 * np.cross(b - a, c - a)
    after = vector_areas(pieces)
    total = np.linalg.norm(before, axis=1).sum()
    np.testing.assert_allclose(np.linalg.norm(after, axis=1).sum(), total, rtol=1e-9)
    for vector in after:
        assert np.linalg.norm(before * 2 - vector, axis=1).min() < 1e-9 * total


@given(seed=seeds)
@settings(max_examples=20, deadline=None)
def test_random_terrain_keeps_area_and_normals(seed):
    rng = np.random.default_rng(seed)
    n = 6
    xy = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1).reshape(-1, 2)
    vertices = np.column_stack([xy, rng.integers(0, 2, n * n)]).astype(float)
    i = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    triangles = rng.permutation(
        np.concatenate([np.stack([i, i + n, i + n + 1], axis=1), np.stack([i, i + n + 1, i + 1], axis=1)])
    )
    pieces = merge_triangles(placed(vertices, rng), triangles)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    cross = 0.5 * np.cross(b - a, c - a)
    np.testing.assert_allclose(as_patches(pieces).area.sum(), np.linalg.norm(cross, axis=1).sum(), rtol=1e-9)
    assert len(pieces.origin) == len(triangles) - (~pieces.is_triangle).sum()
    np.testing.assert_allclose(np.linalg.norm(vector_areas(pieces).sum(0)), np.linalg.norm(cross.sum(0)), rtol=1e-9)


def test_merging_does_not_depend_on_shared_vertices():
    triangles = box_triangles(np.random.default_rng(1))
    soup = BOX_VERTICES[triangles].reshape(-1, 3)
    pieces = merge_triangles(soup, np.arange(36).reshape(-1, 3))
    np.testing.assert_array_equal(pieces.origin, merge_triangles(BOX_VERTICES, triangles).origin)
    assert not pieces.is_triangle.any()


@pytest.mark.parametrize("seed", range(10))
def test_single_precision_boxes_still_merge_and_stay_solid(seed):
    rng = np.random.default_rng(seed)
    vertices = Rotation.random(rng=rng).apply(BOX_VERTICES * [4.0, 3.0, 0.05]) + np.array([11.0, 12.0, 13.0])
    vertices = vertices.astype(np.float32).astype(float)
    pieces = merge_triangles(vertices, box_triangles(rng))
    assert not pieces.is_triangle.any()
    patches = as_patches(pieces)
    assert (find_solids(patches.corners(), patches.is_triangle, patches.object).solid == 0).all()


@pytest.mark.parametrize("far_corner", [[1.0, 1.001, 0.0], [1.0, 1.0, 0.001]])
def test_what_is_not_a_parallelogram_stays_two_triangles(far_corner):
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], far_corner, [0.0, 1.0, 0.0]])
    pieces = merge_triangles(vertices, np.array([[0, 1, 2], [0, 2, 3]]))
    assert pieces.is_triangle.all() and len(pieces.origin) == 2


def test_faces_turned_against_each_other_are_not_joined():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    pieces = merge_triangles(vertices, np.array([[0, 1, 2], [0, 3, 2]]))
    assert pieces.is_triangle.all() and len(np.unique(pieces.surface)) == 2


def test_rectangles_are_preferred_and_a_flat_grid_is_one_surface():
    n = 60
    xy = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1).reshape(-1, 2)
    i = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    triangles = np.concatenate([np.stack([i, i + n, i + n + 1], axis=1), np.stack([i, i + n + 1, i + 1], axis=1)])
    pieces = merge_triangles(np.column_stack([xy, np.zeros(n * n)]).astype(float), triangles)
    assert len(pieces.origin) == (n - 1) ** 2
    np.testing.assert_allclose(np.einsum("ij,ij->i", pieces.edge_u, pieces.edge_v), 0.0, atol=1e-12)
    assert pieces.surface.max() == 0


def test_triangles_without_area_are_left_out_and_nothing_is_fine():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    assert len(merge_triangles(vertices, np.array([[0, 1, 2], [0, 0, 1]])).origin) == 0
    assert len(merge_triangles(np.empty((0, 3)), np.empty((0, 3), dtype=int)).origin) == 0
    with pytest.raises(ValueError, match="up to 3"):
        merge_triangles(vertices, np.array([[0, 1, 3]]))


def test_points_across_a_cell_boundary_are_welded():
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 0, 0], [0.5 + 4e-8, 0, 0], [0.5 + 1e-6, 0, 0]])
    number = weld(points, 1e-7)
    assert number[2] == number[3] and len(np.unique(number)) == 4


L_SHAPE = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
ARROW = [[0, 0], [2, 1], [0, 2], [0.5, 1]]
KEYHOLE = [[0, 0], [3, 0], [3, 3], [0, 3], [0, 0.5], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1], [0, 0.5]]


@pytest.mark.parametrize(
    ("outline", "area", "count"),
    [
        ([[0, 0], [1, 0], [0, 1]], 0.5, 1),
        ([[0, 0], [2, 0], [3, 1], [1, 1]], 2.0, 1),
        ([[0, 0], [2, 0], [2, 1], [0, 2]], 3.0, 2),
        (ARROW, 1.5, 2),
        (L_SHAPE, 3.0, 4),
        (KEYHOLE, 8.0, 9),
        ([[0, 0], [0.5, 0], [1, 0], [1, 1], [0, 1]], 1.0, 3),
    ],
)
def test_polygons(outline, area, count):
    """Pieces tile the polygon: right area, normals alike, and every piece's centre lies inside."""
    rng = np.random.default_rng(3)
    turn = Rotation.random(rng=rng)
    vertices = turn.apply(np.column_stack([outline, np.zeros(len(outline))])) + 5.0
    pieces = polygon_to_patches(vertices)
    assert len(pieces.origin) == count and pieces.surface.max() == 0
    along = vector_areas(pieces) @ turn.apply([0.0, 0.0, 1.0])
    assert (along > 0).all()
    np.testing.assert_allclose(along.sum(), area, rtol=1e-12)
    assert planarity_defect(vertices) < 1e-12
    centres = turn.inv().apply(as_patches(pieces).centroid - 5.0)[:, :2]
    assert all(winding_number(centre, np.array(outline, dtype=float)) == 1 for centre in centres)


def winding_number(point, outline):
    spoke = outline - point
    following = np.roll(spoke, -1, axis=0)
    turn = np.arctan2(spoke[:, 0] * following[:, 1] - spoke[:, 1] * following[:, 0], (spoke * following).sum(1))
    return round(turn.sum() / (2 * np.pi))


@given(seed=seeds, n=st.integers(4, 40))
@settings(max_examples=40, deadline=None)
def test_star_shaped_polygons_are_tiled(seed, n):
    rng = np.random.default_rng(seed)
    angle = (np.arange(n) + rng.uniform(0.1, 0.9, n)) * 2 * np.pi / n
    radius = rng.uniform(0.3, 3.0, n)
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    following = np.roll(flat, -1, axis=0)
    area = 0.5 * (flat[:, 0] * following[:, 1] - flat[:, 1] * following[:, 0]).sum()
    pieces = polygon_to_patches(np.column_stack([flat, np.zeros(n)]))
    z = vector_areas(pieces)[:, 2]
    assert (z > 0).all()
    np.testing.assert_allclose(z.sum(), area, rtol=1e-9)


def test_bent_quad_is_split_along_the_shorter_diagonal_and_says_so():
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [1.5, 1, 0.1], [0, 1, 0]])
    assert planarity_defect(vertices) > 1e-3
    pieces = polygon_to_patches(vertices)
    assert pieces.is_triangle.all() and len(pieces.origin) == 2
    corners = as_patches(pieces).corners()[:, :3]
    shared = set(map(tuple, corners[0])) & set(map(tuple, corners[1]))
    assert shared == {(0.0, 0.0, 0.0), (1.5, 1.0, 0.1)}


@pytest.mark.parametrize(
    ("outline", "message"),
    [
        ([[0, 0], [1, 0]], "at least three"),
        ([[0, 0], [1, 0], [2, 0]], "no area"),
        ([[0, 0], [1, 0], [1, 0], [1, 1]], "corner 1 .* coincides"),
        ([[0, 0], [2, 2], [2, 0], [0, 1]], "cross"),
    ],
)
def test_unusable_polygons_are_refused(outline, message):
    with pytest.raises(ValueError, match=message):
        polygon_to_patches(np.column_stack([np.array(outline, dtype=float), np.zeros(len(outline))]))


@given(seed=seeds, size=st.tuples(*[st.floats(0.01, 10.0)] * 3))
@settings(max_examples=30, deadline=None)
def test_box_is_solid_merged_or_not_and_inside_out_it_is_inward(seed, size):
    rng = np.random.default_rng(seed)
    vertices, triangles = placed(BOX_VERTICES * size, rng), box_triangles(rng)
    patches = as_patches(merge_triangles(vertices, triangles))
    merged = find_solids(patches.corners(), patches.is_triangle, patches.object)
    for found in (merged, shells(vertices, triangles)):
        assert (found.solid == 0).all() and (found.inward == NONE).all()
    found = shells(vertices, triangles[:, ::-1])
    assert (found.solid == NONE).all() and (found.inward == 0).all()
    found = shells(vertices, np.delete(triangles, rng.integers(12), axis=0))
    assert (found.solid == NONE).all() and (found.inward == NONE).all()
    one_turned = triangles.copy()
    one_turned[0] = one_turned[0, ::-1]
    assert (shells(vertices, one_turned).solid == NONE).all()


@pytest.mark.parametrize("offset", [[1, 0, 0], [1, 1, 0], [1, 1, 1], [3, 0, 0]])
@pytest.mark.parametrize("seed", range(3))
def test_touching_boxes_are_two_solids(offset, seed):
    """A common face, edge or corner does not join them, whether they are one object or two."""
    rng = np.random.default_rng(seed)
    vertices = placed(np.concatenate([BOX_VERTICES, BOX_VERTICES + offset]), rng)
    triangles = np.concatenate([box_triangles(rng), box_triangles(rng) + 8])
    body = np.repeat([0, 1], 12)
    order = rng.permutation(24)
    for objects in (np.zeros(24, dtype=int), body):
        found = shells(vertices, triangles[order], objects[order])
        assert len(np.unique(found.solid[body[order] == 0])) == 1 and len(np.unique(found.solid[body[order] == 1])) == 1
        assert set(found.solid) == {0, 1}


def test_one_shell_split_over_two_objects_is_no_solid():
    triangles = box_triangles(np.random.default_rng(0))
    assert (shells(BOX_VERTICES, triangles, np.repeat([0, 1], 6)).solid == NONE).all()


def test_sheet_modelled_twice_and_flap_are_no_solids():
    sheet = np.array([[0, 1, 3], [0, 3, 2]])
    found = shells(BOX_VERTICES, np.concatenate([sheet, sheet[:, ::-1]]))
    assert (found.solid == NONE).all() and (found.inward == NONE).all()
    flap = np.concatenate([box_triangles(np.random.default_rng(0)), [[0, 1, 8]]])
    assert (shells(np.concatenate([BOX_VERTICES, [[-1.0, 0, 0]]]), flap).solid == NONE).all()


def test_hollow_box_is_a_solid_with_an_inward_cavity():
    rng = np.random.default_rng(4)
    vertices = np.concatenate([BOX_VERTICES, 0.25 + 0.5 * BOX_VERTICES])
    triangles = np.concatenate([box_triangles(rng), box_triangles(rng)[:, ::-1] + 8])
    found = shells(vertices, triangles)
    np.testing.assert_array_equal(found.solid, np.repeat([0, NONE], 12))
    np.testing.assert_array_equal(found.inward, np.repeat([NONE, 0], 12))
