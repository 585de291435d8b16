"""Readings of one replicate in several goes: means by samples, goes that no longer count, and checkpoints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.readings.gathered import Gathered
from hradiosity.readings.sensors import ReadingSamples


def samples(irradiance, *, change=None, some_row=None):
    irradiance = np.asarray(irradiance, float)
    rows = np.full(len(irradiance), -1) if some_row is None else np.asarray(some_row)
    return ReadingSamples(irradiance, 0.5 * irradiance[:, 0], change, "mesh", rows)


def first_go(n):
    rng = np.random.default_rng(n)
    light = rng.random((n, 3))
    return Gathered(samples(light, change=0.1 * light), np.ones(n), None)


@given(st.lists(st.floats(0.25, 64.0), min_size=1, max_size=6))
def test_all_samples_count_alike(goes):
    """However they are split into goes: the value is the mean of all of them."""
    rng = np.random.default_rng(len(goes))
    gathered, chosen = first_go(4), np.array([1, 3])
    every = [(1.0, gathered.samples.irradiance[chosen])]
    for times in goes:
        light = rng.random((2, 3))
        every.append((times, light))
        more = samples(light, change=0.1 * light)
        gathered = gathered.with_more(chosen, more, np.full(2, times), np.zeros(2, bool))
    total = sum(times for times, _ in every)
    mean = sum(times * light for times, light in every) / total
    np.testing.assert_allclose(gathered.samples.irradiance[chosen], mean, rtol=1e-12)
    np.testing.assert_allclose(gathered.samples.enclosed[chosen], 0.5 * mean[:, 0], rtol=1e-12)
    np.testing.assert_allclose(gathered.samples.change[chosen], 0.1 * mean, rtol=1e-12)
    np.testing.assert_allclose(gathered.times, [1.0, total, 1.0, total], rtol=1e-12)


def test_others_stay_bit_for_bit_and_so_does_what_was_given():
    before = first_go(5)
    kept = before.samples.irradiance.copy()
    after = before.with_more(np.array([2]), samples([[9.0, 9.0, 9.0]]), np.array([3.0]), np.array([False]))
    others = [0, 1, 3, 4]
    np.testing.assert_array_equal(after.samples.irradiance[others], kept[others])
    np.testing.assert_array_equal(before.samples.irradiance, kept)


def test_goes_that_are_given_up_leave_nothing():
    before = Gathered(samples(np.ones((2, 1)), some_row=[7, 7]), np.array([4.0, 4.0]), None)
    more = samples([[5.0], [5.0]], some_row=[-1, -1])
    after = before.with_more(np.arange(2), more, np.array([2.0, 4.0]), np.array([True, False]))
    assert after.samples.irradiance.ravel() == pytest.approx([5.0, 3.0])
    assert after.times.tolist() == [2.0, 8.0]
    assert after.samples.some_row.tolist() == [-1, 7], "a row that the first go ended on is still known"


@pytest.mark.parametrize("unseen", [None, np.ones((3, 3))])
def test_a_checkpoint_brings_back_the_same_bits(unseen):
    before = first_go(3)
    before = Gathered(before.samples, np.array([1.0, 2.5, 8.0]), unseen)
    after = Gathered.restored(before.checkpoint())
    for name in ("irradiance", "enclosed", "change", "some_row"):
        np.testing.assert_array_equal(getattr(before.samples, name), getattr(after.samples, name))
    assert after.samples.changed_by == "mesh"
    np.testing.assert_array_equal(before.times, after.times)
    assert (after.unseen is None) == (unseen is None)
