"""Speeds of a device outlive the program, and a damaged or forbidden cache harms nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from hradiosity.io import calibration
from hradiosity.io.builds import load_builds
from hradiosity.io.cache import CACHE_VARIABLE
from hradiosity.plan import Calibration, Plan, SpectralColumns
from hradiosity.planning_seconds import READING_PATHS, READINGS, SOLUTION_RAYS, with_geometry, with_seconds

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
    assert speeds.reading_paths_per_s == 4 * (10 + READINGS) * (100 + READING_PATHS) / 0.8
    assert speeds.exchange_s_per_ray == pytest.approx(0.5 / 64000)
    assert speeds.solve_s_per_ray_column == pytest.approx(4.0 / (64000 + 4 * SOLUTION_RAYS) / 16)


@pytest.mark.parametrize("changes", [{"occlusion": False}, {"interreflection": False}, {"n_readings": 0}])
def test_a_run_that_left_a_stage_out_measures_nothing(changes):
    assert calibration.measure(finished(**changes)) is None


def test_speeds_give_back_the_seconds_that_they_were_measured_from():
    """Of a run with work alike; what was spent before the first replicate is known and comes on top."""
    columns = SpectralColumns(*(np.zeros((2, 12), np.float32) for _ in range(3)), np.zeros((12, 9)), 1)
    counts = {"n_readings": 10, "gather_samples": 100, "n_emitters": 3, "light_points": 4, "rays_per_element": 16}
    sizes = {"n_bands": 9, "n_patches": 6, "n_elements": 1000, "elements_asked": 1000, "replicates": 4}
    plan = Plan(
        **(counts | sizes),
        effects=(),
        columns=columns,
        weak_emitters=np.zeros(3, bool),
        element_size=0.1,
        size_bound="",
        light_samples=8,
        occlusion=True,
        interreflection=True,
        memory_bytes=0,
        seconds=None,
    )
    known = with_seconds(plan, calibration.measure(finished()))
    assert known.seconds == pytest.approx(1.0 + 2.0 + 0.5 + 4.0 + 0.8)
    spent = {"geometry": 14.0, "check": 1.0, "readings": 3.0}
    assert with_geometry(known, spent).seconds == pytest.approx(known.seconds + 15.0)
    assert with_geometry(plan, spent).seconds is None
