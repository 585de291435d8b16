"""Conformal factors from unbiased readings: their statistics, and how readings are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import box_faces, patches_of, scene_of

import hradiosity
from hradiosity.estimate import Estimate, student_quantile
from hradiosity.metrics.photometric import illuminance
from hradiosity.options import Options
from hradiosity.radiosity import auditing
from hradiosity.readings.audit import audit_order, judge, pooled_noise, widening
from hradiosity.readings.paths import SCRAMBLES

RNG = np.random.default_rng(5)
Z = 1.959964


def verdict(error, half_width, noise):
    """Of readings of 1 lx."""
    return judge(np.ones(len(error)), 1.0 - error, half_width, noise)


def normal_audits(readings, runs, *, half_width, noise):
    """Verdicts of many audits of readings with normal errors of unit spread, and of paths with theirs."""
    verdicts = []
    for _ in range(runs):
        error = RNG.standard_normal(readings) + RNG.standard_normal(readings) * noise / Z
        verdicts.append(verdict(error, np.full(readings, half_width * Z), np.full(readings, noise)))
    return verdicts


def coverage(verdicts, half_width):
    """Mean over audits of how often the widened interval holds a normal error of unit spread."""
    from scipy.special import erf

    return np.mean([erf(found.factor * half_width * Z / np.sqrt(2.0)) for found in verdicts])


@pytest.mark.parametrize("noise", [0.0, 0.25])
@pytest.mark.parametrize("readings", [19, 59, 199])
def test_too_narrow_intervals_hold_after_the_factor(readings, noise):
    """Half widths are a third of what they should be; on average over audits 95 % hold, whatever the number.

    400 audits have a standard error of 0.3 % or less in the mean, with 19 readings.
    """
    verdicts = normal_audits(readings, 400, half_width=0.3, noise=noise)
    assert coverage(verdicts, 0.3) == pytest.approx(0.95, abs=0.01)
    assert np.median([found.factor for found in verdicts]) == pytest.approx(1 / 0.3, rel=0.2)


@pytest.mark.parametrize("noise", [0.0, 1.0, 10.0])
def test_right_intervals_stay_about_as_they_are(noise):
    """A factor near 1 and never below, even where the paths are noisier than the intervals are wide."""
    factors = [found.factor for found in normal_audits(199, 300, half_width=1.0, noise=noise * Z)]
    assert min(factors) == 1.0
    assert 1.0 <= np.median(factors) < 1.05
    assert np.quantile(factors, 0.95) < 1.3


def test_wide_intervals_are_not_narrowed():
    verdicts = normal_audits(59, 50, half_width=3.0, noise=0.5)
    assert {found.factor for found in verdicts} == {1.0}
    assert all(found.quantile < 1.0 and found.within == 1.0 and found.sharp == 59 for found in verdicts)


def test_factor_is_that_order_statistic():
    """Of 59 exactly known readings the third largest ratio counts; of 19 the largest; of fewer there is none."""
    error = RNG.permutation(np.arange(1.0, 60.0))
    assert verdict(error, np.full(59, 10.0), np.zeros(59)).factor == pytest.approx(5.7)
    assert verdict(error[:19], np.ones(19), np.zeros(19)).factor == pytest.approx(error[:19].max())
    with pytest.raises(ValueError, match="19"):
        verdict(error[:18], np.ones(18), np.zeros(18))


def test_widening_deducts_the_noise():
    """f h and the noise in quadrature make the error where noise is small; f ≤ 1 says that both in quadrature hold."""
    n = 1000
    error, half_width, noise = (RNG.uniform(0.01, 3.0, n) for _ in range(3))
    factor = widening(error, half_width, noise)
    within = error <= np.hypot(half_width, noise)
    assert np.array_equal(factor <= 1.0, within)
    clear = (noise < half_width) & (error > noise)
    np.testing.assert_allclose(np.hypot(factor * half_width, noise)[clear], error[clear], rtol=1e-12)
    assert (factor[error < np.minimum(noise, half_width)] == 0.0).all()
    assert (factor <= error / np.minimum(half_width, np.hypot(half_width, noise)) + 1e-12).all()


def test_rare_light_does_not_count_against_intervals():
    """Paths that find light once in 300 times, ten times as often in some runs: intervals are right by construction.

    Those that found too little show too little spread; that of the others makes up for it.
    """
    truth, paths = 1.0, 40
    found = RNG.binomial(paths, 1 / 300, (SCRAMBLES, 59)) * 300.0 / paths
    error = found.std(axis=0, ddof=1) / np.sqrt(SCRAMBLES)
    value, t = np.full(59, truth), student_quantile(0.95, SCRAMBLES - 1)
    ratio = {
        name: judge(value, found.mean(axis=0), np.full(59, 1e-3), t * noise).quantile
        for name, noise in (("own", error), ("pooled", pooled_noise(error, value)))
    }
    assert ratio["own"] > 2.0
    assert ratio["pooled"] < 1.2


def test_order_is_stratified_and_repeats():
    """Every beginning of 30 readings or more holds the sensors in proportion, to one reading."""
    group = np.repeat([0, 1, 2], [300, 90, 10])
    order = audit_order(group, seed=4)
    assert np.array_equal(np.sort(order), np.arange(400))
    assert np.array_equal(order, audit_order(group, seed=4))
    assert not np.array_equal(order, audit_order(group, seed=5))
    for count in (30, 59, 200):
        held = np.bincount(group[order[:count]], minlength=3)
        assert (np.abs(held - count * np.array([0.75, 0.225, 0.025])) <= 1.0).all()
    first = [audit_order(group, seed)[0] for seed in range(400)]
    assert np.mean(np.array(first) < 300) == pytest.approx(0.75, abs=0.15)


@pytest.fixture(scope="module")
def room():
    """A box with a lamp below the ceiling, and 90 readings in it."""
    faces = patches_of(box_faces(4, 3, 2.5), [0] * 6)
    x, y = np.meshgrid(np.linspace(0.4, 3.6, 10), np.linspace(0.4, 2.6, 9))
    position = np.column_stack([x.ravel(), y.ravel(), np.full(90, 0.8)])
    return scene_of(faces, [[0.5, 0.5]], [(5, 100.0)], position, np.tile([0.0, 0.0, 1.0], (90, 1)))


def options(**changes):
    return Options(**({"elements": 400, "gather_samples": 1024, "light_samples": 64} | changes))


@pytest.fixture(scope="module")
def solved(room, device):
    return hradiosity.solve(room, options(), device)


def half_widths(solution, name="illuminance"):
    return np.concatenate([np.atleast_1d(found.numbers[name].half_width) for found in solution.readings.values()])


def test_audit_of_a_room(room, device, solved):
    """Half widths of everything are multiplied by the factor, values stay; all of it repeats with the seed."""
    audited = hradiosity.audit(solved, device)
    record = audited.record["audit"]
    assert record["readings"] >= auditing.USUAL_READINGS
    assert 0.0 < record["quantile"] <= record["factor"] < 2.0
    assert record["rays"] <= 1.01 * auditing.most_rays(solved)
    for name in ("illuminance", "irradiance", "chromaticity", "mean_illuminance", "uniformity"):
        np.testing.assert_allclose(half_widths(audited, name), record["factor"] * half_widths(solved, name))
    for name, found in audited.readings.items():
        assert np.array_equal(found.irradiance, solved.readings[name].irradiance)
        assert len(set(record["chosen"][name])) == len(record["chosen"][name])
    point = ([2.0, 1.5, 1.0], [0.0, 0.0, 1.0])
    assert audited.read(*point).illuminance_half_width == pytest.approx(
        record["factor"] * solved.read(*point).illuminance_half_width
    )
    again = hradiosity.solve(room, options(audit=True), device)
    same = {name: value for name, value in record.items() if name != "cpu_s"}
    assert {name: value for name, value in again.record["audit"].items() if name != "cpu_s"} == same


def with_half_widths(solution, factor):
    readings = {name: found.widened(factor) for name, found in solution.readings.items()}
    return replace(solution, readings=readings)


def with_errors(solution, spread, half_width):
    """The solution with normal errors of that relative spread and half widths of so many spreads."""
    found = solution.readings["points"]
    lux = found.illuminance
    wrong = lux * (1.0 + spread * np.random.default_rng(3).standard_normal(len(lux)))
    given = Estimate(wrong, np.zeros_like(lux), 7, {"given": half_width * spread * lux})
    readings = {"points": replace(found, numbers={**found.numbers, "illuminance": given})}
    return replace(solution, readings=readings)


def test_intervals_that_are_too_narrow_are_found_out(device, solved):
    """Half widths at 0.3 of what errors of 5 % need: the factor undoes most of it. Wide ones hold."""
    found = hradiosity.audit(with_errors(solved, 0.05, 0.3 * 1.96), device).record["audit"]
    assert 2.0 < found["factor"] < 5.0
    assert found["within"] < 0.7
    right = hradiosity.audit(with_errors(solved, 0.05, 2.0 * 1.96), device).record["audit"]
    assert right["factor"] == 1.0


def test_light_that_is_missing_everywhere_shows_in_the_mean(room, device, solved):
    """A tenth of the light is missing: more than paths that are noisy one by one leave room for together."""
    right = hradiosity.audit(solved, device).record["audit"]
    assert abs(right["bias"]) <= 1.5 * right["bias_half_width"]
    found = solved.readings["points"].numbers["illuminance"]
    lacking = replace(found, value=0.9 * found.value)
    readings = replace(solved.readings["points"], numbers={**solved.readings["points"].numbers, "illuminance": lacking})
    bias = hradiosity.audit(replace(solved, readings={"points": readings}), device).record["audit"]
    assert bias["bias"] == pytest.approx(-0.1 / 0.9, abs=2.0 * bias["bias_half_width"])
    assert bias["bias_half_width"] < 0.03


def test_more_readings_where_paths_are_cheap(device, solved):
    """With intervals so wide that hardly any paths are needed more readings are audited, within the same rays."""
    wide = with_half_widths(solved, 30.0)
    record = hradiosity.audit(wide, device).record["audit"]
    assert auditing.USUAL_READINGS < record["readings"] <= 90
    assert record["sharp"] >= 60
    assert record["rays"] <= 1.01 * auditing.most_rays(solved)


def test_unbiased_values_are_those_of_the_referee(room, device, solved):
    """Both agree within their noise, reading by reading: none is mistaken for another."""
    auditor = auditing.Auditor(room, with_half_widths(solved, 30.0), device)
    with pytest.raises(RuntimeError, match="broken off"):
        auditor.audit()
    for _ in auditor.states():
        pass
    lux, noise = auditor._unbiased()
    chosen = np.concatenate([batch.chosen for batch in auditor._batches])
    known = illuminance(solved.readings["points"].irradiance, room.bands)[chosen]
    assert np.mean(np.abs(lux - known) <= 1.3 * noise) > 0.9


def test_nothing_to_audit(room, device, solved):
    """Few readings, effects that were switched off and single replicates are told, and change nothing."""
    few = replace(room, sensors=tuple(replace(s, position=s.position[:18], normal=s.normal[:18]) for s in room.sensors))
    found = hradiosity.solve(few, options(audit=True, gather_samples=64), device)
    assert "fewer than 19" in found.record["audit"]["skipped"]
    forced = {**solved.record["options"], "interreflection": False}
    direct = replace(solved, record={**solved.record, "options": forced})
    assert "interreflection" in hradiosity.audit(direct, device).record["audit"]["skipped"]
    dark = with_half_widths(solved, 0.0)
    assert hradiosity.audit(dark, device).readings == dark.readings
