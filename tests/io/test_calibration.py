"""Speeds of a device outlive the program, and a damaged or forbidden cache harms nothing."""

from types import SimpleNamespace

import pytest

from hradiosity.io import calibration
from hradiosity.io.builds import load_builds
from hradiosity.io.cache import CACHE_VARIABLE
from hradiosity.plan import Calibration

SPEEDS = Calibration(2e6, 1e6, 5e5, 3e-7, 1e-8)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_unknown_device():
    assert calibration.load_calibration("abacus") is None
    assert load_builds("abacus") == frozenset()


def test_kept_by_device():
    assert calibration.store("abacus", ["a"], SPEEDS)
    assert calibration.store("other", ["b"], None)
    assert calibration.store("abacus", ["a", "c"], None)
    assert calibration.load_calibration("abacus") == SPEEDS
    assert calibration.load_calibration("other") is None
    assert load_builds("abacus") == {"a", "c"}


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", '{"devices": 3}', '{"devices": {"abacus": 1}}'),
        '{"devices": {"abacus": {"calibration": {"speed": 1}}}}',
    ],
)
def test_damaged_cache(cache, text):
    cache.mkdir()
    (cache / "devices.json").write_text(text)
    assert calibration.load_calibration("abacus") is None
    assert calibration.store("abacus", [], SPEEDS)
    assert calibration.load_calibration("abacus") == SPEEDS


def test_cache_that_can_not_be_written(cache):
    cache.write_text("a file in the way")
    assert not calibration.store("abacus", [], SPEEDS)
    assert calibration.load_calibration("abacus") is None


def finished(**changes):
    seconds = {"exchange rays": 1.0, "direct light": 2.0, "exchange": 0.5, "solution": 4.0, "readings": 0.8}
    values = {
        "hemicubes": 0,
        "links": None,
        "pairs": 0,
        "n_readings": 10,
        "rays_per_element": 16,
        "n_emitters": 3,
        "light_points": 4,
        "gather_samples": 100,
        "interreflection": True,
        "occlusion": True,
        "columns": SimpleNamespace(n_groups=2),
    }
    plan = SimpleNamespace(**(values | changes))
    return SimpleNamespace(plan=plan, record={"stage_seconds": seconds}, replicates=4, elements=[None] * 1000)


def test_measured_from_counts_and_seconds():
    speeds = calibration.measure(finished())
    assert speeds.exchange_rays_per_s == 4 * 1000 * 16
    assert speeds.shadow_rays_per_s == 4 * 1000 * 3 * 4 / 2.0
    assert speeds.paths_per_s == 4 * 10 * 100 / 0.8
    assert speeds.exchange_s_per_ray == pytest.approx(0.5 / 64000)
    assert speeds.solve_s_per_ray_column == pytest.approx(4.0 / 64000 / 16)


@pytest.mark.parametrize("changes", [{"occlusion": False}, {"interreflection": False}, {"n_readings": 0}])
def test_a_run_that_left_a_stage_out_measures_nothing(changes):
    assert calibration.measure(finished(**changes)) is None
