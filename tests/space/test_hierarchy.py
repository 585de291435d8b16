"""Row elements: the cells tile the lit sides, groups join what belongs together, points and cells agree."""

import numpy as np
import pytest
from device_call import device_call
from hypothesis import given, settings
from hypothesis import strategies as st
from ray_scenes import make_patches, random_patches

from hradiosity.space.hierarchy import NONE, build_elements

TWO_SIDED = np.array([True])


def cut(patches, size, lit=None, space=None, two_sided=TWO_SIDED, **options):
    lit = np.ones((len(patches), 2), bool) if lit is None else lit
    space = np.where(lit, 0, -1).astype(np.int32) if space is None else space
    return build_elements(patches, space, two_sided, size, **options)


def check_invariants(patches, elements, lit):
    """What must hold for any elements: each cell in one row, areas, shares, materials."""
    n_cells, n_rows = len(elements.cell_row), len(elements)
    assert sorted(elements.row_cell) == list(range(n_cells))
    assert elements.row_start[0] == 0 and elements.row_start[-1] == n_cells
    assert (np.diff(elements.row_start.astype(int)) > 0).all()
    of_row = np.repeat(np.arange(n_rows), np.diff(elements.row_start.astype(int)))
    np.testing.assert_array_equal(elements.cell_row[elements.row_cell], of_row)
    np.testing.assert_allclose(elements.area.sum(), (patches.area[:, None] * lit).sum(), rtol=1e-12)
    count = np.bincount(elements.cell_side, minlength=2 * len(patches)).reshape(-1, 2)
    per_patch = np.where(patches.is_triangle, elements.divisions[:, 0] ** 2, elements.divisions.prod(axis=1))
    np.testing.assert_array_equal(count, per_patch[:, None] * lit)
    assert ((elements.first_cell == NONE) == ~lit).all()
    cell_area = (patches.area / per_patch)[elements.cell_side // 2]
    np.testing.assert_allclose(elements.area, np.bincount(elements.cell_row, cell_area, n_rows), rtol=1e-12)
    share = np.diff(np.concatenate([[0.0], elements.row_share]))
    share[elements.row_start[:-1]] = elements.row_share[elements.row_start[:-1]]
    with np.errstate(invalid="ignore"):
        wanted = cell_area[elements.row_cell] / elements.area[of_row]
    np.testing.assert_allclose(share[wanted > 0], wanted[wanted > 0], atol=2e-7)
    assert (elements.row_share[elements.row_start[1:] - 1] == 1).all()
    material = elements.side_material.ravel()[elements.cell_side]
    np.testing.assert_array_equal(material, elements.row_material[elements.cell_row])
    assert np.isin(elements.divisions, [1, *range(2, 10000, 2)]).all()


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 60), size=st.floats(0.03, 3.0), grouping=st.booleans())
def test_cells_tile_the_lit_sides(seed, n, size, grouping):
    rng = np.random.default_rng(seed)
    patches = random_patches(rng, n)
    lit = rng.random((n, 2)) < 0.7
    check_invariants(patches, cut(patches, size, lit, grouping=grouping), lit)


def test_divisions_come_near_the_wanted_size():
    """Cut patches have cells of 2/3 to 4/3 of the size along each edge that is cut."""
    patches = random_patches(np.random.default_rng(1), 500, size=2.0)
    elements = cut(patches, 0.3)
    edges = np.stack([np.linalg.norm(e, axis=1) for e in (patches.edge_u, patches.edge_v)], axis=1)
    edge = (edges / elements.divisions)[~patches.is_triangle]
    long = (edges[~patches.is_triangle] > 1.25 * 0.3) & (elements.divisions[~patches.is_triangle] > 1)
    assert edge[long].max() < 0.3 * 1.6 and edge[long].min() > 0.3 * 0.6


