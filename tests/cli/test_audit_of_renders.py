"""The audit of a render: what it says, what it changes, and that nothing is lost when it is broken off."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from cli_room import ROOM

from hradiosity.radiosity import auditing
from hradiosity.readings.audit_batch import ReadingBatch

LUX = ("illuminance_lx", "illuminance_half_width_lx")
QUICK = (*("--element-size", "0.7", "--gather-samples", "1024", "--light-samples", "64"), "--no-pictures")
TABLES = ("readings.csv", "spectra.csv", "spectra_half_width.csv")


@pytest.fixture
def grid(room):
    """The small room with 31 readings."""
    (room / "scene.toml").write_text(ROOM.replace("counts = [3, 2]", "counts = [6, 5]"))
    return room


@pytest.fixture
def factor(monkeypatch):
    """Let every audit find the factor that is set."""
    judge = auditing.judge
    return lambda value: monkeypatch.setattr(auditing, "judge", lambda *found: replace(judge(*found), factor=value))


def table(path):
    with path.open(newline="") as stream:
        return list(csv.reader(stream))


def numbers(path, first):
    return np.array([row[first:] for row in table(path)[1:]], float)


def run_json(out):
    return json.loads((out / "run.json").read_text())


def test_audit_is_told_and_repeats(grid, call, tmp_path):
    """All of few readings are audited; the same command gives the same verdict."""
    for name in ("out", "again"):
        outcome = call("render", grid, "-o", tmp_path / name, *QUICK)
        assert outcome.code == 0, outcome.err
        assert "audited 31 readings by unbiased paths: " in outcome.out
        assert "all together they are " in outcome.out
    found, again = (run_json(tmp_path / name)["audit"] for name in ("out", "again"))
    assert found["chosen"] == {"desk, left": list(range(30)), "wall": [0]}
    assert 0.0 < found["factor"] < 3.0
    assert found["rays"] < run_json(tmp_path / "out")["rays"]
    assert "audit" in run_json(tmp_path / "out")["stage_seconds"]
    assert {**found, "cpu_s": 0} == {**again, "cpu_s": 0}
    for name in TABLES:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_factor_goes_into_every_half_width(grid, call, tmp_path, factor):
    factor(1.5)
    wide, plain = tmp_path / "wide", tmp_path / "plain"
    assert "all half widths were multiplied by 1.50" in call("render", grid, "-o", wide, *QUICK).out
    assert "not audited: --no-audit" in call("render", grid, "-o", plain, "--no-audit", *QUICK).out
    assert run_json(plain)["audit"] == {"skipped": "--no-audit"}
    head = table(wide / "readings.csv")[0]
    widths = [column for column, name in enumerate(head) if "half_width" in name]
    assert len(widths) >= 3
    with_audit, without = (numbers(out / "readings.csv", 2) for out in (wide, plain))
    scale = np.ones(len(head))
    scale[widths] = 1.5
    np.testing.assert_allclose(with_audit, without * scale[2:], rtol=1e-7)
    with_audit, without = (numbers(out / "spectra_half_width.csv", 2) for out in (wide, plain))
    np.testing.assert_allclose(with_audit, 1.5 * without, rtol=1e-7)
    assert (wide / "spectra.csv").read_bytes() == (plain / "spectra.csv").read_bytes()
    sensors = [run_json(out)["sensors"]["desk, left"] for out in (wide, plain)]
    for name in ("accuracy", "mean_illuminance_half_width_lx", "uniformity_half_width"):
        assert sensors[0][name] == pytest.approx(1.5 * sensors[1][name])


def test_few_readings_are_not_audited(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 0
    assert "not audited: fewer than 19 readings with light" in outcome.out
    result = json.loads(call("render", room, "-o", tmp_path / "out", "--json", *QUICK).out.splitlines()[-1])
    assert result["audit"] == {"skipped": "fewer than 19 readings with light"}


def test_interrupted_audit_keeps_the_results(grid, call, tmp_path, monkeypatch):
    """Results without audit are written; a resumed run audits and ends with the bits of one that was left alone."""
    for name, more in (("whole", ()), ("plain", ("--no-audit",))):
        assert call("render", grid, "-o", tmp_path / name, "--quiet", *more, *QUICK).code == 0
    trace = ReadingBatch.trace

    def broken(self, *arguments):
        if self.paths:
            raise KeyboardInterrupt
        trace(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(ReadingBatch, "trace", broken)
        outcome = call("render", grid, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 130
    assert "not audited: interrupted" in outcome.out
    assert run_json(tmp_path / "out")["state"] == "interrupted"
    for name in TABLES:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "plain" / name).read_bytes()
    assert call("render", grid, "-o", tmp_path / "out", "--resume", *QUICK).code == 0
    for name in TABLES:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_a_run_goes_on_until_its_readings_are_accurate_with_the_factor_too(grid, call, tmp_path, factor):
    factor(1.0)
    assert call("render", grid, "-o", tmp_path / "plain", *QUICK).code == 0
    rows = table(tmp_path / "plain" / "readings.csv")
    value, half = (numbers(tmp_path / "plain" / "readings.csv", rows[0].index(name))[:, 0] for name in LUX)
    wanted = 100.0 * 1.2 * float((half / value).max())
    factor(1.6)
    outcome = call("render", grid, "-o", tmp_path / "out", "--accuracy", f"{wanted:.4f}%", *QUICK)
    assert outcome.code == 0
    assert "intervals were too narrow by 1.60: going on to" in outcome.out
    found, before = run_json(tmp_path / "out"), run_json(tmp_path / "plain")
    assert found["state"] == "complete"
    assert found["rays"] > before["rays"]


def test_accuracy_that_only_the_factor_misses_in_the_time_given(grid, call, tmp_path, factor):
    factor(1000.0)
    outcome = call("render", grid, "-o", tmp_path / "out", "--accuracy", "50%", "--time", "60s", *QUICK)
    assert outcome.code == 3
    assert "with the audit's factor" in outcome.out
    assert "--resume --accuracy 0.05%" in outcome.out
    assert run_json(tmp_path / "out")["state"] == "accuracy not reached"
