"""What the prices of a scene say of an accuracy."""

import math

import pytest

from hradiosity.estimate import student_quantile
from hradiosity.io import learnt
from hradiosity.io.cache import CACHE_VARIABLE
from hradiosity.io.learnt import Learnt, accuracy_line, load_learnt, store_learnt
from hradiosity.options import Options

KNOWN = Learnt(spread=0.02, first_seconds=0.5, replicate_seconds=2.0, error=0.01, sampling=0.008)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.parametrize("accuracy", [0.05, 0.02, 0.01, 0.004])
def test_the_fewest_replicates(accuracy):
    count = KNOWN.replicates_for(accuracy)
    half = [student_quantile(0.95, n - 1) * 0.02 / math.sqrt(n) for n in (count - 1, count) if n > 1]
    assert half[-1] <= accuracy and all(width > accuracy for width in half[:-1])


def test_too_many_replicates():
    assert KNOWN.replicates_for(0.001) is None
    assert "more than 256" in accuracy_line(KNOWN, 0.001, Options())


def test_words():
    """An interval of 2 % takes 7 replicates, since 2.447 · 0.02 / √7 = 0.0185; 0.6 % of error is no sampling."""
    four = Options(replicates=4)
    line = accuracy_line(KNOWN, 0.02, four)
    assert line == "accuracy 2 %: about 14 s in 7 replicates, as hradiosity cost measured"
    assert "0.6 % of error is not sampling and stays" in accuracy_line(KNOWN, 0.01, Options())
    assert "in 4 replicates" in accuracy_line(KNOWN, 0.5, four)  # as many as the settings ask for
    assert accuracy_line(None, 0.02, Options()).endswith("run hradiosity cost")


def test_kept_by_device_scene_and_settings():
    few = Options(elements=77)
    assert store_learnt("abacus", "scene", [(Options(), KNOWN)])
    assert store_learnt("abacus", "scene", [(few, Learnt(1.0, 1.0, 1.0, 1.0, 1.0))])
    assert load_learnt("abacus", "scene", Options(seed=5, accuracy=0.01, pictures=True)) == KNOWN
    assert load_learnt("abacus", "scene", few).spread == 1.0
    for device, digest, options in (
        ("abacus", "scene", Options(elements=78)),
        ("abacus", "another", Options()),
        ("slide rule", "scene", Options()),
    ):
        assert load_learnt(device, digest, options) is None


def test_old_scenes_go():
    for number in range(learnt._KEPT_SCENES + 3):
        store_learnt("abacus", f"scene {number}", [(Options(), KNOWN)])
    assert load_learnt("abacus", "scene 2", Options()) is None
    assert load_learnt("abacus", "scene 3", Options()) == KNOWN


@pytest.mark.parametrize("text", ["", "[]", '{"devices": 3}', '{"devices": {"abacus": 1}}'])
def test_damaged_cache(cache, text):
    cache.mkdir()
    (cache / "cost.json").write_text(text)
    assert load_learnt("abacus", "scene", Options()) is None
    assert store_learnt("abacus", "scene", [(Options(), KNOWN)])
    assert load_learnt("abacus", "scene", Options()) == KNOWN
