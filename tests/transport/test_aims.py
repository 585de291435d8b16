"""Rays aimed at spots: the same exchange in the mean, closed and symmetric, with less noise behind a slot."""

import numpy as np
import pytest
from rooms import SceneBuilder
from scipy.sparse import csr_array

from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import MISS, build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.aim_shares import PlainRays, RayWorth, Smoothing, find_aims
from hradiosity.transport.aims import Aims, Lines, row_rays, trace_aimed_rows
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import build_exchange, trace_rows
from hradiosity.transport.waists import find_spots, passes

SLOT = np.array([[1.0, 0.5, z, 0.04] for z in np.arange(0.05, 1.0, 0.1)])
"""Balls along the slot of `halves`."""


class Halves:
    """A box of 2 × 1 × 1 m that a wall parts in two, with a slot of 4 cm in it or without a wall."""

    def __init__(self, device, *, wall=True):
        b = SceneBuilder()
        grey = b.material(0.5)
        for origin, u, v in (
            ((0, 0, 0), (2, 0, 0), (0, 1, 0)),
            ((0, 0, 1), (2, 0, 0), (0, 1, 0)),
            ((0, 0, 0), (2, 0, 0), (0, 0, 1)),
            ((0, 1, 0), (2, 0, 0), (0, 0, 1)),
            ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
            ((2, 0, 0), (0, 1, 0), (0, 0, 1)),
        ):
            b.patch(origin, u, v, grey)
        if wall:
            b.patch((1, 0, 0), (0, 0.48, 0), (0, 0, 1), grey)
            b.patch((1, 0.52, 0), (0, 0.48, 0), (0, 0, 1), grey)
        b.lamp(b.patch((0.4, 0.4, 0.999), (0, 0.2, 0), (0.2, 0, 0), grey), 1.0)
        scene = b.scene()
        self.patches = scene.patches
        bvh = build_bvh(device, scene.patches)
        lit = find_lit_sides(scene, bvh)
        two_sided = np.array([m.two_sided for m in scene.materials])
        self.elements = build_elements(scene.patches, lit.space, two_sided, 0.25)
        self.scene = upload_scene(device, scene, bvh, occlusion=True)
        self.rows = upload_elements(device, self.elements)
        self.origin = bvh.local_origin
        centre = row_rays(self.scene, self.rows, np.arange(len(self.elements)), 1, 1).origin + self.origin
        self.right = (centre[:, 0] > 1.0).astype(float)
        self.right[np.abs(centre[:, 0] - 1.0) < 1e-3] = np.nan

    def aims(self, share=0.5):
        ball = SLOT - np.append(self.origin, 0.0)
        shares = np.full((len(self.elements), len(ball)), share / len(ball), np.float32)
        return Aims(ball.astype(np.float32), shares)

    def across(self, exchange):
        """Exchange area of rows on the left with rows on the right, those of the wall left out."""
        n = len(exchange.element_area)
        k = csr_array((exchange.area, exchange.source.astype(int), exchange.start.astype(int)), shape=(n, n))
        return (self.right == 0.0) @ k @ (self.right == 1.0)

    def worth(self):
        """Light on the left, readings on the right."""
        left = np.where(self.right == 0.0, 1.0, 0.0)
        return RayWorth(left + 0.01, np.where(self.right == 1.0, 1.0, 0.0) + 0.01, 0.0)


@pytest.fixture(scope="module")
def halves(device):
    return Halves(device)


def test_without_shares_rays_are_the_plain_ones(device, halves):
    plain = trace_rows(halves.scene, halves.rows, 32, 3)
    aimed = trace_aimed_rows(halves.scene, halves.rows, halves.aims(0.0).upload(device), 32, 3)
    np.testing.assert_array_equal(plain.row, aimed.row)
    np.testing.assert_array_equal(plain.side, aimed.side)
    np.testing.assert_array_equal(aimed.density[:, :, 0], 1.0)
    one, other = (build_exchange(hits, halves.elements) for hits in (plain, aimed))
    np.testing.assert_array_equal(one.source, other.source)
    np.testing.assert_allclose(one.area, other.area, rtol=1e-12, atol=1e-15)


def test_shares_of_rays_sum_to_one_in_the_mean(device, halves):
    """Over 4096 rays from each row: Σ 1 / (n c) is 1 whatever the aims, c the density over the cosine law's."""
    hits = trace_aimed_rows(halves.scene, halves.rows, halves.aims().upload(device), 4096, 3)
    lost = np.isinf(hits.density[:, :, 0])
    assert (hits.row[lost] == MISS).all()
    total = hits.share.sum(axis=1)
    assert total.mean() == pytest.approx(1.0, abs=1e-3)
    assert np.abs(total - 1.0).max() < 0.05
    assert (hits.share[~lost] <= 2.0 / 4096 * (1 + 1e-5)).all()


