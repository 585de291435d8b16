"""Exchange areas: what is done with hits, and rays in rooms whose form factors are known."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube
from scipy.sparse import csr_array

from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles, polygon_pair
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import COVERED, MISS, SKY, UNLIT, build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import RowHits, build_exchange, trace_rows

OPPOSITE, ADJACENT = parallel_rectangles(1, 1, 1), perpendicular_rectangles(1, 1, 1)


def prepared(device, scene, size, **options):
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    two_sided = np.array([m.two_sided for m in scene.materials])
    elements = build_elements(scene.patches, lit.space, two_sided, size, **options)
    return upload_scene(device, scene, bvh, occlusion=True), elements, upload_elements(device, elements)


def traced(device, scene, size, rays, seed=1, **options):
    on_device, elements, uploaded = prepared(device, scene, size, **options)
    return elements, build_exchange(trace_rows(on_device, uploaded, rays, seed), elements)


def dense(exchange):
    n = len(exchange.element_area)
    return csr_array((exchange.area, exchange.source.astype(int), exchange.start.astype(int)), shape=(n, n)).toarray()


def synthetic(rng, n, n_rays=64, areas=None):
    """Elements without geometry, and hits of rays that see any element in proportion to its area."""
    scene = SceneBuilder()
    material = scene.material(0.5)
    areas = rng.uniform(0.5, 2.0, n) if areas is None else areas
    for k, a in enumerate(areas):
        scene.patch((0, 0, k), (a, 0, 0), (0, 1, 0), material)
    space = np.tile(np.array([[0, -1]], np.int32), (n, 1))
    elements = build_elements(scene.scene().patches, space, np.array([True]), 100.0, grouping=False)
    row = rng.choice(n, (n, n_rays), p=areas / areas.sum()) if n else np.zeros((0, n_rays))
    return elements, row.astype(np.uint32)


def from_rows(row, elements):
    return build_exchange(RowHits(row, np.zeros_like(row), None), elements)


def check_closed(exchange, tolerance=1e-12):
    """Reciprocal to rounding, not negative, every row closes."""
    k = dense(exchange)
    assert (k >= 0).all()
    np.testing.assert_allclose(k, k.T, rtol=1e-12, atol=1e-300)
    np.testing.assert_allclose(k.sum(axis=1) + exchange.outside, exchange.element_area, rtol=tolerance)
    return k


@pytest.mark.parametrize("n", [1, 2, 20, 200])
def test_random_hits_make_a_reciprocal_closed_exchange(n):
    elements, row = synthetic(np.random.default_rng(n), n)
    exchange = from_rows(row, elements)
    check_closed(exchange)
    np.testing.assert_allclose(exchange.element_area, elements.area)
    assert exchange.defects.row_sum_max > 0 or n == 1


def test_pooled_counts_weigh_each_ray_by_its_area():
    """Two elements of areas 1 and 9, 64 rays each: K = (N12 + N21) / (M/A1 + M/A2) before scaling."""
    elements, row = synthetic(np.random.default_rng(0), 2, areas=np.array([1.0, 9.0]))
    row[:] = MISS
    row[0, :32] = 1
    row[1, :4] = 0
    exchange = from_rows(row, elements)
    k = dense(exchange)
    expected = 36 / (64 + 64 / 9)
    assert k[0, 1] / np.prod(np.sqrt(scales_of(exchange, elements, row))) == pytest.approx(expected, rel=1e-12)


def scales_of(exchange, elements, row):
    """Squares of the factors that closed the rows, read off what went outside."""
    return (exchange.outside / (elements.area * (row == MISS).mean(axis=1))) ** 2


def test_outside_is_kept_apart_and_sky_is_part_of_it():
    rng = np.random.default_rng(3)
    elements, row = synthetic(rng, 50, 256)
    draw = rng.random(row.shape)
    row[draw < 0.3] = MISS
    row[draw < 0.2] = SKY
    exchange = from_rows(row, elements)
    check_closed(exchange)
    np.testing.assert_allclose(exchange.outside.sum() / elements.area.sum(), 0.3, rtol=0.03)
    np.testing.assert_allclose(exchange.sky.sum() / exchange.outside.sum(), 2 / 3, rtol=0.03)


def test_everything_outside():
    elements, row = synthetic(np.random.default_rng(0), 4)
    row[:] = SKY
    exchange = from_rows(row, elements)
    np.testing.assert_array_equal(exchange.outside, elements.area)
    np.testing.assert_array_equal(exchange.sky, elements.area)
    assert len(exchange.area) == 0 or not exchange.area.any()


def test_covered_rays_shrink_the_element():
    elements, row = synthetic(np.random.default_rng(4), 10)
    row[3, :16] = COVERED
    row[7, :] = COVERED
    row[(row == 7)] = 1
    exchange = from_rows(row, elements)
    assert exchange.element_area[3] == pytest.approx(0.75 * elements.area[3])
    assert exchange.element_area[7] == 0
    k = check_closed(exchange)
    assert not k[7].any()


def test_rays_to_dark_sides_are_reported_and_made_up_for():
    elements, row = synthetic(np.random.default_rng(5), 10)
    row[2, :8] = UNLIT
    exchange = from_rows(row, elements)
    assert exchange.defects.lost_share == pytest.approx(8 / row.size)
    check_closed(exchange)


@pytest.mark.filterwarnings("error")
def test_no_elements_and_elements_without_area():
    elements, row = synthetic(np.random.default_rng(6), 0)
    exchange = from_rows(row, elements)
    assert len(exchange.element_area) == 0 and len(exchange.area) == 0
    elements, row = synthetic(np.random.default_rng(6), 3, areas=np.array([1.0, 0.0, 1.0]))
    row[1] = 0
    exchange = from_rows(row, elements)
    check = dense(exchange)
    assert not check[1].any() and np.isfinite(check).all()


def test_unequal_elements_that_see_only_each_other():
    """No scaling closes them: the larger keeps light for itself rather than giving more than the smaller has."""
    elements, row = synthetic(np.random.default_rng(7), 2, areas=np.array([1.0, 4.0]))
    row[0], row[1] = 1, 0
    exchange = from_rows(row, elements)
    k = check_closed(exchange)
    assert k[0, 1] <= 1.0 + 1e-3 and exchange.defects.self_share > 0.3


def cube_errors(device, rays, seeds):
    """Rms error of the form factors of a cube with one row a face, over seeds, before they are pooled."""
    room = cube()
    room.lamp(5, 1.0)
    on_device, _, uploaded = prepared(device, room.scene(), 10.0)
    errors = []
    for seed in seeds:
        row = trace_rows(on_device, uploaded, rays, seed).row
        factor = np.stack([(row == k).mean(axis=1) for k in range(6)], axis=1)
        exact = np.full((6, 6), ADJACENT)
        exact[np.arange(6), np.arange(6) ^ 1] = OPPOSITE
        np.fill_diagonal(exact, 0)
        errors.append(factor - exact)
    return np.array(errors)


def test_cube_form_factors_within_sampling_error_that_falls_at_the_rate_of_nets(device):
    """Mean over seeds within 4 standard errors; rms falls faster than the 1/√n of independent rays."""
    few, many = cube_errors(device, 64, range(24)), cube_errors(device, 4096, range(24))
    for errors in (few, many):
        # 30 pairs: the largest of 30 normal deviates stays below 4 with probability 0.998.
        standard_error = errors.std(axis=0, ddof=1) / np.sqrt(24)
        off = standard_error > 0
        assert (np.abs(errors.mean(axis=0))[off] < 4.2 * standard_error[off]).all()
        assert (errors.mean(axis=0)[~off] == 0).all()
    rate = np.log(np.sqrt((few**2).mean() / (many**2).mean())) / np.log(64)
    assert np.sqrt((few**2).mean()) < np.sqrt(0.2 * 0.8 / 64)
    assert rate > 0.6


def test_cube_is_exact_once_closed(device):
    """Rms error with 16384 rays a face far below the 2e-3 of independent rays, pooled."""
    room = cube()
    room.lamp(5, 1.0)
    _, exchange = traced(device, room.scene(), 10.0, 16384)
    exact = np.full((6, 6), ADJACENT)
    exact[np.arange(6), np.arange(6) ^ 1] = OPPOSITE
    np.fill_diagonal(exact, 0)
    error = check_closed(exchange) - exact
    assert np.sqrt((error**2).mean()) < 7e-4


def test_parallel_plates(device):
    """Open: one row a plate; what does not reach the other plate goes outside."""
    room = SceneBuilder()
    material = room.material(0.5, two_sided=False)
    low = room.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), material)
    room.patch((0, 0, 0.5), (0, 1, 0), (1, 0, 0), material)
    room.lamp(low, 1.0)
    elements, exchange = traced(device, room.scene(), 10.0, 65536)
    rows = {int(s): k for k, s in enumerate(elements.cell_side[elements.row_cell])}
    exact = parallel_rectangles(1, 1, 0.5)
    k = dense(exchange)
    assert k[rows[0], rows[2]] == pytest.approx(exact, rel=2e-3)
    assert exchange.outside[rows[0]] == pytest.approx(1 - exact, rel=2e-3)
    # The lower plate's front looks up to the sky past the other plate, the upper one's down.
    assert exchange.sky[rows[0]] == pytest.approx(1 - exact, rel=2e-3)
    assert exchange.sky[rows[2]] == 0


def test_small_lamp_over_a_large_floor(device):
    """A patch of 0.1 m over a floor of 10 m: the small one's rays decide, whatever the floor's rays find."""
    room = SceneBuilder()
    material = room.material(0.5, two_sided=False)
    floor = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0.0]])
    lamp = np.array([[1, 1, 2], [1, 1.1, 2], [1.1, 1.1, 2], [1.1, 1, 2.0]])
    for corners in (floor, lamp):
        room.patch(corners[0], corners[1] - corners[0], corners[3] - corners[0], material)
    room.lamp(1, 1.0)
    elements, exchange = traced(device, room.scene(), 100.0, 16384)
    rows = {int(s): k for k, s in enumerate(elements.cell_side[elements.row_cell])}
    exact = polygon_pair(lamp, floor)
    assert dense(exchange)[rows[2], rows[0]] / 0.01 == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("size", [0.15, 0.6])
def test_constant_one_in_a_furnished_closed_room(device, size):
    """Exitance 1 everywhere gives irradiance 1 everywhere: nothing is lost, whatever stands in the room."""
    room = cube()
    room.lamp(5, 1.0)
    wood = room.material(0.3)
    room.box((0.2, 0.2, 0), (0.5, 0.6, 0.4), wood, solid=True)
    room.box((0.7, 0.1, 0.2), (0.8, 0.9, 0.21), wood, solid=True)
    room.patch((0.1, 0.7, 0.3), (0.3, 0.1, 0.1), (0.0, 0.1, 0.3), wood)
    room.patch((0.6, 0.7, 0.5), (0.2, 0.1, 0.0), (0.0, 0.1, 0.3), wood, triangle=True)
    elements, exchange = traced(device, room.scene(), size, 128)
    k = check_closed(exchange)
    exposed = exchange.element_area > 0
    one = k.sum(axis=1)[exposed] / exchange.element_area[exposed]
    np.testing.assert_allclose(one, 1.0, atol=1e-12)
    assert not exchange.outside.any()
    covered = elements.area.sum() - exchange.element_area.sum()
    assert covered == pytest.approx(0.3 * 0.4, rel=0.2)


def test_tall_cupboard_flush_with_two_walls_covers_its_floor(device):
    room = cube()
    room.lamp(5, 1.0)
    room.box((0, 0, 0), (0.5, 0.5, 0.9), room.material(0.3), solid=True)
    elements, exchange = traced(device, room.scene(), 10.0, 4096)
    floor = elements.cell_side[elements.row_cell[elements.row_start[:-1]]] == 8
    assert exchange.element_area[floor] == pytest.approx(0.75, rel=5e-3)


def test_same_seed_same_bits_and_other_seed_others(device):
    room = cube()
    room.lamp(5, 1.0)
    first, again, other = (traced(device, room.scene(), 0.3, 64, seed)[1].area for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert len(first) != len(other) or (first != other).any()
