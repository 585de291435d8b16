"""``render --sensitivity``."""

import csv
import json

import pytest
from cli_room import QUICK


def test_table_record_and_words(room, call, tmp_path):
    out = tmp_path / "out"
    outcome = call("render", room, "-o", out, *QUICK, "--sensitivity", "--no-audit")
    assert outcome.code == 0, outcome.err
    with (out / "sensitivity.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {(row["kind"], row["name"]) for row in rows} == {
        ("reflectance", "wall"),
        ("reflectance", "floor"),
        ("flux", "lamp"),
    }
    assert len(rows) == 3 * 7
    for row in rows:
        value, half_width = float(row["sensitivity"]), float(row["sensitivity_half_width"])
        if row["kind"] == "flux":
            assert value == pytest.approx(1.0)
        else:
            assert 0.0 < value < 1.0
        assert 0.0 <= half_width < 0.1
    means = json.loads((out / "run.json").read_text())["sensitivity"]["desk, left"]
    (wall,) = (entry["mean"] for entry in means if entry["name"] == "wall")
    (floor,) = (entry["mean"] for entry in means if entry["name"] == "floor")
    assert wall > floor > 0.0
    assert "desk, left, by materials: wall ±" in outcome.out
    assert "desk, left, by lights: lamp ±2 %" in outcome.out


def test_not_asked_for(room, call, tmp_path):
    out = tmp_path / "out"
    assert call("render", room, "-o", out, *QUICK, "--no-audit").code == 0
    assert not (out / "sensitivity.csv").exists()
    assert "sensitivity" not in json.loads((out / "run.json").read_text())
