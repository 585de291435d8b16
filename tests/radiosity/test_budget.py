"""Accuracy and time as budgets: what a run does next, and that it keeps what it promises."""

import time
from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.radiosity.budget import (
    Accuracies,
    Pace,
    Round,
    grown,
    growth_to_fill,
    next_round,
    replicates_needed,
    scaled,
)
from hradiosity.radiosity.pacer import Pacer
from hradiosity.radiosity.solver import RadiositySolver

SMALL = Options(elements=200, rays_per_element=128, light_points=8, light_samples=64, gather_samples=256, replicates=8)


def found(sampling, mesh=0.0, *, exchange=0.0, other=0.0, surfaces=0.0):
    sampling = np.atleast_1d(np.asarray(sampling, float))
    parts = (np.broadcast_to(np.asarray(part, float), sampling.shape) for part in (mesh, exchange, other))
    return Accuracies(sampling, *parts, surfaces)


def furnished_room():
    room = SceneBuilder(3)
    paint = room.material([0.5, 0.6, 0.3])
    faces = room.box((0, 0, 0), (3, 4, 2.5), paint, inward=True)
    room.box((1, 1, 0), (2, 2, 0.7), paint, solid=True)
    lamp = room.patch((1.2, 1.5, 2.4), (0, 1, 0), (0.6, 0, 0), paint)
    room.lamp(lamp, [800.0, 1000.0, 500.0])
    grid = np.stack(np.meshgrid(np.linspace(0.2, 2.8, 5), np.linspace(0.2, 3.8, 5)), -1).reshape(-1, 2)
    room.sensor(np.column_stack([grid, np.full(len(grid), 0.8)]), (0, 0, 1))
    assert len(faces) == 6
    return room.scene()


def test_half_the_error_takes_about_four_times_the_replicates():
    """A little fewer, since the quantile of Student falls as well: t(30) √8 < t(7) √31 / 2."""
    assert replicates_needed(found(0.02), 0.01, 8) == 25
    assert replicates_needed(found(0.01), 0.01, 8) == 8
    assert replicates_needed(found(0.02, other=0.011), 0.01, 8) is None


def test_more_of_the_same_while_that_is_cheap():
    assert next_round(found([0.012, 0.005]), 0.01, Round(SMALL), 8) is None


def test_unsure_readings_get_more_samples_and_sure_ones_as_many():
    larger = next_round(found([0.05] + [0.004] * 20), 0.01, Round(SMALL), 8)
    assert larger.focus[0] > 10.0
    np.testing.assert_allclose(larger.focus[1:], 1.0)
    assert larger.options.elements == SMALL.elements


def test_all_elements_shrink_when_the_mesh_part_of_most_readings_is_too_large():
    """Four times the accuracy, 8.9 times its share: 8.9^(2/1.5) = 18 times as many elements, or somewhat more."""
    many = np.full(4000, 0.005)
    larger = next_round(found(many, mesh=0.04), 0.01, Round(SMALL), 8)
    assert 18.0 <= larger.options.elements / SMALL.elements <= 22.0
    assert (larger.lookup == 1).all()
    by_edge = next_round(found(many, mesh=0.04), 0.01, Round(replace(SMALL, element_size=0.4)), 8)
    assert 18.0 <= (0.4 / by_edge.options.element_size) ** 2 <= 22.0


def test_few_readings_beside_large_elements_look_up_later():
    """That costs less than smaller elements everywhere; their paths vary more, and they get more of them."""
    mesh = np.zeros(400)
    mesh[:3] = 0.011
    larger = next_round(found(np.full(400, 0.009), mesh=mesh), 0.01, Round(replace(SMALL, elements=8000)), 8)
    assert larger.options.elements == 8000
    assert (larger.lookup[:3] == 3).all() and (larger.lookup[3:] == 1).all()
    assert (larger.focus[:3] > 2.0 * larger.focus[3]).all()


