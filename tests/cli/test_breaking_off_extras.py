"""Audit, sensitivities and referee that fail or are interrupted: the solution is written all the same."""

import json

import pytest
from cli_room import QUICK

from hradiosity.errors import DeviceError
from hradiosity.radiosity.auditing import Auditor
from hradiosity.radiosity.referee import Referee
from hradiosity.radiosity.sensitivity import SensitivityRun


def raising(error):
    def states(self):
        raise error
        yield

    return states


def rendered(room, call, tmp_path, *words):
    outcome = call("render", room, "-o", tmp_path / "out", *QUICK, *words)
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert (tmp_path / "out" / "readings.csv").stat().st_size > 100
    return outcome, record


def test_sensitivities_that_are_interrupted(room, call, tmp_path, monkeypatch):
    monkeypatch.setattr(SensitivityRun, "states", raising(KeyboardInterrupt()))
    outcome, record = rendered(room, call, tmp_path, "--sensitivity", "--no-audit")
    assert outcome.code == 130
    assert record["state"] == "interrupted"
    assert "no sensitivities: interrupted" in outcome.out
    assert not (tmp_path / "out" / "sensitivity.csv").exists()


@pytest.mark.parametrize("error", [DeviceError("the device went away"), MemoryError()])
def test_sensitivities_that_the_device_refuses(room, call, tmp_path, monkeypatch, error):
    monkeypatch.setattr(SensitivityRun, "states", raising(error))
    outcome, record = rendered(room, call, tmp_path, "--sensitivity", "--no-audit")
    reason = str(error) or "out of memory"
    assert outcome.code == 0
    assert record["state"] == "complete"
    assert record["sensitivity"] == {"skipped": reason}
    assert f"no sensitivities: {reason}" in outcome.out


@pytest.mark.parametrize("error", [DeviceError("the device went away"), MemoryError()])
def test_audit_that_the_device_refuses(room, call, tmp_path, monkeypatch, error):
    file = room / "scene.toml"
    file.write_text(file.read_text().replace("counts = [3, 2]", "counts = [6, 5]"))  # enough for an audit
    monkeypatch.setattr(Auditor, "states", raising(error))
    outcome, record = rendered(room, call, tmp_path)
    assert outcome.code == 0
    assert record["audit"]["skipped"] == (str(error) or "out of memory")
    assert "not audited: " in outcome.out


def test_referee_that_is_interrupted_before_its_first_round(room, call, tmp_path, monkeypatch):
    monkeypatch.setattr(Referee, "states", raising(KeyboardInterrupt()))
    outcome, record = rendered(room, call, tmp_path, "--referee", 1000, "--no-audit")
    assert outcome.code == 130
    assert record["state"] == "interrupted"
    assert "referee" not in record
    assert not (tmp_path / "out" / "referee_readings.csv").exists()
