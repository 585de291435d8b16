"""Hierarchical links: what they cover, their form factors, sight between their ends, and the operator made of them."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity import form_factor
from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles
from hradiosity.solvers.link_operator import LinkOperator
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.nodes import build_nodes
from hradiosity.space.shafts import FREE
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.link_exchange import LinkExchange, build_link_exchange, link_nodes
from hradiosity.transport.links import LinkFinder, Refinement

OPPOSITE, ADJACENT = parallel_rectangles(1, 1, 1), perpendicular_rectangles(1, 1, 1)


class Case:
    """Links of a scene, all of its light sides in one space."""

    def __init__(self, device, scene, size, form_factor=0.05, *, occlusion=True, samples=16):
        bvh = build_bvh(device, scene.patches)
        lit = find_lit_sides(scene, bvh)
        two_sided = np.array([m.two_sided for m in scene.materials])
        self.elements = build_elements(scene.patches, lit.space, two_sided, size)
        self.nodes = build_nodes(scene.patches, self.elements)
        self.on_device = upload_scene(device, scene, bvh, occlusion=occlusion)
        self.uploaded = upload_elements(device, self.elements)
        self.finder = LinkFinder(self.on_device, self.nodes)
        space = lit.space.ravel()[self.nodes.facets.side[self.nodes.facet_start[self.nodes.roots]]]
        rules = Refinement(form_factor, occlusion, np.inf, 1)
        self.linked = link_nodes(self.finder, self.nodes, space, rules, samples)
        self.links = self.linked.links
        self.patch = self.elements.cell_side[self.elements.row_cell[self.elements.row_start[:-1]]] // 2

    def exchange(self, seed=1, rays=16) -> LinkExchange:
        hits = trace_rows(self.on_device, self.uploaded, rays, seed)
        return build_link_exchange(self.linked, hits, self.elements, seed)

    def between(self, value, one, other):
        """Sum of a value of the links between nodes of two patches."""
        patch = self.nodes.facets.patch[self.nodes.facet_start[:-1]]
        p, q = patch[self.links.first], patch[self.links.second]
        return value[((p == one) & (q == other)) | ((p == other) & (q == one))].sum()


def empty():
    b = cube()
    b.lamp(5, 1.0)
    return b.scene()


def furnished(bands=1):
    b = cube(0.5, bands)
    paint = b.material(0.3)
    b.box((0.2, 0.3, 0.0), (0.5, 0.55, 0.4), paint, solid=True)
    b.box((0.65, 0.1, 0.35), (0.9, 0.7, 0.4), paint, solid=True)
    b.lamp(5, 1.0)
    return b.scene()


def plates(*cards):
    """Unit squares that face each other at distance 1, and what stands between."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), paint)
    b.patch((0, 0, 1), (0, 1, 0), (1, 0, 0), paint)
    for card in cards:
        b.patch(*card, paint)
    b.lamp([0, 1], 1.0, two_sided=True)
    return b.scene()


@pytest.mark.parametrize("largest", [0.3, 0.05])
def test_every_pair_of_elements_is_covered_once(device, largest):
    case = Case(device, empty(), 0.13, largest)
    n = len(case.nodes)
    count = np.zeros((n, n))
    np.add.at(count, (case.links.first, case.links.second), 1.0)
    np.add.at(count, (case.links.second, case.links.first), 1.0)
    below = case.nodes.gathering().toarray()
    faces_differ = case.patch[:, None] != case.patch[None, :]
    np.testing.assert_array_equal(below.T @ count @ below, faces_differ)


def test_links_stay_below_the_largest_form_factor_or_join_single_elements(device):
    case = Case(device, furnished(), 0.1, 0.05)
    large = case.links.factor > 0.05
    bigger = np.where(
        case.finder.area[case.links.first] >= case.finder.area[case.links.second], case.links.first, case.links.second
    )
    assert large.any() and (bigger[large] < case.nodes.n_rows).all()
    assert (case.linked.exchange / np.maximum(*case.finder.area[[case.links.first, case.links.second]]) < 1.0).all()


def test_faces_of_a_cube_see_each_other_by_the_closed_forms(device):
    case = Case(device, empty(), 0.11)
    exchange = case.linked.exchange
    for face in range(1, 6):
        wanted = OPPOSITE if face == 1 else ADJACENT
        assert case.between(exchange, 0, face) == pytest.approx(wanted, rel=2e-4)


def test_rows_of_a_cube_close_before_they_are_closed(device):
    """The mean to the form factors' tolerance; single rows with an error like the size of nodes, √form factor."""
    defects = [Case(device, empty(), 0.06, largest).exchange().defects for largest in (0.2, 0.05, 0.0125)]
    rms = [d.row_sum_rms for d in defects]
    assert rms[0] > 1.5 * rms[1] and rms[1] > 1.5 * rms[2] and rms[2] < 0.06
    case = Case(device, empty(), 0.06, 0.2)
    total = case.linked.exchange.sum() * 2.0
    assert total == pytest.approx(6.0, rel=2e-4)


def test_shafts_prove_all_links_of_a_convex_room(device):
    case = Case(device, empty(), 0.2)
    assert (case.links.sight == FREE).all() and not case.linked.n_samples.any()


