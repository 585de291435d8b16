"""Accuracy and time as budgets: what a run does next, and that it keeps what it promises."""

import time
from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.radiosity.accuracies import Accuracies
from hradiosity.radiosity.budget import (
    MOST_STEPS,
    Pace,
    grown,
    growth_to_fill,
    next_step,
    replicates_needed,
    scaled,
)
from hradiosity.radiosity.pacer import Pacer
from hradiosity.radiosity.reading_pace import ReadingPace
from hradiosity.radiosity.remedy import DOUBT, LEAST_ROOM, Held, cheapest_remedy, goes_needed, in_the_way
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.readings.later_lookups import Lookups

SMALL = Options(elements=200, rays_per_element=128, light_points=8, light_samples=64, gather_samples=256, replicates=8)


def found(sampling, mesh=0.0, *, exchange=0.0, other=0.0, common=0.0):
    sampling = np.atleast_1d(np.asarray(sampling, float))
    parts = (np.broadcast_to(np.asarray(part, float), sampling.shape) for part in (mesh, exchange, other, common))
    return Accuracies(sampling, *parts)


def held(accuracies, *, paths=100.0, times=1.0, lookup=1, steps=4, elements=200):
    """After steps that were taken to be surer, unless others are said."""
    n = len(accuracies.sampling)
    many = [np.full(n, some) for some in (paths, times)]
    one_go = accuracies.own**2 * many[1]
    return Held(*many, np.full(n, lookup), np.full(n, steps), one_go, Lookups.usual(1, n), elements)


def step_for(accuracies, accuracy=0.01, *, options=None, **kept):
    return next_step(accuracies, accuracy, SMALL if options is None else options, held(accuracies, **kept))


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


def test_sure_readings_are_left_alone_and_others_get_what_they_lack():
    """Twice the half width that is wanted takes four times the samples, three of them anew; far more come by steps."""
    accuracies = found([0.02, 0.009, 0.3])
    step = step_for(accuracies, 0.01)
    assert not step.larger and step.options == SMALL and not step.anew.any()
    assert step.times[1] == 0.0 and step.times[2] == 3.0
    assert 3.0 <= goes_needed(accuracies, 0.01, held(accuracies))[0] <= 8.0
    assert step_for(found([0.009, 0.01])) is None


def test_noise_of_the_elements_is_not_chased_with_samples():
    """Where most of the spread is theirs, elements send more rays, until samples have something left to narrow."""
    samples = step_for(found(np.full(400, 0.012), common=0.003), paths=1e4)
    assert not samples.larger
    rays = step_for(found(np.full(400, 0.03), common=0.028), paths=1e4)
    assert rays.larger and rays.anew.all()
    growth = rays.options.rays_per_element / SMALL.rays_per_element * rays.options.elements / SMALL.elements
    assert growth >= 0.028**2 / ((1.0 - LEAST_ROOM) * 0.01**2)


def test_after_many_steps_what_is_left_counts_as_noise_of_the_elements():
    step = step_for(found(np.full(400, 0.02)), paths=1e4, steps=MOST_STEPS, times=64.0)
    assert step.larger and step.options.rays_per_element > SMALL.rays_per_element


def test_all_elements_shrink_when_the_mesh_part_of_most_readings_is_too_large():
    """Four times the accuracy, 6.2 times what leaves room for noise: 6.2^(2/1.5) = 11 times the elements or more."""
    many = found(np.full(4000, 0.005), mesh=0.04)
    larger = step_for(many, paths=1e4)
    growth = larger.options.elements / SMALL.elements
    assert 11.0 <= growth <= 32.0
    assert (larger.lookup == 1).all() and larger.anew.all()
    by_edge = step_for(many, options=replace(SMALL, element_size=0.4), paths=1e4)
    assert (0.4 / by_edge.options.element_size) ** 2 == pytest.approx(growth, rel=1e-3)


def test_few_readings_beside_large_elements_look_up_later():
    """That costs less than smaller elements everywhere; their paths vary more, and they get more of them."""
    mesh = np.zeros(400)
    mesh[:3], mesh[3] = 0.011, 0.08
    step = step_for(found(np.full(400, 0.009), mesh=mesh), options=replace(SMALL, elements=8000), elements=8000)
    assert not step.larger
    assert (step.lookup[:3] == 3).all() and step.lookup[3] == 7 and (step.lookup[4:] == 1).all()
    assert step.anew[:4].all() and (step.times[:4] > 1.0).all() and not step.times[4:].any()


