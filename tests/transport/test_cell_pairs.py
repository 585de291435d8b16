"""Exchange by the form factors of all pairs of cells, and by hemicubes over the elements."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, cube
from scipy.sparse import csr_array

from hradiosity.errors import SceneError
from hradiosity.radiosity.paired_surfaces import pooled_factors, random_cells
from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles, polygon_pair
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import MISS, SKY, build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.cell_pairs import METHOD_SETTINGS, CellPairs, check_pairs, symmetric
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import RowHits, trace_rows
from hradiosity.transport.facing import FacingCells
from hradiosity.transport.outside import outside_areas
from hradiosity.transport.pair_sight import open_share

OPPOSITE, ADJACENT = 0.19982489569838746, 0.20004377607540315
ERRORS = {
    "auto": 1e-3,
    "contour": 1e-6,
    "hemisphere": 2e-3,
    "quasi-hemisphere": 0.01,
    "monte-carlo": 0.3,
    "point": 0.25,
    "point-disk": 0.25,
}
"""Of the sums over cells a quarter of an edge wide; random points and centres do badly for cells with a common edge."""


class Prepared:
    """A scene cut into elements, on the device."""

    def __init__(self, device, scene, size):
        self.scene = scene
        self.bvh = build_bvh(device, scene.patches)
        self.lit = find_lit_sides(scene, self.bvh)
        two_sided = np.array([m.two_sided for m in scene.materials])
        self.elements = build_elements(scene.patches, self.lit.space, two_sided, size)
        first = self.elements.row_cell[self.elements.row_start[:-1]]
        self.side = self.elements.cell_side[first]
        self.space = self.lit.space.ravel()[self.side]
        self.on_device = upload_scene(device, scene, self.bvh, occlusion=True)
        self.uploaded = upload_elements(device, self.elements)
        self.cells = CellPairs(self.bvh, scene.patches, self.elements, self.space)

    def pairs(self, method="contour", proved=None):
        proved = np.zeros(len(self.cells), bool) if proved is None else proved
        return self.cells.by_rows(method, 1, proved)

    def opened(self, pairs, rays=64, seed=3):
        hits = trace_rows(self.on_device, self.uploaded, rays, seed)
        return open_share(self.on_device, self.uploaded, hits, pairs, seed)

    def dense(self, pairs, exchange=None):
        return symmetric(pairs, pairs.exchange if exchange is None else exchange, len(self.elements)).toarray()

    def between(self, matrix, one, other):
        """Sum over the elements on two sides."""
        return matrix[np.ix_(self.side == one, self.side == other)].sum()


def lamp_cube(side=1.0):
    b = cube(0.5, side=side)
    b.point((side / 2, side / 2, side / 2), 1.0)
    return b


@pytest.mark.parametrize("method", METHOD_SETTINGS)
def test_faces_of_a_cube(device, method):
    room = Prepared(device, lamp_cube().scene(), 0.25)
    pairs = room.pairs(method)
    k, stated = room.dense(pairs), room.dense(pairs, pairs.error)
    np.testing.assert_array_equal(k, k.T)
    front = 2 * np.arange(6)
    for i in front:
        for j in front:
            exact = 0.0 if i == j else OPPOSITE if i // 4 == j // 4 else ADJACENT
            found = room.between(k, i, j)
            assert found == pytest.approx(exact, rel=ERRORS[method], abs=1e-15)
            assert abs(found - exact) <= room.between(stated, i, j) + 1e-12


def test_contour_closes_rows_of_a_cube_by_itself(device):
    room = Prepared(device, lamp_cube().scene(), 0.2)
    pairs = room.pairs()
    np.testing.assert_allclose(room.dense(pairs).sum(axis=1), room.elements.area, rtol=2e-6)
    assert (pairs.error < 1e-5 * pairs.exchange.max()).all()
    assert room.cells.prove(np.inf).all()


def plates(with_card):
    """Two unit plates one above the other, a card of 0.1 m halfway between them, and a lamp beside."""
    b = SceneBuilder(1)
    grey = b.material(0.5)
    b.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), grey)
    b.patch((0, 0, 1), (0, 1, 0), (1, 0, 0), grey)
    if with_card:
        b.patch((0.45, 0.45, 0.5), (0.1, 0, 0), (0, 0.1, 0), grey)
    b.point((-0.5, 0.4, 0.3), 1.0)
    b.point((0.5, 0.5, 0.75), 1.0)
    return b.scene()


def test_a_card_takes_its_share(device):
    """The card of 0.1 m leaves 0.194 of 0.1998 (`form_factor` with occluders says 0.19453 within 5e-5)."""
    from hradiosity import form_factor

    free = Prepared(device, plates(False), 0.25)
    assert free.between(free.dense(free.pairs()), 0, 2) == pytest.approx(OPPOSITE, rel=1e-6)
    room = Prepared(device, plates(True), 0.25)
    corners = room.scene.patches.corners()
    known = form_factor(
        corners[0], corners[1], occluders=corners[2:], method="contour", visibility_tolerance=1e-4, device=device
    )
    pairs = room.pairs("contour", room.cells.prove(np.inf))
    found, errors = [], []
    for seed in range(8):
        share, error, rays = room.opened(pairs, 64, seed)
        assert rays > 0 and (share[pairs.proved] == 1.0).all() and not error[pairs.proved].any()
        found.append(room.between(room.dense(pairs, share * pairs.exchange), 0, 2))
        errors.append(np.sqrt(((error * pairs.exchange) ** 2).sum()))
    spread = np.std(found, ddof=1)
    assert abs(np.mean(found) - known.value) < 4.0 * spread / np.sqrt(8) + known.error
    assert 0.0 < spread < 2.0 * np.mean(errors)
    assert np.mean(found) == pytest.approx(0.1945, rel=3e-3)


def test_only_elements_of_one_space_exchange_light(device):
    b = SceneBuilder(1)
    grey = b.material(0.5)
    for x in (0.0, 1.0):
        b.box((x, 0, 0), (x + 1, 1, 1), grey, inward=True)
        b.point((x + 0.5, 0.5, 0.5), 1.0)
    room = Prepared(device, b.scene(), 0.5)
    assert len(np.unique(room.space)) == 2
    k = room.dense(room.pairs())
    assert not k[np.ix_(room.space == room.space[0], room.space != room.space[0])].any()


def valley():
    """Two squares that meet in a crease, like enough in direction to become one element, and a lamp above."""
    b = SceneBuilder(1)
    grey = b.material(0.5)
    steep, slight = np.radians(40.0), np.radians(16.0)
    left = 0.3 * np.array([-np.cos(steep), 0.0, np.sin(steep)])
    right = 0.3 * np.array([np.cos(slight), 0.0, -np.sin(slight)])
    b.patch(left, -left, (0, 0.3, 0), grey)
    b.patch((0, 0, 0), right, (0, 0.3, 0), grey)
    b.point((0.1, 0.1, 1.0), 1.0)
    return b.scene()


def test_a_group_sees_itself_in_both_directions(device):
    room = Prepared(device, valley(), 2.0)
    assert len(room.elements) == 1
    pairs = room.pairs()
    one, other = room.scene.patches.corners()
    assert pairs.n_cell_pairs == 1
    assert room.dense(pairs)[0, 0] == pytest.approx(2 * 0.09 * polygon_pair(one, other), rel=1e-5)
    share, _, _ = room.opened(pairs)
    assert share[0] == 1.0


def test_what_solids_cover_sees_nothing(device):
    """A chest stands in a corner: floor and walls behind it would see each other inside it."""
    b = lamp_cube()
    b.box((0, 0, 0), (0.5, 0.5, 0.5), 0, solid=True)
    room = Prepared(device, b.scene(), 0.25)
    pairs = room.pairs("contour", room.cells.prove(np.inf))
    hits = trace_rows(room.on_device, room.uploaded, 64, 3)
    covered = (hits.row == 0xFFFFFFFD).mean(axis=1)
    share, _, _ = room.opened(pairs)
    hidden = np.flatnonzero(covered == 1.0)
    assert len(hidden) == 12
    behind = np.isin(pairs.first, hidden) | np.isin(pairs.second, hidden)
    assert behind.any() and not share[behind].any()
    received = room.dense(pairs, share * pairs.exchange).sum(axis=1)
    bare = covered == 0.0
    np.testing.assert_allclose(received[bare], room.elements.area[bare], rtol=0.1)


def test_too_many_pairs_are_refused():
    check_pairs(20_000_000, 8000, "contour")
    with pytest.raises(SceneError, match=r"--elements \d+") as caught:
        check_pairs(64_000_000, 12000, "contour")
    message = str(caught.value)
    assert "64 million pairs" in message and "12000 elements" in message and "bytes" in message


def test_pairs_that_face_each_other():
    """As told apart one by one, whatever the block; those of another space never do."""
    rng = np.random.default_rng(23)
    corners = rng.random((60, 3, 3))[:, [0, 1, 2, 2]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    space = rng.integers(0, 2, 60)
    height = np.einsum("md,mnkd->mnk", normal, corners[None] - corners[:, None, :1]).max(axis=2)
    sees = (height > 1e-9) & (space[:, None] == space)
    expected = np.argwhere(np.triu(sees & sees.T, k=1))
    facing = FacingCells(corners, normal, space, 1e-9)
    np.testing.assert_array_equal(np.column_stack(facing.pairs()), expected)
    assert facing.count() == len(expected) > 300


def test_outside_is_what_is_left_of_exact_factors_and_what_rays_say_of_poor_ones():
    """Four elements of an area of 1 whose rays leave in 3 of 8 cases, 2 of them upwards; the last is in a closed
    room."""
    b = SceneBuilder(1)
    grey = b.material(0.5)
    for k in range(4):
        b.patch((0, 0, k), (1, 0, 0), (0, 1, 0), grey)
    space = np.tile(np.array([[0, -1]], np.int32), (4, 1))
    elements = build_elements(b.scene().patches, space, np.array([True]), 100.0, grouping=False)
    row = np.zeros((4, 8), np.uint32)
    row[:3, :2], row[:3, 2] = SKY, MISS
    hits = RowHits(row, np.zeros_like(row), None)
    received = np.array([0.5, 0.5, 1.2, 0.5])
    where = np.array([0, 0, 0, 1]), np.array([True, False])
    outside, sky = outside_areas(hits, elements, received, np.zeros(4), *where)
    np.testing.assert_allclose(outside, [0.5, 0.5, 0.0, 0.0])
    np.testing.assert_allclose(sky, outside * 2 / 3)
    outside, _ = outside_areas(hits, elements, received, np.full(4, 1e9), *where)
    np.testing.assert_allclose(outside, [0.375, 0.375, 0.375, 0.0])
    outside, _ = outside_areas(hits, elements, received, np.full(4, 0.17), *where)
    assert 0.375 < outside[0] < 0.5 and 0.0 < outside[2] < 0.375


def test_pooled_factors_are_reciprocal_and_exact_for_exact_factors():
    rng = np.random.default_rng(5)
    area = rng.uniform(0.1, 3.0, 30)
    exchange = rng.random((30, 30)) * (rng.random((30, 30)) < 0.3)
    exchange += exchange.T
    found = pooled_factors(csr_array(exchange / area[:, None]), area).toarray()
    np.testing.assert_allclose(found, exchange, rtol=1e-12)
    noisy = pooled_factors(csr_array(exchange / area[:, None] * rng.uniform(0.5, 1.5, (30, 30))), area)
    np.testing.assert_allclose(noisy.toarray(), noisy.toarray().T, rtol=1e-12)


def test_cells_are_drawn_by_area(device):
    room = Prepared(device, valley(), 2.0)
    elements = replace(room.elements, row_share=np.array([0.75, 1.0], np.float32))
    rng = np.random.default_rng(2)
    drawn = np.array([random_cells(elements, rng)[0] for _ in range(4000)])
    assert np.mean(drawn == elements.row_cell[0]) == pytest.approx(0.75, abs=0.03)


def test_known_constants_are_those_of_the_closed_forms():
    assert parallel_rectangles(1, 1, 1) == pytest.approx(OPPOSITE, rel=1e-12)
    assert perpendicular_rectangles(1, 1, 1) == pytest.approx(ADJACENT, rel=1e-12)
