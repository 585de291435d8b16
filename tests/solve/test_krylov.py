"""The iterative solution against a dense one, for random closed exchanges."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_array

from hradiosity.reference.radiosity import solve_dense
from hradiosity.solvers.deflation import deflation_vectors
from hradiosity.solvers.krylov import solve_irradiance
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.transport.exchange import Defects, Exchange


def exchange_of(matrix, area) -> Exchange:
    """As if `matrix` had been found by rays; what a row lacks goes outside."""
    sparse = csr_array(matrix)
    nothing = Defects(**dict.fromkeys(Defects.__dataclass_fields__, 0))
    outside = area - matrix.sum(axis=1)
    return Exchange(
        start=sparse.indptr.astype(np.uint32),
        source=sparse.indices.astype(np.uint32),
        area=sparse.data.astype(float),
        outside=outside,
        sky=np.zeros_like(area),
        element_area=np.asarray(area, float),
        defects=nothing,
    )


def closed_space(rng, n, density=0.2):
    """Random symmetric non-negative matrix scaled until its rows sum to the areas."""
    area = rng.uniform(0.1, 2.0, n)
    matrix = np.outer(area, area) * rng.uniform(0.2, 1.0, (n, n)) * (rng.random((n, n)) < density)
    matrix += np.outer(area, area) * 0.05
    matrix += matrix.T
    for _ in range(500):
        d = np.sqrt(area / matrix.sum(axis=1))
        matrix *= d[:, None] * d
    return matrix, area


def solved(device, matrix, area, reflectance, direct, *, deflate=False, spaces=None, **options):
    columns = direct.shape[1]
    groups = -(-columns // 8)
    operator = ExchangeOperator(device, exchange_of(matrix, area))

    def padded(values):
        out = np.zeros((len(area), 8 * groups), np.float32)
        out[:, :columns] = values
        return out

    spaces = np.zeros(len(area), np.int32) if spaces is None else spaces
    deflation = deflation_vectors(operator, spaces) if deflate else None
    irradiance, convergence = solve_irradiance(
        operator, padded(reflectance), padded(direct), deflation=deflation, **options
    )
    assert not irradiance[:, columns:].any()
    return irradiance[:, :columns], convergence


@pytest.mark.parametrize("deflate", [False, True])
def test_every_column_has_its_own_reflectances(device, deflate):
    """Eleven columns, black to 0.999, within the tolerance of the dense solution."""
    rng = np.random.default_rng(1)
    matrix, area = closed_space(rng, 120)
    level = np.array([0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.8, 0.9, 0.95, 0.99, 0.999])
    reflectance = np.clip(level * rng.uniform(0.9, 1.0, (120, 11)), 0, 0.999)
    reflectance[:, -1] = 0.999
    direct = rng.random((120, 11)) ** 4
    expected = solve_dense(matrix, area, reflectance, direct)
    found, convergence = solved(device, matrix, area, reflectance, direct, deflate=deflate, tolerance=1e-6)
    assert convergence.converged
    np.testing.assert_allclose(found, expected, rtol=2e-4)
    np.testing.assert_array_equal(found[:, 0], direct[:, 0].astype(np.float32))


@pytest.mark.parametrize("rho", [0.9, 0.99, 0.999])
def test_few_products_with_deflation_whatever_the_reflectance(device, rho):
    rng = np.random.default_rng(2)
    matrix, area = closed_space(rng, 400, density=0.05)
    direct = np.zeros((400, 3))
    direct[:3] = np.eye(3)
    reflectance = np.full((400, 3), rho)
    found, convergence = solved(device, matrix, area, reflectance, direct, deflate=True, tolerance=1e-4)
    assert convergence.converged and convergence.products <= 12 and convergence.deflated == 1
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=5e-3)


def two_spaces(rng, weight=0.0):
    """Two closed spaces, or joined by a hole that a `weight` of the light goes through."""
    (a, area_a), (b, area_b) = closed_space(rng, 60), closed_space(rng, 90)
    matrix = np.block([[a, np.zeros((60, 90))], [np.zeros((90, 60)), b]])
    area = np.concatenate([area_a, area_b])
    if weight:
        hole = weight * min(area[0], area[60])
        matrix[0] *= 1 - hole / area[0]
        matrix[:, 0] = matrix[0]
        matrix[60] *= 1 - hole / area[60]
        matrix[:, 60] = matrix[60]
        matrix[0, 60] = matrix[60, 0] = hole
        matrix[np.arange(150), np.arange(150)] += area - matrix.sum(axis=1)
    return matrix, area, np.repeat([0, 1], [60, 90]).astype(np.int32)


def test_two_spaces_joined_by_a_hole(device):
    matrix, area, _ = two_spaces(np.random.default_rng(3), 0.01)
    direct = np.zeros((150, 1))
    direct[:10] = 1.0
    reflectance = np.full((150, 1), 0.99)
    found, convergence = solved(
        device, matrix, area, reflectance, direct, deflate=True, spaces=np.zeros(150, np.int32), tolerance=1e-5
    )
    assert convergence.products <= 15 and convergence.deflated >= 2
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=1e-3)


@pytest.mark.parametrize("deflate", [False, True])
@pytest.mark.parametrize("dim", [1e-3, 1e-12, 1e-25])
def test_sealed_spaces_are_solved_alike_however_dim_one_is(device, dim, deflate):
    """A bright black-walled space and a dim white one; one column that lights both, one that lights the dim alone."""
    matrix, area, spaces = two_spaces(np.random.default_rng(4))
    direct = np.zeros((150, 2))
    direct[:10, 0] = 1.0
    direct[60:65] = dim
    reflectance = np.where(spaces[:, None] == 0, 0.05, 0.95) * np.ones((1, 2))
    expected = solve_dense(matrix, area, reflectance, direct)
    found, convergence = solved(
        device, matrix, area, reflectance, direct, deflate=deflate, spaces=spaces, tolerance=1e-5
    )
    assert convergence.converged
    np.testing.assert_allclose(found, expected, rtol=5e-4)
    assert not found[:60, 1].any()


def test_open_space(device):
    """Most rays leave."""
    rng = np.random.default_rng(5)
    matrix, area = closed_space(rng, 80)
    matrix *= 0.2
    direct, reflectance = rng.random((80, 4)), rng.random((80, 4))
    found, _ = solved(device, matrix, area, reflectance, direct, tolerance=1e-6)
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=1e-5)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("deflate", [False, True])
def test_elements_without_area_or_without_links(device, deflate):
    rng = np.random.default_rng(6)
    matrix, area = closed_space(rng, 40)
    full, full_area = np.zeros((43, 43)), np.zeros(43)
    full[:40, :40], full_area[:40], full_area[42] = matrix, area, 1.0
    direct, reflectance = rng.random((43, 1)), np.full((43, 1), 0.9)
    found, _ = solved(device, full, full_area, reflectance, direct, deflate=deflate, tolerance=1e-6)
    np.testing.assert_allclose(found, solve_dense(full, full_area, reflectance, direct), rtol=1e-4)
    np.testing.assert_array_equal(found[40:], direct[40:].astype(np.float32))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("deflate", [False, True])
def test_no_light_and_no_reflection(device, deflate):
    rng = np.random.default_rng(7)
    matrix, area = closed_space(rng, 40)
    dark, convergence = solved(device, matrix, area, np.full((40, 2), 0.9), np.zeros((40, 2)), deflate=deflate)
    assert not dark.any() and convergence.converged
    direct = rng.random((40, 2))
    black, _ = solved(device, matrix, area, np.zeros((40, 2)), direct, deflate=deflate)
    np.testing.assert_array_equal(black, direct.astype(np.float32))


def test_dim_corner_of_a_connected_space(device):
    """A chain of eight rooms through holes of 1 %: light of 1e-10 at the end is solved too, to its own measure."""
    rng = np.random.default_rng(8)
    rooms = [closed_space(rng, 30) for _ in range(8)]
    area = np.concatenate([a for _, a in rooms])
    matrix = np.zeros((240, 240))
    for k, (m, _) in enumerate(rooms):
        matrix[30 * k : 30 * k + 30, 30 * k : 30 * k + 30] = m
    for k in range(7):
        i, j = 30 * k + 29, 30 * k + 30
        matrix[i, j] = matrix[j, i] = 0.01 * min(area[i], area[j])
    scale = np.sqrt(area / matrix.sum(axis=1)).min() ** 2
    matrix *= scale
    direct = np.zeros((240, 1))
    direct[:5] = 1.0
    reflectance = np.full((240, 1), 0.5)
    expected = solve_dense(matrix, area, reflectance, direct)
    found, convergence = solved(device, matrix, area, reflectance, direct, tolerance=5e-4)
    assert convergence.converged
    assert expected[-30:].mean() < 1e-25 * expected[:30].mean()
    np.testing.assert_allclose(found, expected, rtol=2e-2)


def test_a_start_from_the_solution_needs_no_iteration(device):
    rng = np.random.default_rng(9)
    matrix, area = closed_space(rng, 50)
    direct, reflectance = rng.random((50, 8)), np.full((50, 8), 0.8)
    expected = solve_dense(matrix, area, reflectance, direct)
    _, convergence = solved(
        device, matrix, area, reflectance, direct, start=(expected - direct).astype(np.float32), tolerance=1e-4
    )
    assert len(convergence.residual) == 1


def test_a_start_with_light_where_none_can_arrive(device):
    """An element that this replicate's rays left without a link: in earlier ones light arrived there."""
    rng = np.random.default_rng(8)
    matrix, area = closed_space(rng, 60)
    matrix[7] = matrix[:, 7] = 0.0
    direct = rng.random((60, 3))
    start = np.pad(rng.random((60, 3)), ((0, 0), (0, 5))).astype(np.float32)
    found, convergence = solved(device, matrix, area, 0.6, direct, tolerance=1e-4, start=start)
    assert convergence.converged and convergence.products < 20
    np.testing.assert_allclose(found, solve_dense(matrix, area, np.full((60, 3), 0.6), direct), rtol=1e-2)
    np.testing.assert_array_equal(found[7], direct[7].astype(np.float32))