def test_one_stubborn_reading_does_not_decide_for_all():
    """Others that lack accuracy for another reason keep what they have."""
    mesh = np.zeros(1000)
    mesh[7] = 0.05
    step = step_for(found(np.full(1000, 0.012), mesh=mesh), elements=40_000, options=replace(SMALL, elements=40_000))
    assert not step.larger and step.options.elements == 40_000
    assert step.anew[7] and np.count_nonzero(step.anew) == 1 and (step.times > 0.0).all()


def test_the_cheapest_is_no_dearer_than_any_other():
    """Against all growths by hand, with one lookup for all: the choice for each reading can only be cheaper."""
    generator = np.random.default_rng(3)
    mesh, noise = generator.uniform(0.0, 0.03, 60), generator.uniform(0.005, 0.03, 60)
    accuracies = found(noise, mesh=mesh, exchange=0.2 * mesh)
    kept = held(accuracies, paths=500.0)
    remedy = cheapest_remedy(accuracies, 0.01, SMALL, kept, accuracies.total > 0.01)
    lacking = accuracies.total > 0.01
    prices = []
    for growth in 2.0 ** np.arange(0.5, 8.0, 0.5):
        for level, hit in enumerate(kept.lookups.hits):
            gain = kept.lookups.gain[0, level]
            left = DOUBT**2 * ((mesh / growth**0.75) ** 2 + (0.2 * mesh) ** 2) / gain**2
            room = 0.01**2 - left
            if (room[lacking] < LEAST_ROOM * 0.01**2).any():
                continue
            goes = np.maximum(1.15 * kept.one_go * kept.lookups.noise[0, level] / room, 1.0)
            readings = SMALL.replicates * kept.price(np.where(lacking, goes, 0.0), np.full(60, hit))
            prices.append(readings + 400.0 * growth * 200)
    assert prices and remedy.price <= min(prices)


def test_what_samples_do_not_mend_is_told_apart():
    accuracies = found([0.02, 0.02, 0.005], mesh=[0.001, 0.02, 0.02])
    assert in_the_way(accuracies, 0.01, SMALL, held(accuracies)).tolist() == [False, True, True]


def test_samples_come_before_smaller_elements_while_they_are_cheap():
    """A mesh part of few samples is noise; the step after the next would be dearer by far."""
    first = step_for(found(np.full(50, 0.05), mesh=0.04), steps=0)
    assert not first.larger and (first.times == 3.0).all() and not first.anew.any()
    paid = step_for(found(np.full(50, 0.006), mesh=0.04), steps=1, times=400.0)
    assert paid.larger or (paid.lookup > 1).all(), "what would be given up has cost enough"
    after = step_for(found(np.full(50, 0.005), mesh=0.04))
    assert after.larger or (after.lookup > 1).all()


def test_rays_of_elements_follow_the_exchange_part():
    few = step_for(found(np.full(100, 0.005), exchange=0.02), paths=1e5)
    assert few.larger and few.options.rays_per_element >= 2.0 * SMALL.rays_per_element


def test_no_round_is_begun_for_a_handful_of_rays():
    """The exchange part is a little too large: its estimate is no better than that."""
    exchange = np.full(100, 0.001)
    exchange[0] = 0.0085
    barely = step_for(found(np.full(100, 0.012), exchange=exchange), paths=1e5, lookup=7)
    assert barely.larger and barely.options.rays_per_element >= 1.5 * SMALL.rays_per_element


def test_the_solver_goes_on_where_its_tolerance_is_what_is_left():
    """And all readings are taken anew, since the tolerance is part of each of them."""
    tighter = step_for(found([0.005, 0.001], other=[0.012, 0.001]))
    assert tighter.options.tolerance == pytest.approx(SMALL.tolerance / 3.0)
    assert type(tighter.options.tolerance) is float, "records of runs and checkpoints are JSON"
    assert tighter.anew.all()