def test_groups_join_only_what_belongs_together():
    """One material, one side, one space; normals within 60°; all inside one cube of the element's size."""
    rng = np.random.default_rng(2)
    n = 3000
    patches = random_patches(rng, n, size=0.01)
    patches.material[:] = rng.integers(0, 3, n)
    space = rng.integers(-1, 2, (n, 2)).astype(np.int32)
    elements = cut(patches, 1.0, space=space, two_sided=np.array([True, True, False]))
    assert len(elements) < 0.7 * len(elements.cell_row)
    check_invariants(patches, elements, space >= 0)
    side = elements.cell_side
    normal = patches.normal[side // 2] * np.where(side % 2 == 0, 1, -1)[:, None]
    for row in range(len(elements)):
        cells = elements.row_cell[elements.row_start[row] : elements.row_start[row + 1]]
        assert len(np.unique(space.ravel()[side[cells]])) == 1
        assert (normal[cells] @ normal[cells].T).min() > 0.5
        assert np.ptp(patches.centroid[side[cells] // 2], axis=0).max() <= 1.0


def test_black_backs_are_a_material_of_their_own():
    patches = make_patches([[0, 0, 0]], [[1, 0, 0]], [[0, 1, 0]], False)
    elements = cut(patches, 2.0, two_sided=np.array([False]))
    assert elements.side_material.tolist() == [[0, 1]]
    assert sorted(elements.row_material) == [0, 1]


@pytest.mark.filterwarnings("error")
def test_no_patches_no_light_and_no_area():
    assert len(cut(random_patches(np.random.default_rng(0), 0), 0.1)) == 0
    patches = make_patches([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[1, 0, 0]] * 3, [[2, 0, 0], [0, 1, 0], [0, 0, 0]], False)
    assert len(cut(patches, 0.3, np.zeros((3, 2), bool))) == 0
    for size in (0.3, 30.0):
        elements = cut(patches, size)
        assert np.isfinite(elements.row_share).all()
        check_invariants(patches, elements, np.ones((3, 2), bool))


CELL_AT = "hr_cell_at(0, 0, u, v, in_divisions, in_first, in_kind)"
CELL_POINT = "hr_cell_point(cell, s, t, in_divisions, in_first, in_side, in_kind)"


def tables(n, divisions, triangle):
    """Arrays for one patch with its front lit, padded to the n rows that the helper wants."""

    def padded(values):
        return np.resize(np.array(values, np.uint32), n)

    count = divisions[0] ** 2 if triangle else divisions[0] * divisions[1]
    return count, {
        "divisions": padded(divisions),
        "first": np.concatenate([[0, NONE], np.zeros(max(n - 2, 0))]).astype(np.uint32)[:n],
        "kind": padded([triangle]),
        "side": np.zeros(n, np.uint32),
    }


@pytest.mark.parametrize(
    ("divisions", "triangle"),
    [((k, k), 1) for k in (1, 2, 6, 14, 64)] + [((1, 1), 0), ((2, 6), 0), ((64, 1), 0), ((10, 64), 0)],
)
def test_a_point_of_a_cell_lies_in_that_cell(device, divisions, triangle):
    """Also at the borders of the unit square, within rounding: 1 in 10⁴ may fall into the neighbour."""
    rng = np.random.default_rng(3)
    n = 20000
    count, arrays = tables(n, divisions, triangle)
    cell = rng.integers(0, count, n).astype(np.uint32)
    s, t = rng.random((2, n)).astype(np.float32)
    uv = device_call(device, "hr_elements.h", CELL_POINT, "float2", cell=cell, s=s, t=t, **arrays)
    u, v = uv[:, 0].copy(), uv[:, 1].copy()
    assert (uv >= 0).all() and ((uv.sum(axis=1) <= 1 + 1e-6) if triangle else (uv <= 1)).all()
    found = device_call(device, "hr_elements.h", CELL_AT, "uint", u=u, v=v, **arrays)
    assert np.count_nonzero(found != cell) <= n // 1000
    edge = np.array([0.0, 1.0], np.float32)
    corners = np.array([(a, b) for a in edge for b in edge if not triangle or a + b <= 1], np.float32)
    along = rng.random(5000).astype(np.float32)
    hypotenuse = np.stack([along, 1 - along], axis=1) if triangle else np.stack([along, np.ones_like(along)], axis=1)
    points = np.resize(np.concatenate([corners, hypotenuse]), (n, 2))
    at_edge = device_call(
        device, "hr_elements.h", CELL_AT, "uint", u=points[:, 0].copy(), v=points[:, 1].copy(), **arrays
    )
    assert (at_edge < count).all()


@pytest.mark.parametrize(("divisions", "triangle"), [((6, 6), 1), ((4, 10), 0)])
def test_cells_have_equal_shares_of_the_patch(device, divisions, triangle):
    """A fine grid over the patch, counted by cell; and the cells' own points average to the patch's centroid."""
    m = 600
    grid = ((np.arange(m) + 0.5) / m).astype(np.float32)
    u, v = (g.ravel() for g in np.meshgrid(grid, grid))
    if triangle:
        u, v = u[u + v < 1], v[u + v < 1]
    count, arrays = tables(len(u), divisions, triangle)
    found = device_call(device, "hr_elements.h", CELL_AT, "uint", u=u.copy(), v=v.copy(), **arrays)
    counted = np.bincount(found, minlength=count)
    assert len(counted) == count
    np.testing.assert_allclose(counted, len(u) / count, rtol=0.05)
    count, arrays = tables(count, divisions, triangle)
    arrays |= {"cell": np.arange(count, dtype=np.uint32), "s": np.full(count, 0.5, np.float32)}
    uv = device_call(device, "hr_elements.h", CELL_POINT, "float2", t=arrays["s"], **arrays)
    assert len(np.unique(uv.round(5), axis=0)) == count


def test_places_on_a_group_are_spread_by_area(device):
    """A row of three patches with areas 1 : 2 : 5, tried on a fine grid of the unit square."""
    widths = np.array([1.0, 2.0, 5.0]) * 1e-3
    patches = make_patches(
        [[0, 0.01 * k, 0] for k in range(3)], [[w, 0, 0] for w in widths], [[0, 1e-3, 0]] * 3, [False] * 3
    )
    elements = cut(patches, 1.0, np.array([[True, False]] * 3))
    assert len(elements) == 1
    m = 400
    n = m * m
    grid = ((np.arange(m) + 0.5) / m).astype(np.float32)
    s, t = (g.ravel().copy() for g in np.meshgrid(grid, grid))
    arrays = {
        "divisions": elements.divisions,
        "first": elements.first_cell,
        "cell_row": elements.cell_row,
        "cell_side": elements.cell_side,
        "row_start": elements.row_start,
        "row_cell": elements.row_cell,
        "row_share": elements.row_share,
        "origin": patches.origin.astype(np.float32),
        "edge_u": patches.edge_u.astype(np.float32),
        "edge_v": patches.edge_v.astype(np.float32),
        "normal": patches.normal.astype(np.float32),
        "kind": patches.is_triangle.astype(np.uint32),
    }
    padded = {name: np.resize(array.ravel(), n) for name, array in arrays.items()}
    call = "hr_place_on_row(0, s, t, " + ", ".join(f"in_{name}" for name in arrays) + ").position"
    position = device_call(device, "hr_elements.h", call, "float3", s=s, t=t, **padded)
    patch = np.rint(position[:, 1] / 0.01 - 0.05).astype(int)
    np.testing.assert_allclose(np.bincount(patch) / n, widths / widths.sum(), atol=2 / m)
    for k in range(3):
        assert position[patch == k, 0].mean() == pytest.approx(widths[k] / 2, rel=0.01)