@pytest.mark.parametrize("deflate", [False, True])
def test_devices_that_cannot_sum_in_double_precision(device, monkeypatch, deflate):
    """Vectors then stay on the host; the light is the same."""
    rng = np.random.default_rng(12)
    matrix, area = closed_space(rng, 80)
    direct = rng.random((80, 11))
    on_device, _ = solved(device, matrix, area, 0.9, direct, tolerance=1e-6, deflate=deflate)
    monkeypatch.setattr(device, "info", replace(device.info, has_double=False))
    on_host, convergence = solved(device, matrix, area, 0.9, direct, tolerance=1e-6, deflate=deflate)
    assert convergence.converged
    np.testing.assert_allclose(on_host, on_device, rtol=2e-5)


def test_same_bits_twice_and_columns_do_not_touch_each_other(device):
    rng = np.random.default_rng(10)
    matrix, area = closed_space(rng, 50)
    direct, reflectance = rng.random((50, 8)), rng.random((50, 8))
    first, again = (solved(device, matrix, area, reflectance, direct, deflate=True)[0] for _ in range(2))
    assert first.tobytes() == again.tobytes()
    direct[:, 3] = 0
    other, _ = solved(device, matrix, area, reflectance, direct, deflate=True)
    keep = np.arange(8) != 3
    np.testing.assert_allclose(other[:, keep], first[:, keep], rtol=1e-6)


def test_unconverged_is_said(device):
    rng = np.random.default_rng(11)
    matrix, area = closed_space(rng, 50)
    _, convergence = solved(
        device, matrix, area, np.full((50, 1), 0.99), rng.random((50, 1)), max_iterations=2, tolerance=1e-6
    )
    assert not convergence.converged and len(convergence.residual) == 3


@pytest.mark.parametrize("black", [0.02, 0.5, 1.0])
def test_black_elements_with_deflation(device, black):
    """Their own solution is 0: a share of a deflation vector there would be a residual that never falls."""
    rng = np.random.default_rng(17)
    matrix, area = closed_space(rng, 200)
    reflectance = np.where(rng.random((200, 8)) < black, 0.0, 0.95)
    direct = rng.random((200, 8))
    found, convergence = solved(device, matrix, area, reflectance, direct, deflate=True, tolerance=1e-4)
    assert convergence.converged and convergence.products < 16
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=2e-3)
