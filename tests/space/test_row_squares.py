"""Rows split in four: areas, places, parents, and the quarters alone, on parallelograms and triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import SceneBuilder

from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.companion import coarser_rows
from hradiosity.space.hierarchy import build_elements, side_materials
from hradiosity.space.row_squares import cells_after, quarters_of, row_squares, split_rows

TWO_SIDED = np.array([True])


def plates(triangle, sides=1):
    """A plate of 2 × 1 m that is cut at h = 0.25 m, and one of 0.3 m that is not."""
    room = SceneBuilder()
    room.material(0.5)
    room.patch((0, 0, 0), (2, 0, 0), (0, 1, 0), 0, triangle=triangle)
    room.patch((5, 0, 0), (0.3, 0, 0), (0, 0.3, 0), 0, triangle=triangle)
    patches = room.scene().patches
    space = np.array([[0, 0 if sides == 2 else -1]] * 2, np.int32)
    return patches, build_elements(patches, space, TWO_SIDED, 0.25)


def rows_at(patches, elements, side, uv):
    cell, _, _ = locate_cells(elements, patches.is_triangle, side, *uv.T)
    return elements.cell_row[cell].astype(np.int64)


def places(triangle, n, seed=0):
    uv = np.random.default_rng(seed).random((n, 2))
    fold = triangle & (uv.sum(axis=1) > 1)
    uv[fold] = 1 - uv[fold]
    return uv


@pytest.mark.parametrize("triangle", [False, True])
@given(seed=st.integers(0, 2**32 - 1), rounds=st.integers(1, 3))
@settings(max_examples=20, deadline=None)
def test_splitting_keeps_places_and_areas(triangle, seed, rounds):
    """Points of one old row lie in that row or in its four quarters, each a quarter of its area."""
    rng = np.random.default_rng(seed)
    patches, elements = plates(triangle, sides=2)
    total = elements.area.sum()
    side = np.repeat([0, 1, 2, 3], 500)
    uv = places(np.repeat(patches.is_triangle[[0, 0, 1, 1]], 500), len(side), seed)
    for _ in range(rounds):
        chosen = np.flatnonzero(rng.random(len(elements)) < 0.3)
        made = split_rows(patches, elements, chosen)
        assert len(made) == len(elements) + 3 * len(chosen)
        assert len(made.cell_row) == cells_after(patches, elements, chosen)
        assert made.area.sum() == pytest.approx(total, rel=1e-12)
        old, new = rows_at(patches, elements, side, uv), rows_at(patches, made, side, uv)
        pairs = np.unique(np.column_stack([new, old]), axis=0)
        assert (np.bincount(pairs[:, 0]) <= 1).all()
        split = np.isin(pairs[:, 1], chosen)
        np.testing.assert_allclose(made.area[pairs[:, 0]], elements.area[pairs[:, 1]] * np.where(split, 0.25, 1.0))
        elements = made


@pytest.mark.parametrize("triangle", [False, True])
def test_rows_are_where_their_squares_say(triangle):
    patches, elements = plates(triangle)
    for chosen in ([0, 5], [2, 7, len(elements)]):
        elements = split_rows(patches, elements, np.array(chosen))
    squares = row_squares(patches, elements)
    assert squares.single.all()
    edge = np.linalg.norm(np.cross(patches.edge_u, patches.edge_v), axis=1)[squares.side // 2]
    np.testing.assert_allclose(edge * (0.5 if triangle else 1.0) / squares.grid.prod(axis=1), elements.area, rtol=1e-6)
    middle = squares.middles(patches)
    patch = squares.side // 2
    lengths = np.stack([patches.edge_u[patch, 0], patches.edge_v[patch, 1]], axis=1)
    uv = (middle[:, :2] - patches.origin[patch, :2]) / lengths
    np.testing.assert_array_equal(rows_at(patches, elements, squares.side, uv), np.arange(len(elements)))


@pytest.mark.parametrize("triangle", [False, True])
def test_quarters_merge_into_what_was_split(triangle):
    patches, elements = plates(triangle)
    paint = side_materials(patches, TWO_SIDED)
    space = np.zeros(len(elements), np.int32)
    before = np.bincount(coarser_rows(patches, elements, space, paint, 0.25), elements.area)
    made = split_rows(patches, elements, np.array([3]))
    parent = coarser_rows(patches, made, np.zeros(len(made), np.int32), paint, 0.25)
    area = np.bincount(parent, made.area)
    assert (np.bincount(parent) <= 4).all() and len(area) == len(before) + 1
    whole = np.flatnonzero(np.bincount(parent, made.area < 0.9 * elements.area[3]) == 4)
    assert np.isclose(area[whole], elements.area[3], rtol=1e-9).sum() == 1
    assert area.sum() == pytest.approx(before.sum(), rel=1e-12)


@pytest.mark.parametrize("triangle", [False, True])
def test_quarters_alone(triangle):
    patches, elements = plates(triangle)
    chosen = np.array([1, 4, len(elements) - 1])
    quarters, parent = quarters_of(patches, elements, chosen)
    np.testing.assert_array_equal(parent, np.repeat(chosen, 4))
    np.testing.assert_allclose(quarters.area, elements.area[parent] / 4)
    side = np.zeros(200, np.int64)
    uv = places(np.full(200, triangle), 200)
    np.testing.assert_array_equal(rows_at(patches, quarters, side, uv), rows_at(patches, elements, side, uv))
    own = quarters.row_cell[quarters.row_start[:-1]]
    np.testing.assert_array_equal(quarters.cell_row[own], parent)
    assert quarters.row_start[-1] == len(quarters.row_cell) == len(quarters.row_share)


def test_groups_of_faces_stay_whole():
    room = SceneBuilder()
    room.material(0.5)
    for k in range(3):
        room.patch((0.02 + 0.05 * k, 0.02, 0), (0.01, 0, 0), (0, 0.01, 0), 0)
    patches = room.scene().patches
    elements = build_elements(patches, np.array([[0, -1]] * 3, np.int32), TWO_SIDED, 0.5)
    assert len(elements) == 1 and not row_squares(patches, elements).single.any()
    assert len(split_rows(patches, elements, np.array([0]))) == 1
