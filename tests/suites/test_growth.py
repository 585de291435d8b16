"""Figures of the suite about scenes that grow."""

import math

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity import Options, solve
from hradiosity.suites.growth import SAMPLE, Step, exponent, of_sample, sampled


def test_exponent_is_the_power():
    assert exponent([1, 2, 5, 20], [3 * n**1.5 for n in (1, 2, 5, 20)]) == pytest.approx(1.5)
    assert math.isnan(exponent([1], [1]))


def test_seconds_at_one_error_grow_with_its_square():
    """2 % in 10 s, of which the reference's noise is 1.2 %: own error 1.6 %, so 1 % takes 25.6 s."""
    step = Step("hall", 1, 1, 1, 1, 1, 10.0, {}, None, 0.02, 0.02, 0.0, 0.012, 0.01, 0.95)
    assert step.equal_seconds == pytest.approx(25.6)


def test_sample_is_some_of_the_readings(device):
    b = SceneBuilder()
    room = b.box((0, 0, 0), (2, 2, 2), b.material(0.5), inward=True)
    b.lamp(room[5], 10.0)
    b.sensor([(0.3, 0.5, 0.2), (1.0, 1.0, 0.4)], (0, 0, 1), "low")
    b.sensor([(0.3, 0.5, 1.2), (1.0, 1.0, 1.4), (1.5, 0.2, 1.1)], (0, 1, 0), "high")
    scene = b.scene()
    few, drawn = sampled(scene, 3)
    solution = solve(scene, Options(elements=100, gather_samples=64, light_samples=64, replicates=2), device)
    found = of_sample(solution.readings, drawn)[SAMPLE]
    np.testing.assert_array_equal(found.position, few.sensors[0].position)
    np.testing.assert_array_equal(found.normal, few.sensors[0].normal)
    every = np.concatenate([solution.readings[name].illuminance for name in ("low", "high")])
    np.testing.assert_array_equal(found.illuminance, every[drawn])
    assert (found.half_width > 0.0).all()
