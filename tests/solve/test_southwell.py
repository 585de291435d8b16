"""Shooting against gathering, against a dense solution, and against conjugate gradients."""

import numpy as np
import pytest
from box_rooms import CASES, box_room
from scipy.sparse import csr_array

from hradiosity.reference.radiosity import solve_dense
from hradiosity.solvers.krylov import solve_irradiance
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.southwell import ShootingSystem, shoot, shooting_weights
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import Exchange, build_exchange, trace_rows


def room_exchange(device, size, rays=1024):
    """Exchange of a box room, 4 × 4 × 3 m."""
    scene = box_room(CASES["room443-panel-752"])
    space = np.repeat([[0, -1]], len(scene.patches), axis=0)
    elements = build_elements(scene.patches, space, np.ones(6, bool), size)
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=False)
    return build_exchange(trace_rows(on_device, upload_elements(device, elements), rays, 1), elements)


def lamp_over_floor():
    """K of a small lamp (2 elements) over a large floor (16), made up but reciprocal; much light leaves."""
    area = np.concatenate([np.full(2, 0.01), np.full(16, 1.0)])
    exchange = np.zeros((18, 18))
    share = np.linspace(0.01, 0.09, 16)
    exchange[:2, 2:] = 0.01 * share
    exchange[2:, :2] = exchange[:2, 2:].T
    exchange[2:, 2:] = 1e-3 * (1.0 - np.eye(16))
    exchange[3, 3] = 0.02
    return exchange, area


def dense(exchange: Exchange):
    n = len(exchange.element_area)
    return csr_array((exchange.area, exchange.source.astype(np.int64), exchange.start.astype(np.int64)), shape=(n, n))


def system_of(exchange, area, reflectance, direct):
    """Shooting system over a stored exchange."""
    matrix = csr_array(exchange)
    return ShootingSystem(area, reflectance, direct, lambda chosen: csr_array(matrix[chosen]))


@pytest.mark.parametrize("batch", [1, 3])
def test_shooting_and_gathering_agree_after_every_shot(batch):
    rng = np.random.default_rng(1)
    exchange, area = lamp_over_floor()
    reflectance, direct = rng.uniform(0.2, 0.9, (18, 3)), rng.uniform(0.0, 5.0, (18, 3))
    steps = 0
    for state in shoot(
        system_of(exchange, area, reflectance, direct), np.ones(3), tolerance=1e-10, batch=batch, max_shots=400
    ):
        gathered = direct + exchange @ state.shot / area[:, None]
        np.testing.assert_allclose(state.irradiance, gathered, rtol=1e-12)
        np.testing.assert_allclose(state.unshot, reflectance * gathered - state.shot, rtol=1e-9, atol=1e-12)
        steps += 1
    assert steps > 10
    assert state.residual <= 1e-10


def test_shooting_and_gathering_agree_in_a_room(device):
    rng = np.random.default_rng(2)
    exchange = room_exchange(device, 1.0, 256)
    matrix, area = dense(exchange), exchange.element_area
    reflectance = rng.uniform(0.1, 0.9, (len(area), 4))
    direct = rng.uniform(0.0, 1.0, (len(area), 4)) ** 8
    system = system_of(matrix, area, reflectance, direct)
    for state in shoot(system, np.ones(4), tolerance=1e-6, batch=1, max_shots=200):
        residual = reflectance * (direct + (matrix @ state.shot) / area[:, None]) - state.shot
        assert np.abs(state.unshot - residual).max() < 1e-12


def test_shooting_ends_where_conjugate_gradients_end(device):
    rng = np.random.default_rng(3)
    exchange = room_exchange(device, 0.5, 64)
    n = len(exchange.element_area)
    reflectance = rng.uniform(0.05, 0.8, (n, 8)).astype(np.float32)
    direct = rng.uniform(0.0, 1.0, (n, 8)).astype(np.float32)
    gathered, _ = solve_irradiance(ExchangeOperator(device, exchange), reflectance, direct, tolerance=1e-6)
    system = system_of(dense(exchange), exchange.element_area, reflectance.astype(float), direct.astype(float))
    *_, last = shoot(system, np.ones(8), tolerance=1e-6, batch=16, max_shots=100 * n)
    assert np.abs(last.irradiance / gathered - 1.0).max() < 2e-5


def test_each_column_has_a_solution_of_its_own():
    exchange, area = lamp_over_floor()
    rng = np.random.default_rng(4)
    reflectance, direct = rng.uniform(0.0, 0.95, (18, 5)), rng.uniform(0.0, 1.0, (18, 5))
    direct[:, 2] = 0.0
    *_, last = shoot(system_of(exchange, area, reflectance, direct), np.ones(5), tolerance=1e-12, max_shots=10000)
    np.testing.assert_allclose(last.irradiance, solve_dense(exchange, area, reflectance, direct), rtol=1e-9)


@pytest.mark.parametrize(("reflectance", "least", "most"), [(0.5, 2.5, 7.0), (0.8, 9.0, 22.0), (0.95, 45.0, 95.0)])
def test_shots_grow_with_reflectance_as_known(device, reflectance, least, most):
    """Shots over elements for 1e-3 of the irradiance: 4.6, 15 and 68 were found for a room of 504 elements."""
    exchange = room_exchange(device, 0.8, 256)
    matrix, area = dense(exchange), exchange.element_area
    n = len(area)
    paint, direct = np.full((n, 1), reflectance), np.zeros((n, 1))
    direct[area.argmax()] = 1.0
    exact = solve_dense(matrix.toarray(), area, paint, direct)
    for state in shoot(
        system_of(matrix, area, paint, direct), np.ones(1), tolerance=1e-9, batch=max(1, n // 32), max_shots=300 * n
    ):
        estimate = state.irradiance + (matrix @ state.unshot) / area[:, None]
        if np.abs(estimate / exact - 1.0).max() < 1e-3:
            break
    assert least < state.shots / n < most


def test_dim_bands_keep_a_weight():
    luminous = np.array([0.0, 683.0, 0.0])
    weight = shooting_weights(np.eye(3), luminous)
    assert weight.min() > 0.0
    assert weight[0] == pytest.approx(1e-3 * luminous.mean())
    combined = shooting_weights(np.array([[1.0, 2.0, 0.0]]), luminous)
    assert combined[0] == pytest.approx(weight[0] + 2.0 * weight[1])


def test_elements_without_area_take_no_part():
    exchange, area = lamp_over_floor()
    exchange[5] = exchange[:, 5] = 0.0
    area[5] = 0.0
    system = system_of(exchange, area, np.full((18, 1), 0.5), np.ones((18, 1)))
    *_, last = shoot(system, np.ones(1), tolerance=1e-6, max_shots=1000)
    assert np.isfinite(last.irradiance).all()
    assert last.shot[5] == 0.0
