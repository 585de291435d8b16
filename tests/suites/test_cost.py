"""What accuracy costs: errors, fronts, prices and words with known answers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cost_runs import N, readings_of, run_of

from hradiosity.options import Options
from hradiosity.suites.cost.combine import Change, propose
from hradiosity.suites.cost.errors import Error, error_of, without_noise
from hradiosity.suites.cost.files import bands_table, tables
from hradiosity.suites.cost.pareto import pareto_front, quote, quotes
from hradiosity.suites.cost.pricing import Truth, bands_prices, effect_price, largest_spread, prices
from hradiosity.suites.cost.settings import classic, combined, methods, qualities, single_knobs
from hradiosity.suites.cost.values import BandsPrice, Price, Report, Skipped
from hradiosity.suites.cost.words import (
    bands_rows,
    markdown,
    price_rows,
    recommendation,
    seconds_text,
    share_text,
    skipped_lines,
)


def error(rms, *, hidden=False):
    return Error(rms, 2 * rms, 3 * rms, hidden)


def price(setting, seconds, rms, *, hidden=False):
    found = error(rms, hidden=hidden)
    return Price(setting, 1000, 1, seconds, seconds, None, found, found, 0.0, rms)


def report(found, skipped=(), noise=0.001):
    return Report(
        *("room", "a device", 120.0, 100.0, noise, noise, 4096, 5.0, N),
        *(tuple(found), tuple(skipped), (), (), (), True),
    )


# errors


def test_noise_is_taken_out_in_quadrature():
    assert without_noise(0.05, 0.03, 1000) == (pytest.approx(0.04), False)
    assert without_noise(0.05, 0.0, 1000) == (0.05, False)


def test_an_error_like_the_noise_is_below_the_floor():
    assert without_noise(0.031, 0.03, 1000) == (0.03, True)
    assert without_noise(0.02, 0.03, 1000) == (0.03, True)


def test_few_readings_need_more():
    """With 8 readings the mean square of the noise varies by a half, twice of which is needed."""
    assert without_noise(0.04, 0.03, 1000)[1] is False
    assert without_noise(0.04, 0.03, 8)[1] is True


def test_percentile_and_largest_shrink_alike():
    deviation = np.array([0.05, -0.05] * 10)
    found = error_of([deviation], 0.03, 1000)
    assert (found.rms, found.p95, found.largest) == pytest.approx((0.04, 0.04, 0.04))
    assert error_of([deviation, 3 * deviation], 0.0, 1000).rms == pytest.approx(0.05 * math.sqrt(5))


def test_noise_of_random_numbers_is_found():
    rng = np.random.default_rng(0)
    truth, solver = 0.02 * rng.standard_normal(20000), 0.03 * rng.standard_normal(20000)
    assert error_of([solver - truth], 0.02, 20000).rms == pytest.approx(0.03, rel=0.02)


# fronts and prices


def test_front_by_hand():
    cost, error = np.array([1.0, 2.0, 3.0, 4.0, 2.0]), np.array([0.4, 0.1, 0.2, 0.05, 0.1])
    assert pareto_front(cost, error).tolist() == [0, 1, 3]
    assert pareto_front(cost, np.where(error < 0.1, np.inf, error)).tolist() == [0, 1]
    assert len(pareto_front(np.zeros(0), np.zeros(0))) == 0


def test_nothing_beats_the_front():
    rng = np.random.default_rng(1)
    cost, error = rng.uniform(1, 2, 300), rng.uniform(1, 2, 300)
    front = pareto_front(cost, error)
    beaten = (cost[:, None] <= cost) & (error[:, None] <= error) & ((cost[:, None] < cost) | (error[:, None] < error))
    assert sorted(front) == np.flatnonzero(~beaten.any(axis=0)).tolist()


def test_prices_between_settings_are_straight_in_log_log():
    """From (1 s, 10 %) to (100 s, 1 %) the slope is −1/2: 3.1623 % at 10 s."""
    cost, error = np.array([1.0, 100.0]), np.array([0.1, 0.01])
    found = quote(math.sqrt(0.001), cost, error)
    assert found.kind == "interpolated" and found.seconds == pytest.approx(10.0) and found.setting == 1
    assert quote(0.2, cost, error).seconds == 1.0 and quote(0.2, cost, error).kind == "at most"
    far = quote(0.001, cost, error)
    assert far.kind == "extrapolated" and far.seconds == pytest.approx(10000.0) and far.setting is None
    assert quote(0.01, cost, error).seconds == pytest.approx(100.0)


def test_quotes_end_one_beyond_the_best():
    found = quotes(np.array([1.0, 100.0]), np.array([0.1, 0.005]))
    assert [q.target for q in found] == [0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003]
    assert [q.kind for q in found] == ["at most", *["interpolated"] * 5, "extrapolated"]


def test_combinations_add_costs_and_squares():
    """Halving a useless knob and doubling the one that matters."""
    changes = {"elements": [Change(0.5, -2.0, 0.0)], "gather_samples": [Change(2.0, 1.0, -0.5e-4)]}
    (found,) = propose(5.0, 0.01, changes, most=4)
    assert dict(found.factors) == {"elements": 0.5, "gather_samples": 2.0}
    assert found.cost == pytest.approx(4.0) and found.error == pytest.approx(math.sqrt(0.5e-4))


def test_combinations_do_not_promise_everything():
    changes = {name: [Change(2.0, 1.0, -0.9e-4)] for name in ("elements", "gather_samples", "light_samples")}
    assert min(p.error for p in propose(5.0, 0.01, changes, most=9)) > 0.001


# words


def test_recommendation():
    draft, normal, _ = qualities()
    found = [price(draft, 1.0, 0.1), price(normal, 100.0, 0.005), price(classic()[2], 188.0, 0.009)]
    lines = recommendation(report(found))
    assert lines[0] == "10 % costs at most 1 s: `--quality draft` reached 10 % in 1 s"
    assert lines[2] == "3 % costs about 6.4 s: `--quality normal` reached 0.5 % in 100 s"
    assert lines[4].startswith("1 % costs about 34 s: `--quality normal`")
    assert lines[6].startswith("0.3 % costs some 278 s: not reached in the budget, extrapolated")
    assert lines[7] == "classic mode with 128² hemicubes reaches 0.9 % at 188 s"


def test_recommendation_tells_what_is_hidden_and_what_was_not_run():
    draft, normal, _ = qualities()
    found = [price(draft, 1.0, 0.02), price(normal, 4.0, 0.003, hidden=True)]
    skipped = [Skipped("classic 32²", "classic", 130.0, "over the budget")]
    lines = recommendation(report(found, skipped, noise=0.003))
    assert "below 0.3 %, the referee's own noise: `--quality normal`, 4 s" in lines
    assert lines[-1] == "classic mode was not run: about 130 s was more than was left of its share of the budget"
    assert recommendation(report([price(draft, 1.0, 0.02, hidden=True)]))[0].startswith("no error stands out")
    assert recommendation(report([])) == ["nothing was measured"]


def test_settings_that_were_not_run_are_told_by_groups():
    skipped = [
        Skipped("elements × 4", "elements", 25.0, "too long"),
        Skipped("elements × 2", "elements", 16.2, "too long"),
        Skipped("hemicube, few elements", "form factors", 30.0, "too long"),
        Skipped("auto, few elements", "form factors", None, "refused"),
    ]
    assert skipped_lines(skipped) == [
        "* too long (what they would take):",
        "  * elements: × 2 (16 s), × 4 (25 s)",
        "  * form factors, few elements: hemicube (30 s)",
        "* refused:",
        "  * form factors, few elements: auto",
    ]


def test_one_number_of_bands_is_no_table():
    one = BandsPrice(9, 9, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    told = report([price(qualities()[0], 1.0, 0.1)])
    assert [len(tables(replace(told, bands=(one,) * n))) for n in (0, 1, 2)] == [1, 1, 2]


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.6234, "0.62 s"), (3.24, "3.2 s"), (94.2, "94 s"), (188.0, "188 s"), (1860.0, "31 min")]
)
def test_seconds(seconds, text):
    assert seconds_text(seconds) == text


def test_shares_and_tables():
    assert [share_text(v) for v in (0.01, 0.0044, 0.123)] == ["1 %", "0.44 %", "12 %"]
    lines = markdown(price_rows([price(qualities()[0], 1.0, 0.02, hidden=True)]))
    assert len({len(line) for line in lines}) == 1 and lines[1].startswith("| ---")
    assert "< 2 %" in lines[2] and lines[2].split("|")[1].strip() == "draft"


def test_flags_ask_for_the_setting():
    assert [s.flags for s in qualities()] == ["--quality draft", "--quality normal", "--quality fine"]
    usual = Options()
    flags = f"--elements {2 * usual.elements} --gather-samples {usual.gather_samples // 2}"
    assert combined({"elements": 2.0, "gather_samples": 0.5}).flags == flags
    assert classic()[0].flags == "--elements 1000 --replicates 2 --mode classic --hemicube-resolution 32"
    names = [s.name for s in (*qualities(), *single_knobs(), *methods(), *classic())]
    assert len(names) == len(set(names))


# runs together


def test_prices_of_runs():
    truth = Truth.of(readings_of(np.ones(N)))
    draft, normal, _ = qualities()
    runs = [run_of(draft, np.full(N, 1.03), 1.0), run_of(normal, np.full(N, 1.01), 3.0, spread=0.02)]
    runs.append(run_of(draft, np.full(N, 0.99), 2.0, seed=1))
    first, second = prices(runs, truth)
    assert first.seeds == 2 and first.cpu_seconds == 1.5 and first.on_front and second.on_front
    assert first.illuminance.rms == pytest.approx(math.sqrt((0.03**2 + 0.01**2) / 2))
    assert first.bias == pytest.approx(0.01)
    assert second.illuminance.rms == pytest.approx(0.01) == second.spectrum.largest
    assert second.sampling == pytest.approx(0.0202 / 3.18245, rel=1e-5)


def test_a_dark_reference_is_refused():
    with pytest.raises(ValueError, match="no light"):
        Truth.of(readings_of(np.zeros(N)))


def test_effects_and_bands():
    draft = qualities()[0]
    usual, forced = run_of(draft, np.ones(N), 1.0), run_of(draft, np.full(N, 1.1), 3.0)
    found = effect_price("shadows", "--occlusion on", usual, forced)
    assert (found.usual_seconds, found.forced_seconds) == (1.0, 3.0) and found.change == pytest.approx(0.1)
    few, many = bands_prices([(401, 401, usual), (9, 9, forced)])
    assert (few.bands, many.bands) == (9, 401)
    assert few.mean_illuminance == pytest.approx(0.1) and many.illuminance == 0.0 and few.chromaticity == 0.0
    assert (few.cct, few.ra, few.melanopic) == pytest.approx((0.1, 0.1, 0.1)) and many.cct == many.ra == 0.0


def test_bands_in_words_and_tables():
    """The fewest bands that change colour and the eye by little are recommended."""
    many = BandsPrice(401, 401, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    some = BandsPrice(24, 24, 2.0, 0.01, 1e-3, 1e-4, 12.3, 0.44, -2e-3)
    few = BandsPrice(9, 9, 1.0, 0.05, 0.03, 0.01, 300.0, 4.0, 0.05)
    told = replace(report([]), bands=(few, some, many))
    rows = bands_rows(told)
    assert rows[2] == ("24", "24", "2", "1 %", "+0.1 %", "0.0001", "12", "0.44", "-0.2 %")
    assert rows[3][3:] == ("reference",) * 6
    whole = replace(told, prices=(price(qualities()[0], 1.0, 0.1),))
    line = recommendation(whole)[-1]
    assert line.startswith("24 bands serve colour and the eye like 401: they change colour temperatures by 12 K, Ra by")
    assert "2 s against 4 s" in line
    assert recommendation(replace(whole, bands=(few, many)))[-1].startswith("no fewer bands than 401")
    assert not any("bands" in line for line in recommendation(replace(whole, bands=(many,))))
    csv = bands_table((few, some, many)).decode().splitlines()
    assert csv[2] == "24,24,2.0,0.01,0.001,0.0001,12.3,0.44,-0.002" and csv[0].startswith("bands,columns,cpu_s")


def test_numbers_that_no_reading_has_are_left_out():
    """A green room has no colour temperature."""
    many = BandsPrice(401, 401, 4.0, 0.0, 0.0, 0.0, math.nan, math.nan, 0.0)
    few = BandsPrice(9, 9, 1.0, 0.0, 0.0, 0.0, math.nan, math.nan, 1e-3)
    whole = replace(report([price(qualities()[0], 1.0, 0.1)]), bands=(few, many))
    assert bands_rows(whole)[1][6:8] == ("none", "none")
    assert "temperature" not in recommendation(whole)[-1] and recommendation(whole)[-1].startswith("9 bands serve")
    assert bands_table((few,)).decode().splitlines()[1].endswith(",,,0.001")
    draft = qualities()[0]
    dark = run_of(draft, np.full(N, 0.1), 1.0)
    for number in ("cct_k", "ra"):
        dark.readings["desk"].numbers[number].value[:] = np.nan
    assert math.isnan(bands_prices([(9, 9, dark)])[0].cct)


def test_spread_is_that_of_one_replicate():
    """A half width of 2 % from four replicates is a spread of 0.02 · √4 / 3.182."""
    lux = np.ones(N)
    assert largest_spread([run_of(qualities()[0], lux, 1.0, spread=0.02)]) == pytest.approx(0.04 / 3.18245, rel=1e-5)
