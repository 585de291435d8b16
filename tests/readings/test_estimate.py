"""Intervals: what they are made of, and how often they hold."""

import numpy as np
import pytest

from hradiosity.estimate import EXCHANGE, MESH, Estimate, student_quantile
from hradiosity.model.scene import Sensor
from hradiosity.model.spectrum import Bands
from hradiosity.readings.companions import COMPANIONS, LEAST_COMPANIONS, likely_parts
from hradiosity.readings.interval import RunningMean, RunningMoments
from hradiosity.readings.moments import ReadingMoments, ReplicateReadings
from hradiosity.readings.pooling import COMMON, alike, pooled

BANDS = Bands.uniform(380.0, 780.0, 50.0)


def sensor(n):
    return Sensor("desk", np.zeros((n, 3)), np.tile([0.0, 0.0, 1.0], (n, 1)))


def test_quantiles_of_student():
    """Printed in every table of the t distribution."""
    assert student_quantile(0.95, 7) == pytest.approx(2.3646, abs=1e-4)
    assert student_quantile(0.80, 3) == pytest.approx(1.6377, abs=1e-4)
    assert student_quantile(0.50, 1) == pytest.approx(1.0, abs=1e-12)


def test_parts_combine_in_quadrature_and_only_sampling_grows_with_the_level():
    estimate = Estimate(np.array(10.0), np.array(0.3), 7, {"mesh": np.array(0.4), "iteration": np.array(0.1)})
    for level in (0.5, 0.8, 0.95):
        sampling = student_quantile(level, 7) * 0.3
        assert estimate.half_width_at(level) == pytest.approx(np.sqrt(sampling**2 + 0.17))
    assert estimate.half_width == estimate.half_width_at(0.95)
    assert list(estimate.parts) == ["sampling", "mesh", "iteration"]


def test_one_replicate_has_no_interval():
    assert np.isinf(Estimate(np.zeros(3), np.full(3, np.inf), 0).half_width).all()


@pytest.mark.parametrize("level", [0.5, 0.8, 0.95])
def test_intervals_of_normal_replicates_hold_as_often_as_they_say(level):
    rng = np.random.default_rng(3)
    moments = RunningMoments((20_000,))
    for _ in range(8):
        moments.add(rng.normal(5.0, 1.0, 20_000))
    estimate = Estimate(moments.mean, moments.standard_error, 7)
    held = np.mean(np.abs(estimate.value - 5.0) <= estimate.half_width_at(level))
    assert held == pytest.approx(level, abs=4.0 * np.sqrt(level * (1.0 - level) / 20_000))


def test_running_sums_are_those_of_numpy_and_survive_a_checkpoint():
    samples = np.random.default_rng(1).normal(3.0, 2.0, (6, 5))
    mean, moments = RunningMean((5,)), RunningMoments((5,))
    for sample in samples[:3]:
        mean.add(sample)
        moments.add(sample)
    again = RunningMoments((5,))
    again.restore(moments.checkpoint())
    for sample in samples[3:]:
        mean.add(sample)
        again.add(sample)
    np.testing.assert_allclose(mean.mean, samples.mean(axis=0), rtol=1e-14)
    np.testing.assert_allclose(again.standard_error, samples.std(axis=0, ddof=1) / np.sqrt(6), rtol=1e-13)
    with pytest.raises(ValueError, match="shape"):
        RunningMoments((4,)).restore(moments.checkpoint())


def filled(changes, n=6, replicates=8, level=1.0):
    moments = ReadingMoments((sensor(n),), BANDS)
    rng = np.random.default_rng(5)
    for change in changes[:replicates]:
        spectra = level * (1.0 + 0.01 * rng.normal(size=(n, len(BANDS))))
        moments.add(ReplicateReadings(spectra, np.zeros(n), change))
    return moments


def test_mesh_part_is_a_share_of_the_change_by_coarser_elements():
    n = 6
    change = np.full((n, len(BANDS)), 0.02)
    readings = filled([change, None] * 4).readings()["desk"]
    np.testing.assert_allclose(readings.numbers["irradiance"].parts["mesh"], COMPANIONS[MESH] * 0.02, rtol=1e-12)
    lux = readings.numbers["illuminance"]
    np.testing.assert_allclose(lux.parts["mesh"] / lux.value, COMPANIONS[MESH] * 0.02, rtol=0.02)
    np.testing.assert_allclose(readings.numbers["chromaticity"].parts["mesh"], 0.0, atol=1e-3)


def test_without_companions_there_is_no_mesh_part():
    assert "mesh" not in filled([None] * 8).readings()["desk"].numbers["illuminance"].parts


def test_shared_errors_scale_powers_and_tilt_colours():
    readings = filled([None] * 8).readings({"iteration": 0.01})["desk"]
    numbers = readings.numbers
    np.testing.assert_allclose(numbers["illuminance"].parts["iteration"], 0.01 * readings.illuminance, rtol=1e-12)
    assert float(numbers["uniformity"].parts["iteration"]) == pytest.approx(0.02 * readings.uniformity)
    shift = numbers["chromaticity"].parts["iteration"]
    assert (shift > 1e-4).all() and (shift < 0.01).all()


