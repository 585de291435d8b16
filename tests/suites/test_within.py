"""What an accuracy takes: the table, and how forecasts are held against what a run took."""

import math
import subprocess
import sys

import pytest
from small_room import SHELL

from hradiosity.io.scene_toml import load_scene
from hradiosity.suites.within import foreseen, line, measure


def test_forecasts_are_those_of_their_time():
    """Said in all 9, 12 and 10 seconds, of a run of 10."""
    said = [(0.5, None), (2.0, 7.0), (4.0, 8.0), (7.0, 3.0), (9.0, 5.0), (10.0, 0.0)]
    assert foreseen(said) == pytest.approx((0.9, 1.2, 1.0))
    assert math.isnan(foreseen([(6.0, None), (10.0, 0.0)])[1])


SENSOR = """
[[sensor]]
name = "desk"
kind = "grid"
corner = [0.0, 0.0, 0.0]
edge_u = [3.0, 0.0, 0.0]
edge_v = [0.0, 2.0, 0.0]
counts = [3, 2]
height = 0.8
"""


def test_a_run_is_as_accurate_as_asked(device, tmp_path):
    (tmp_path / "scene.toml").write_text('[scene]\ntitle = "room"\n' + SHELL + SENSOR)
    found = measure(load_scene(tmp_path), device, 0.03)
    assert found.reached and found.median <= found.worst <= 0.03
    assert found.cpu_seconds > 0.0 and found.wall_seconds > 0.0
    assert "not reached" not in line(found) and line(found).split()[0] == "3%"


@pytest.mark.parametrize("accuracy", ["0%", "nothing", "-1", "inf"])
def test_no_accuracy_at_all_is_refused(accuracy):
    words = [sys.executable, "-m", "hradiosity.suites.within", "nowhere", "--", accuracy]
    outcome = subprocess.run(words, capture_output=True, text=True, check=False)
    assert outcome.returncode == 2 and "no accuracy" in outcome.stderr