def test_rays_of_elements_follow_the_exchange_part_and_the_share_of_their_noise():
    few = next_round(found([0.005], exchange=0.01), 0.01, Round(SMALL), 8)
    assert few.options.rays_per_element == pytest.approx(4.0 * SMALL.rays_per_element, rel=0.01)
    own = next_round(found([0.05] * 9), 0.01, Round(SMALL), 8).options
    shared = next_round(found([0.05] * 9, surfaces=0.5), 0.01, Round(SMALL), 8).options
    assert own.rays_per_element == SMALL.rays_per_element < shared.rays_per_element / 20


def test_the_solver_goes_on_where_its_tolerance_is_what_is_left():
    tighter = next_round(found([0.005], other=0.012), 0.01, Round(SMALL), 8).options.tolerance
    assert tighter == pytest.approx(SMALL.tolerance / 3.0)
    assert type(tighter) is float, "records of runs and checkpoints are JSON"


def test_a_round_always_asks_for_something_else():
    """Whichever part is too large, or the run would repeat the round for ever."""
    for parts in ({"mesh": 0.009}, {"exchange": 0.009}, {"other": 0.009}):
        before = Round(SMALL)
        after = next_round(found([0.006], **parts), 0.01, before, 8)
        assert after.options != before.options or (after.lookup != SMALL.lookup).any()


def test_growth():
    assert grown(SMALL, elements=2.0, rays=3.0).rays_per_element == 384
    four = scaled(SMALL, 4.0)
    assert (four.elements, four.gather_samples, four.light_samples) == (400, 1024, 256)


def test_a_round_fills_the_time_it_is_given():
    pace = Pace(start=0.1, rows=0.2, readings=0.5)
    growth = growth_to_fill(pace, 8, 40.0)
    assert pace.seconds(8, elements=growth**0.5, samples=growth) == pytest.approx(40.0, rel=1e-6)


def test_pacer_stops_nearest_to_the_limit():
    pacer = Pacer.of(replace(SMALL, time=10.0))
    pacer.prepared(0.0)
    for end in (2.0, 4.0, 6.0, 8.0):
        pacer.replicated(end, 0.5 * end)
    assert pacer.wanted(found(0.1), 4, 8.9) > 4
    assert pacer.wanted(found(0.1), 4, 9.1) == 4


def test_a_fifth_of_the_time_is_left_for_an_audit():
    assert Pacer.of(replace(SMALL, time=10.0, audit=True)).limit == pytest.approx(8.0)


@pytest.mark.parametrize("accuracy", [0.05, 0.02])
def test_accuracy_is_reached_and_the_same_bits_come_again(device, accuracy):
    scene = furnished_room()
    results = []
    for _ in range(2):
        solver = RadiositySolver(scene, replace(SMALL, accuracy=accuracy), device)
        states = list(solver.states())
        assert solver.accuracy_reached and states[-1].error <= accuracy
        results.append(solver.solution().readings["s0"])
    assert float(results[0].accuracy.max()) <= accuracy
    np.testing.assert_array_equal(results[0].irradiance, results[1].irradiance)


def test_a_run_that_was_broken_off_in_a_larger_round_goes_on(device):
    scene, options = furnished_room(), replace(SMALL, accuracy=0.01)
    whole = RadiositySolver(scene, options, device)
    stages = [state.stage for state in whole.states()]
    assert "larger replicates" in stages
    first = RadiositySolver(scene, options, device)
    for count, _ in enumerate(first.states()):
        if count == stages.index("larger replicates") + 3:
            break
    second = RadiositySolver(scene, options, device)
    second.restore(first.checkpoint())
    list(second.states())
    np.testing.assert_array_equal(
        whole.solution().readings["s0"].irradiance, second.solution().readings["s0"].irradiance
    )


def test_time_is_kept(device):
    """To a tenth and half a replicate, once kernels are built; a larger limit gives narrower intervals."""
    scene, errors = furnished_room(), []
    for limit in (1.5, 6.0):
        solver = RadiositySolver(scene, replace(SMALL, time=limit), device)
        start = time.perf_counter() - device.build_time.wall
        states = list(solver.states())
        spent = time.perf_counter() - device.build_time.wall - start
        each = states[-1].seconds - states[-2].seconds
        assert spent <= 1.1 * limit + each + 0.5
        errors.append(states[-1].median_error)
    assert errors[1] < errors[0]
