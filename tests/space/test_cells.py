"""Cells in space tile their patches, and face the side that they lie on."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hradiosity.model.geometry import Patches
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import build_elements

ORIGIN = np.array([[0.0, 0.0, 0.0], [3.0, 1.0, 2.0]])
EDGE_U = np.array([[2.0, 0.0, 0.5], [0.0, 1.5, 0.0]])
EDGE_V = np.array([[0.3, 1.0, 0.0], [-0.4, 0.0, 1.0]])
NONE = np.full(2, -1, np.int32)
ZERO = np.zeros(2, np.int32)
PATCHES = Patches(ORIGIN, EDGE_U, EDGE_V, np.array([False, True]), ZERO, ZERO, NONE, NONE)


def elements(size):
    return build_elements(PATCHES, np.zeros((2, 2), np.int32), np.array([True]), size, grouping=False)


def areas(corners):
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return 0.5 * np.cross(first, second)  # of a quadrilateral, and of a triangle that repeats its last corner


@settings(max_examples=30, deadline=None)
@given(st.floats(0.08, 3.0))
def test_cells_tile_both_sides_and_face_outwards(size):
    cut = elements(size)
    corners, is_triangle = cell_corners(PATCHES, cut)
    vector = areas(corners)
    for side in range(4):
        on_side = cut.cell_side == side
        assert np.all(is_triangle[on_side] == PATCHES.is_triangle[side // 2])
        normal = PATCHES.normal[side // 2] * (1 if side % 2 == 0 else -1)
        along = np.einsum("cx,x->c", vector[on_side], normal)
        assert np.allclose(along, PATCHES.area[side // 2] / on_side.sum())


@settings(max_examples=30, deadline=None)
@given(st.floats(0.08, 3.0))
def test_the_middle_of_a_cell_lies_in_it(size):
    cut = elements(size)
    corners, is_triangle = cell_corners(PATCHES, cut)
    middle = np.where(is_triangle[:, None], corners[:, :3].mean(axis=1), corners.mean(axis=1))
    patch = cut.cell_side.astype(np.int64) // 2
    edges = np.stack([PATCHES.edge_u[patch], PATCHES.edge_v[patch]], axis=2)
    uv = np.stack([np.linalg.lstsq(e, m, rcond=None)[0] for e, m in zip(edges, middle - PATCHES.origin[patch])])
    found, _, _ = locate_cells(cut, PATCHES.is_triangle, cut.cell_side.astype(np.int64), uv[:, 0], uv[:, 1])
    assert np.array_equal(found, np.arange(len(corners)))
