"""Elements beside narrow openings are split, and readings behind them become right; elsewhere nothing is."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity.options import Options
from hradiosity.radiosity.refinement import ROUNDS, GreyLight
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.suites.referee_cache import referee_readings

COARSE = Options(
    element_size=0.25, rays_per_element=512, light_points=16, light_samples=64, gather_samples=4096, replicates=4
)


def gap_rooms():
    """Two rooms joined by a gap of 4 cm in a wall of 8 cm; the lamp in one, readings in the other."""
    b = SceneBuilder()
    paint = b.material(0.7)
    b.box((0, 0, 0), (2.08, 1, 1), paint, inward=True)
    b.box((1, 0, 0), (1.08, 0.48, 1), paint, solid=True)
    b.box((1, 0.52, 0), (1.08, 1, 1), paint, solid=True)
    b.lamp(b.patch((0.25, 0.1, 0.98), (0, 0.2, 0), (0.5, 0, 0), paint), 1000.0)
    x, y = np.meshgrid([1.3, 1.5, 1.7, 1.9], [0.1, 0.2, 0.3, 0.7, 0.8, 0.9])
    b.sensor(np.column_stack([x.ravel(), y.ravel(), np.full(24, 0.5)]), (0, 0, 1))
    return b.scene()


def finished(scene, options, device):
    solver = RadiositySolver(scene, options, device)
    for _ in solver.states():
        pass
    return solver


def effect_of(solver):
    (effect,) = (e for e in solver.solution().plan.effects if e.name == "refinement")
    return effect


def lux(solver):
    return solver.solution().readings["s0"].numbers["illuminance"].value


def test_readings_behind_a_gap(device):
    """An element as deep as the gap is as bright at its dark end as at the other: against unbiased paths, readings
    beyond are a tenth too bright; on split elements they are right but for noise.
    """
    scene = gap_rooms()
    exact = referee_readings(scene, device, 65536)["s0"].numbers["illuminance"].value

    def bias(**changes):
        runs = [finished(scene, replace(COARSE, seed=seed, **changes), device) for seed in range(3)]
        return np.mean([(lux(run) / exact - 1.0).mean() for run in runs]), runs

    without, plain = bias(refinement=False)
    split, refined = bias()
    assert without > 0.08 and abs(split) < 0.05
    assert all(effect_of(run).needed for run in refined) and not any(effect_of(run).needed for run in plain)
    for one, other in zip(plain, refined):
        before, after = len(one.solution().elements), len(other.solution().elements)
        assert before < after <= 2 * before
        assert other.plan.n_elements == after and f"{before} of them became {after}" in effect_of(other).because
        area = other.solution().elements.area
        assert area.sum() == pytest.approx(one.solution().elements.area.sum(), rel=1e-9)
        assert area.min() >= one.solution().elements.area.min() / 4**ROUNDS * 0.999


def test_nothing_is_split_in_a_plain_room(device):
    """And the numbers are those of a run without refinement, bit for bit."""
    room = cube(0.6)
    room.lamp(room.patch((0.3, 0.3, 0.99), (0, 0.4, 0), (0.4, 0, 0), 0), 100.0)
    room.sensor([(0.3, 0.2, 0.4), (0.8, 0.7, 0.1)], (0, 0, 1))
    scene = room.scene()
    plain, looked = (finished(scene, replace(COARSE, refinement=kind), device) for kind in (False, None))
    assert not effect_of(looked).needed and "about" in effect_of(looked).because
    assert "asked" in effect_of(plain).because
    np.testing.assert_array_equal(lux(plain), lux(looked))


def test_without_readings_nothing_is_split(device):
    scene = replace(gap_rooms(), sensors=())
    solver = finished(scene, replace(COARSE, replicates=2), device)
    assert not effect_of(solver).needed and "reading" in effect_of(solver).because


@pytest.mark.parametrize("done", [0, 1])
def test_a_run_that_is_resumed_has_the_same_bits(device, done):
    scene, options = gap_rooms(), replace(COARSE, gather_samples=64, replicates=3)
    whole = finished(scene, options, device)
    first = RadiositySolver(scene, options, device)
    for state in first.states():
        if state.replicate == done:
            break
    resumed = RadiositySolver(scene, options, device)
    resumed.restore(first.checkpoint())
    for _ in resumed.states():
        pass
    np.testing.assert_array_equal(lux(whole), lux(resumed))
    assert effect_of(whole) == effect_of(resumed)
    assert len(whole.solution().elements) == len(resumed.solution().elements)


def test_a_broken_replicate_takes_its_splits_back(device):
    """As after Ctrl-C in the first replicate, after its elements were split."""
    scene, options = gap_rooms(), replace(COARSE, gather_samples=64, replicates=2)
    solver = RadiositySolver(scene, options, device)
    before = solver.checkpoint()
    for state in solver.states():
        if state.replicate == 1:
            break
    split = len(solver.solution().elements)
    solver.restore(before)
    assert solver.plan.n_elements < split
    for _ in solver.states():
        pass
    np.testing.assert_array_equal(lux(solver), lux(finished(scene, options, device)))


def test_more_is_split_on_request(device):
    scene, options = gap_rooms(), replace(COARSE, gather_samples=64, replicates=2)
    usual, forced = (finished(scene, replace(options, refinement=kind), device) for kind in (None, True))
    assert len(forced.solution().elements) >= len(usual.solution().elements)
    assert effect_of(forced).needed


def test_glow_is_not_reflected():
    """What shines by itself brings light and reflects no more for it."""
    one = np.ones((2, 1), np.float32)
    light = GreyLight.of(np.array([2.0]), one, 0.5 * one, 3.0 * one, np.zeros((0, 1), np.float32), sky=one[0])
    assert light.leaving.tolist() == [7.0, 7.0] and light.reflectance.tolist() == [0.5, 0.5] and light.sky == 2.0