def test_a_step_always_does_something():
    """Whichever part is too large, or the run would repeat the step for ever."""
    for parts in ({"mesh": 0.009}, {"exchange": 0.009}, {"other": 0.009}, {"common": 0.006}):
        for steps in range(MOST_STEPS + 1):
            after = step_for(found([0.012], **parts), steps=steps)
            assert after.larger == (after.options != SMALL)
            assert after.times[0] > 0.0


def test_elements_that_do_not_come_are_not_asked_for_again():
    """A room of small patches has no more of them; the readings that are off look later, and then nothing is left."""
    off = found(np.full(400, 0.005), mesh=0.04)
    later = step_for(off, paths=1e6, options=replace(SMALL, elements=2000), elements=200)
    assert not later.larger and (later.lookup >= 5).all()
    assert step_for(off, paths=1e6, options=replace(SMALL, elements=2000), elements=200, lookup=7) is None
    most = step_for(off, paths=1e9, options=replace(SMALL, elements=1_000_000), elements=1_000_000, lookup=7)
    assert most is None or most.options.elements <= 2_500_000


def test_smaller_elements_are_asked_for_by_their_edge():
    """A number of them is bounded by the room's size; an edge is not, and twice as many have 0.71 of it."""
    off = found(np.full(4000, 0.005), mesh=0.04)
    options = replace(SMALL, elements=2000)
    larger = next_step(off, 0.01, options, replace(held(off, paths=1e4), edge=0.4))
    growth = larger.options.elements / options.elements
    assert larger.larger and growth > 4.0
    assert larger.options.element_size == pytest.approx(0.4 / growth**0.5, rel=1e-3)


def test_what_nothing_mends_is_left_and_the_run_ends():
    at_the_end = replace(SMALL, tolerance=1e-6)
    assert step_for(found([0.005], other=0.02), options=at_the_end) is None


def test_readings_take_so_long_for_each_path_and_some_however_few():
    """0.05 s and 2 µs a path, read off goes of any size, a tenth of which is chance."""
    generator = np.random.default_rng(1)
    pace = ReadingPace()
    for price in (1e3, 1e4, 4e4, 3e5) * 8:
        pace.learn(price, (0.05 + 2e-6 * price) * generator.uniform(0.9, 1.1))
    assert pace.seconds(1e7) == pytest.approx(20.05, rel=0.1)
    assert pace.seconds(100.0) == pytest.approx(0.0502, rel=0.1)
    assert pace.seconds(0.0) == 0.0


def test_goes_of_one_price_tell_the_seconds_of_a_path_alone():
    pace = ReadingPace()
    assert pace.seconds(5.0) == 0.0
    pace.learn(100.0, 1.0)
    pace.learn(100.0, 1.0)
    assert pace.seconds(300.0) == pytest.approx(3.0)
    pace.learn(400.0, 0.5)
    assert pace.seconds(800.0) > 0.0


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
        pacer.replicated(end, 0.5 * end, 100.0)
    assert pacer.wanted(found(0.1), 4, 8.9) > 4
    assert pacer.wanted(found(0.1), 4, 9.1) == 4


def test_a_step_is_cut_to_the_time_that_is_left():
    """Eight replicates of 100 paths take 8 s; three times as many would take 24 s, and 12 s are left."""
    pacer = Pacer.of(replace(SMALL, accuracy=0.001, time=20.0))
    pacer.prepared(0.0)
    for end in range(1, 9):
        pacer.replicated(float(end), float(end), 100.0)
    accuracies = found([0.1])
    step = pacer.next_step(accuracies, 8, held(accuracies), 8.0)
    assert 1.2 <= step.times[0] <= 1.5
    assert pacer.next_step(accuracies, 8, held(accuracies), 19.9) is None


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


@pytest.mark.parametrize(("stage", "price"), [("further samples", 400.0), ("larger replicates", 1.0)])
def test_a_run_that_was_broken_off_in_a_step_goes_on(device, monkeypatch, stage, price):
    """With the same bits, though the light that it reads again has to be computed once more."""
    monkeypatch.setattr("hradiosity.radiosity.remedy.ELEMENT_PATHS", price)
    scene, options = furnished_room(), replace(SMALL, elements=60, accuracy=0.006)
    whole = RadiositySolver(scene, options, device)
    stages = [state.stage for state in whole.states()]
    expected = whole.solution().readings["s0"].irradiance
    first = RadiositySolver(scene, options, device)
    for count, _ in enumerate(first.states()):
        if count == stages.index(stage) + 3:
            break
    second = RadiositySolver(scene, options, device)
    second.restore(first.checkpoint())
    list(second.states())
    np.testing.assert_array_equal(expected, second.solution().readings["s0"].irradiance)