def test_readings_that_no_ray_found_lit_have_the_rule_of_three():
    """3/N of what one ray could have brought: here 8 replicates of 100 rays that might each bring 2."""
    n = 2
    moments = ReadingMoments((sensor(n),), BANDS)
    for _ in range(8):
        unseen = np.zeros((n, len(BANDS)))
        unseen[0] = 2.0 / 100
        moments.add(ReplicateReadings(np.zeros((n, len(BANDS))), np.zeros(n), brightest_unseen=unseen))
    half = moments.readings()["desk"].half_width
    np.testing.assert_allclose(half[0], 3.0 / 800 * 2.0, rtol=1e-12)
    assert (half[1] == 0.0).all()


def test_companions_tell_about_the_part_that_they_are_of():
    moments = ReadingMoments((sensor(3),), BANDS)
    spectra = np.ones((3, len(BANDS)))
    for part, change in ((MESH, 0.02), (EXCHANGE, 0.03), (MESH, 0.02)):
        moments.add(ReplicateReadings(spectra, np.zeros(3), np.full_like(spectra, change), part))
    parts = moments.readings()["desk"].numbers["irradiance"].parts
    np.testing.assert_allclose(parts[MESH], COMPANIONS[MESH] * 0.02, rtol=1e-12)
    np.testing.assert_allclose(parts[EXCHANGE], COMPANIONS[EXCHANGE] * 0.03, rtol=1e-12)


def test_errors_are_pooled_with_readings_that_are_about_as_bright():
    """One lucky reading among unsure ones gets (7 · 0 + 4 · mean) / 11 of the variance; a bright one is left alone."""
    value = np.array([10.0, 11.0, 12.0, 1000.0])
    group = alike([slice(0, 4)], value)
    assert len(set(group[:3])) == 1 and group[3] != group[0]
    error = np.array([0.0, 1.1, 1.2, 1.0])
    found = pooled(error, value, group, 7, relative=True)
    usual = (0.0 + 0.1**2 + 0.1**2) / 3
    assert found[0] / 10.0 == pytest.approx(np.sqrt(COMMON / (7 + COMMON) * usual))
    assert found[1] / 11.0 == pytest.approx(np.sqrt((7 * 0.01 + COMMON * usual) / (7 + COMMON)))
    assert found[3] == pytest.approx(1.0)


def changes_of(true, noise, replicates, seed=2):
    moments = RunningMoments(true.shape)
    rng = np.random.default_rng(seed)
    for _ in range(replicates):
        moments.add(true + noise * rng.normal(size=true.shape))
    return moments


@pytest.mark.parametrize(("spread", "noise"), [(0.0, 0.02), (0.02, 0.0), (0.02, 0.02), (0.01, 0.05)])
def test_likely_changes_are_as_large_as_the_true_ones(spread, noise):
    """In the mean square over many readings, where |mean change| has the noise on top."""
    n = 4000
    true = spread * np.random.default_rng(1).normal(size=n)
    moments = changes_of(true, noise, 4)
    part = likely_parts({MESH: moments}, np.ones(n), np.zeros(n, np.int64), relative=True)[MESH]
    found, plain = (np.sqrt(np.mean(some**2)) for some in (part, moments.mean))
    aim = np.sqrt(np.mean(true**2))
    assert aim - 1e-3 <= found <= plain + 1e-12
    assert found <= 1.35 * aim + 0.75 * (plain - aim) + 1e-12


def test_one_reading_with_a_large_change_keeps_it():
    """However small the changes of its neighbours are."""
    true = np.zeros(100)
    true[17] = 0.05
    part = likely_parts({MESH: changes_of(true, 0.004, 4)}, np.ones(100), np.zeros(100, np.int64), relative=True)[MESH]
    assert part[17] == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("replicates", [1, LEAST_COMPANIONS - 1])
def test_few_companions_are_believed(replicates):
    moments = changes_of(np.array([0.03, -0.02]), 0.0, replicates)
    part = likely_parts({EXCHANGE: moments}, np.ones(2), np.zeros(2, np.int64), relative=True)[EXCHANGE]
    np.testing.assert_allclose(part, COMPANIONS[EXCHANGE] * np.array([0.03, 0.02]), rtol=1e-12)


def test_uniformity_varies_as_its_lowest_reading_does():
    """The least of twenty in each replicate hardly varies; the share of one of them does, by 10 % of 1 a replicate."""
    rng = np.random.default_rng(11)
    widths = []
    for _ in range(200):
        moments = ReadingMoments((sensor(20),), BANDS)
        for _ in range(8):
            light = 1.0 + 0.1 * rng.normal(size=(20, 1))
            moments.add(ReplicateReadings(np.repeat(light, len(BANDS), axis=1), np.zeros(20)))
        widths.append(float(moments.readings()["desk"].numbers["uniformity"].standard_error))
    assert np.sqrt(np.mean(np.square(widths))) == pytest.approx(0.1 / np.sqrt(8), rel=0.1)


def test_a_single_reading_is_surely_uniform():
    """Whatever all replicates may be off by alike, the lowest of one is their mean."""
    moments = ReadingMoments((sensor(1),), BANDS)
    for light in (1.0, 1.2):
        moments.add(ReplicateReadings(np.full((1, len(BANDS)), light), np.zeros(1)))
    uniformity = moments.readings({"iteration": 0.01})["desk"].numbers["uniformity"]
    assert float(uniformity.value) == 1.0 and float(uniformity.half_width) == 0.0