def test_more_links_for_smaller_form_factors(device):
    """About as form_factor^-0.85 where elements are fine enough, as in the measured table of the method's cost."""
    counts = [len(Case(device, furnished(), 0.02, largest).links) for largest in (0.2, 0.1, 0.05)]
    growth = np.log(counts[-1] / counts[0]) / np.log(4.0)
    assert counts == sorted(counts) and 0.6 < growth < 1.1


def test_a_card_takes_its_share(device):
    card = ((0.45, 0.45, 0.5), (0.1, 0, 0), (0, 0.1, 0))
    scene = plates(card)
    corners = scene.patches.corners()
    exact = form_factor(corners[0], corners[1], occluders=corners[2:], visibility_tolerance=2e-4, device=device)
    case = Case(device, scene, 0.11, samples=64)
    found = []
    for seed in range(8):
        share = np.ones(len(case.links))
        doubtful = np.flatnonzero(case.linked.n_samples)
        share[doubtful] = case.finder.sample(case.links.subset(doubtful), case.linked.n_samples[doubtful], seed)
        found.append(case.between(case.linked.exchange * share, 0, 1))
    assert float(exact.value) == pytest.approx(0.194, abs=1e-3)
    assert np.mean(found) == pytest.approx(float(exact.value), abs=4e-4)


@pytest.mark.parametrize("gap", [0.3, 0.03, 0.003])
def test_plates_nearly_in_touch(device, gap):
    """Evenly drawn points alone find about nothing of what plates in touch exchange."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.patch((0, 0, 0), (0.3, 0, 0), (0, 0.3, 0), paint)
    b.patch((0, 0, gap), (0, 0.3, 0), (0.3, 0, 0), paint)
    b.patch((0.15, -1, 0.5 * gap), (1, 0, 0), (0, 2, 0), paint)
    b.lamp([0, 1], 1.0)
    scene = b.scene()
    case = Case(device, scene, 1.0)
    corners = scene.patches.corners()
    exact = form_factor(corners[0], corners[1], occluders=corners[2:], visibility_tolerance=1e-3, device=device)
    whole = form_factor(corners[0], corners[1], device=device)
    chosen = np.flatnonzero((case.links.first == 0) & (case.links.second == 1))
    shares = [case.finder.sample(case.links.subset(chosen), np.full(1, 256), seed)[0] for seed in range(4)]
    assert np.mean(shares) == pytest.approx(float(exact.value) / float(whole.value), abs=0.02)


@pytest.mark.parametrize("scene", [furnished, plates], ids=lambda make: make.__name__)
def test_operator_is_symmetric_and_the_same_multiplied_out(device, scene):
    exchange = Case(device, scene(), 0.11).exchange()
    single, double = LinkOperator(device, exchange), LinkOperator(device, exchange, np.float64)
    flat = ExchangeOperator(device, exchange.flattened(), np.float64)
    rng = np.random.default_rng(1)
    u, v = rng.random((2, single.n_rows, 16))
    wanted = flat.apply(u)
    np.testing.assert_allclose(double.apply(u), wanted, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(single.apply(u.astype(np.float32)), wanted, rtol=2e-5, atol=2e-6)
    assert np.vdot(v, double.apply(u)) == pytest.approx(np.vdot(double.apply(v), u), rel=1e-13)
    np.testing.assert_allclose(double.dense(), flat.dense(), rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(double.rows(np.array([3, 1])).toarray(), double.dense()[[3, 1]])
    np.testing.assert_array_equal(single.component, flat.component)


def test_pulling_is_the_transpose_of_pushing(device):
    exchange = Case(device, furnished(), 0.11).exchange()
    below = exchange.gathering
    rng = np.random.default_rng(2)
    rows, nodes = rng.random(below.shape[1]), rng.random(below.shape[0])
    pushed = nodes[: len(rows)].copy()
    above = exchange.nodes.parent[: len(rows)]
    while (above >= 0).any():
        pushed += np.where(above >= 0, nodes[above], 0.0)
        above = np.where(above >= 0, exchange.nodes.parent[above], -1)
    np.testing.assert_allclose(below.T @ nodes, pushed, rtol=1e-14)
    assert (below @ rows) @ nodes == pytest.approx(rows @ pushed, rel=1e-13)


@pytest.mark.parametrize("scene", [furnished, plates], ids=lambda make: make.__name__)
def test_rows_close_and_none_gives_more_than_it_has(device, scene):
    exchange = Case(device, scene(), 0.11).exchange()
    received = exchange.received(np.ones(exchange.nodes.n_rows)) + exchange.outside
    np.testing.assert_allclose(received, exchange.element_area, rtol=1e-12, atol=1e-15)
    assert (exchange.own >= 0.0).all() and (exchange.value > 0.0).all()
    assert (exchange.flattened().area >= 0.0).all()


def test_same_seed_same_bits(device):
    one, other, third = (Case(device, furnished(), 0.15).exchange(seed) for seed in (3, 3, 4))
    for name in ("start", "source", "value", "scale", "own"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert not np.array_equal(one.value, third.value)