def test_illuminances_alone_tell_the_same_as_everything(device):
    """Bit for bit: what decides about further samples must not depend on who asked for colours in between."""
    solver = RadiositySolver(furnished_room(), replace(SMALL, accuracy=0.02), device)
    steps = 0
    for state in solver.states():
        if state.stage == "further samples" and state.replicate == 8:
            alone = solver._reader.illuminances.readings(illuminance_only=True)["s0"].numbers["illuminance"]
            whole = solver._reader.moments.readings()["s0"].numbers["illuminance"]
            np.testing.assert_array_equal(alone.value, whole.value)
            np.testing.assert_array_equal(alone.half_width, whole.half_width)
            steps += 1
    assert steps > 0


def test_readings_that_are_sure_stay_as_they_are(device):
    """Bit for bit: their samples are not repeated, whatever happens to the others."""
    scene, options = furnished_room(), replace(SMALL, accuracy=0.02)
    solver = RadiositySolver(scene, options, device)
    before = None
    for state in solver.states():
        if state.stage == "replicate" and state.replicate == 8 and before is None:
            before = solver.solution().readings["s0"]
    after = solver.solution().readings["s0"]
    sure = before.accuracy <= 0.02
    assert 0 < np.count_nonzero(sure) < len(sure)
    np.testing.assert_array_equal(before.irradiance[sure], after.irradiance[sure])
    assert (before.irradiance[~sure] != after.irradiance[~sure]).any(axis=1).all()


def test_light_that_was_not_kept_is_computed_again(device, monkeypatch):
    scene, options = furnished_room(), replace(SMALL, accuracy=0.02)
    results = []
    for kept in (768 * 2**20, 0):
        monkeypatch.setattr("hradiosity.radiosity.round.KEPT_LIGHT_BYTES", kept)
        solver = RadiositySolver(scene, options, device)
        assert "further samples" in [state.stage for state in solver.states()]
        results.append(solver.solution().readings["s0"].irradiance)
    np.testing.assert_array_equal(*results)


def test_a_run_without_an_accuracy_can_go_on_to_one(device):
    """From its own readings, by the light of its replicates, which is computed once more."""
    scene = furnished_room()
    plain = RadiositySolver(scene, SMALL, device)
    list(plain.states())
    going_on = RadiositySolver(scene, replace(SMALL, accuracy=0.02, replicates=4), device)
    going_on.restore(plain.checkpoint())
    assert {state.stage for state in going_on.states()} == {"geometry", "further samples"}
    assert going_on.accuracy_reached
    before, after = (some.solution().readings["s0"] for some in (plain, going_on))
    sure = before.accuracy <= 0.02
    np.testing.assert_array_equal(before.irradiance[sure], after.irradiance[sure])
    assert after.accuracy.max() <= 0.02 < before.accuracy.max()


def test_where_samples_are_not_kept_more_replicates_do(device, monkeypatch):
    monkeypatch.setattr("hradiosity.radiosity.point_reader.KEPT_SAMPLE_BYTES", 0)
    solver = RadiositySolver(furnished_room(), replace(SMALL, accuracy=0.02), device)
    assert {state.stage for state in solver.states()} == {"geometry", "replicate"}
    assert solver.accuracy_reached and solver.replicates > 8


def test_time_is_kept_where_an_accuracy_is_out_of_reach(device):
    """Whatever step the run is in then; what it has is better than without a step. Kernels are there before."""
    scene = furnished_room()
    list(RadiositySolver(scene, replace(SMALL, accuracy=0.005), device).states())
    solver = RadiositySolver(scene, replace(SMALL, accuracy=1e-4, time=4.0), device)
    start = time.perf_counter() - device.build_time.wall
    states = list(solver.states())
    assert time.perf_counter() - device.build_time.wall - start <= 5.0
    assert not solver.accuracy_reached
    assert states[-1].median_error < 0.5 * next(s for s in states if s.replicate == 8).median_error
    assert solver.solution().readings["s0"].accuracy.max() < 0.1


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
