"""Importance is dual to light; products inside elements are unbiased; what is split, and what is left."""

import numpy as np
import pytest

from hradiosity.space.hierarchy import COVERED, MISS, SKY
from hradiosity.transport.exchange import RowHits, closed_exchange
from hradiosity.transport.unevenness import Transported, importance_of_rows, near_share, uneven_products, worst_first


def hits_of(row):
    row = np.asarray(row, np.uint32)
    return RowHits(row, np.zeros_like(row), None)


def exchange_of(n, seed=0):
    """A closed, symmetric exchange between n rows of unlike areas."""
    from scipy.sparse import csr_array

    rng = np.random.default_rng(seed)
    links = rng.random((n, n)) + 0.1
    area = rng.random(n) + 0.5
    pooled = csr_array((links + links.T) / (2 * n))
    return closed_exchange(pooled, np.zeros(n), np.zeros(n), area, reciprocity_rms=0.0, lost_share=0.0)


def test_importance_of_direct_light_is_the_reading():
    """Σ A ρ E s, what readings see, is Σ A ρ D Z, what direct light is worth."""
    n, rng = 12, np.random.default_rng(3)
    exchange = exchange_of(n)
    reflectance, direct, seen = 0.6 * rng.random(n), rng.random(n), rng.random(n)
    links = np.zeros((n, n))
    receiver = np.repeat(np.arange(n), np.diff(exchange.start.astype(int)))
    links[receiver, exchange.source] = exchange.area
    area = exchange.element_area
    light = np.linalg.solve(np.eye(n) - links / area[:, None] * reflectance, direct)
    importance = importance_of_rows(exchange, reflectance, seen)
    weight = area * reflectance
    assert (weight * direct * importance).sum() == pytest.approx((weight * light * seen).sum(), rel=1e-5)


def test_products_are_unbiased_though_rays_are_few():
    """Light and importance of single rays are the same numbers: with one set of rays for both, noise would add up."""
    rng = np.random.default_rng(1)
    n, rays = 4000, 4
    leaving = np.array([0.0, 1.0])
    share = np.array([0.2, 0.2, 0.4, 0.6])
    hits = [hits_of(rng.random((4 * n, rays)) < np.tile(share, n)[:, None]) for _ in range(2)]
    none = np.zeros(4 * n)
    light = Transported(leaving)
    one, other = uneven_products((hits[0], hits[1]), (none, none), light, light)
    exact = np.mean((share - share.mean()) ** 2)
    noise = np.concatenate([one, other]).std() / np.sqrt(2 * n)
    assert abs(0.5 * (one + other).mean() - exact) < 5 * noise < exact / 2
    same, _ = uneven_products((hits[0], hits[0]), (none, none), light, light)
    assert same.mean() > 2 * exact


def test_direct_light_and_sky_count_and_covered_rays_do_not():
    hits = hits_of([[0, COVERED], [SKY, SKY], [MISS, MISS], [0, 0]])
    assert Transported(np.array([3.0]), 5.0).brought(hits).tolist() == [[3, 0], [5, 5], [0, 0], [3, 3]]
    direct = np.array([0.0, 0.0, 5.0, 2.0])
    wanted = Transported(np.array([1.0]))
    one, other = uneven_products((hits, hits), (direct, direct), Transported(np.array([3.0]), 5.0), wanted)
    arriving, importance = np.array([3.0, 5.0, 5.0, 5.0]), np.array([1.0, 0.0, 0.0, 1.0])
    exact = np.mean(arriving * importance) - arriving.mean() * importance.mean()
    assert one.tolist() == other.tolist() == pytest.approx([exact])


def test_near_share():
    centre = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 3.0, 0]])
    hits = hits_of([[1, 2, MISS, 1], [0, 0, 0, 0], [0, 1, 2, SKY]])
    assert near_share(hits, centre, np.array([1.5, 0.5, 10.0])).tolist() == [0.5, 0.0, 0.75]


def test_groups_stand_and_fall_together():
    error = np.array([0.5, 0.5, 0.3, -0.3, 0.2, 0.2, 0.01])
    noise = np.array([0.1, 0.1, 0.1, 0.1, 1.0, 1.0, 0.0])
    group = np.array([7, 7, 3, 3, 5, 5, 9])
    chosen, total = worst_first(error, noise, group, 0.1, most=10)
    assert chosen.tolist() == [0, 1] and total == pytest.approx(1.01)
    chosen, _ = worst_first(error, noise, group, 0.02, most=10)
    assert chosen.tolist() == [0, 1, 6]
    assert worst_first(error, noise, group, 2.0, most=10)[0].tolist() == []
    assert worst_first(error, noise, group, 0.1, most=1)[0].tolist() == []