def test_the_same_exchange_with_less_noise(device, halves):
    """Through the slot: the mean of 64 replicates of 32 rays is that of many plain rays, with half of the variance."""
    aims = halves.aims().upload(device)
    many = [
        halves.across(build_exchange(trace_rows(halves.scene, halves.rows, 4096, k), halves.elements)) for k in range(8)
    ]
    found = {True: [], False: []}
    for seed in range(64):
        plain = trace_rows(halves.scene, halves.rows, 32, seed)
        aimed = trace_aimed_rows(halves.scene, halves.rows, aims, 32, seed)
        for hits in (plain, aimed):
            found[hits is aimed].append(halves.across(build_exchange(hits, halves.elements)))
    aimed, plain = np.array(found[True]), np.array(found[False])
    error = np.hypot(aimed.std(ddof=1) / 8.0, np.std(many, ddof=1) / 8.0**0.5)
    assert aimed.mean() == pytest.approx(np.mean(many), abs=4.0 * error)
    assert error < 0.02 * np.mean(many)
    assert aimed.var(ddof=1) < 0.5 * plain.var(ddof=1)


def test_rows_close_and_are_reciprocal(device, halves):
    exchange = build_exchange(
        trace_aimed_rows(halves.scene, halves.rows, halves.aims().upload(device), 32, 5), halves.elements
    )
    n = len(halves.elements)
    k = csr_array((exchange.area, exchange.source.astype(int), exchange.start.astype(int)), shape=(n, n)).toarray()
    assert (k >= 0.0).all()
    np.testing.assert_allclose(k, k.T, rtol=1e-12)
    np.testing.assert_allclose(k.sum(axis=1) + exchange.outside, exchange.element_area, rtol=1e-12)


def test_one_seed_gives_one_set_of_rays(device, halves):
    aims = halves.aims().upload(device)
    one, again, other = (trace_aimed_rows(halves.scene, halves.rows, aims, 32, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.row, again.row)
    np.testing.assert_array_equal(one.density, again.density)
    assert (one.row != other.row).any()


def test_aims_are_found_behind_a_slot_and_in_no_open_room(device, halves):
    hits = trace_rows(halves.scene, halves.rows, 64, 1)
    aims, rays = find_aims(halves.scene, halves.rows, hits, halves.worth(), 1, tolerance=0.0)
    assert aims is not None and rays > 0
    centre = aims.spot[:, :3] + halves.origin
    assert (np.abs(centre[:, 0] - 1.0) < 0.15).mean() > 0.8 and (np.abs(centre[:, 1] - 0.5) < 0.1).mean() > 0.8
    aimed = aims.share.sum(axis=1)
    assert aimed.max() <= 0.5 + 1e-6 and aimed.mean() > 0.1
    noisy = PlainRays.of(halves.worth(), hits, halves.elements.area).variance.sum() ** 0.5
    assert find_aims(halves.scene, halves.rows, hits, halves.worth(), 1, tolerance=1.1 * noisy) == (None, 0)
    hall = Halves(device, wall=False)
    hits = trace_rows(hall.scene, hall.rows, 64, 1)
    assert find_aims(hall.scene, hall.rows, hits, hall.worth(), 1, tolerance=0.0)[0] is None


def test_smoothing_keeps_sums(halves):
    smooth = Smoothing.of(halves.patches, halves.elements)
    values = np.random.default_rng(1).random(len(halves.elements))
    area = halves.elements.area
    assert (smooth(values) * area).sum() == pytest.approx((values * area).sum())
    assert smooth(values).std() < values.std()
    np.testing.assert_allclose(smooth(np.ones(len(area))), 1.0)


def lines_through(rng, n, hole):
    """Lines from the plane x = 0 to x = 2, through a square hole of that size in the middle or through a wide one."""
    start = np.column_stack([np.zeros(n), rng.random((n, 2))])
    middle = np.column_stack([np.ones(n), 0.5 + hole * (rng.random((n, 2)) - 0.5)])
    way = middle - start
    length = np.linalg.norm(way, axis=1)
    return Lines(start, way / length[:, None], 2.0 * length, np.ones((n, 2)))


def test_a_spot_lies_where_lines_meet():
    rng = np.random.default_rng(2)
    lines = lines_through(rng, 400, 0.02)
    for spots in find_spots(lines, np.ones(400), 2.0):
        assert len(spots.ball) <= 6
        np.testing.assert_allclose(
            np.average(spots.ball[:, :3], axis=0, weights=spots.caught), [1.0, 0.5, 0.5], atol=0.05
        )
        assert spots.caught.sum() >= 0.9 * 400
    spread = find_spots(lines_through(rng, 400, 1.0), np.ones(400), 2.0)[0]
    assert spread.caught.sum() < 0.5 * 400


def test_angle_of_a_ball():
    """At a distance of two radii a ball fills a cone of 30° half angle; from inside, none; behind, no hit."""
    ball = np.array([[0.0, 0.0, 2.0, 1.0]])
    ahead, behind = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]])
    met, cone = passes(ball, np.zeros((1, 3)), ahead)
    assert met.all() and cone[0, 0] == pytest.approx(1.0 - 3.0**0.5 / 2.0)
    assert not passes(ball, np.zeros((1, 3)), behind)[0].any()
    assert not passes(ball, np.array([[0.0, 0.0, 1.5]]), ahead)[0].any()
