"""Ctrl-C keeps what is known, and a resumed run ends with the bits of one that was left alone."""

import json
import os
import signal
import subprocess
import sys

import h5py
import numpy as np
import pytest
from cli_room import QUICK

from hradiosity.cli import closing, live_files
from hradiosity.radiosity.solver import RadiositySolver

ENDLESS = ("--replicates", "250", "--no-pictures")
TABLES = ("readings.csv", "spectra.csv", "spectra_half_width.csv")


def cells(out):
    with h5py.File(out / "solution.vtkhdf") as file:
        return {name: array[()] for name, array in file["VTKHDF/CellData"].items()}


def assert_same_bits(one, other):
    for name in TABLES:
        assert (one / name).read_bytes() == (other / name).read_bytes()
    for name, array in cells(one).items():
        assert np.array_equal(array, cells(other)[name]), name


def interrupted_at(monkeypatch, replicate, late):
    """Let the replicate with this number be broken off, early or after most of its work."""
    original = RadiositySolver._replicate

    def broken(self, surfaces):
        if self.replicates == replicate:
            if late:
                original(self, surfaces)
            raise KeyboardInterrupt
        original(self, surfaces)

    monkeypatch.setattr(RadiositySolver, "_replicate", broken)


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("known", [1, 3])
def test_resume_equals_uninterrupted(room, call, tmp_path, monkeypatch, known, late):
    assert call("render", room, "-o", tmp_path / "whole", "--quiet", *QUICK).code == 0
    with monkeypatch.context() as patched:
        interrupted_at(patched, known, late)
        outcome = call("render", room, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 130
    assert "--resume" in outcome.out
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert (run["state"], run["replicates"], run["complete"]) == ("interrupted", known, False)
    assert call("render", room, "-o", tmp_path / "out", "--resume", *QUICK).code == 0
    assert_same_bits(tmp_path / "whole", tmp_path / "out")
    whole, resumed = (json.loads((tmp_path / name / "run.json").read_text()) for name in ("whole", "out"))
    for key in ("replicates", "rays", "elements", "iterations", "defects_before_closure"):
        assert whole[key] == resumed[key]


def test_resume_of_a_killed_run(room, call, tmp_path, monkeypatch):
    """Nothing but the live checkpoint is left, as after a loss of power."""
    assert call("render", room, "-o", tmp_path / "whole", "--quiet", *QUICK).code == 0
    monkeypatch.setattr(live_files, "LEAST_PAUSE", 0.0)
    with monkeypatch.context() as patched:
        patched.setattr(closing, "publish", killed)
        patched.setattr(closing, "write_results", killed)
        with pytest.raises(RuntimeError, match="killed"):
            call("render", room, "-o", tmp_path / "out", "--replicates", 8, *QUICK)
    assert not (tmp_path / "out").exists()
    assert (tmp_path / "out.partial" / "checkpoint.h5").exists()
    outcome = call("render", room, "-o", tmp_path / "out", "--resume", *QUICK)
    assert outcome.code == 0
    assert "going on from replicate" in outcome.out
    assert_same_bits(tmp_path / "whole", tmp_path / "out")


def killed(*arguments, **keywords):
    raise RuntimeError("killed")


def test_more_replicates_on_a_finished_result(room, call, tmp_path):
    """Twice the replicates with twice the samples are the same replicates and more."""
    double = [str(2 * int(word)) if word.isdigit() else word for word in QUICK]
    assert call("render", room, "-o", tmp_path / "whole", "--quiet", "--replicates", 16, *double).code == 0
    assert call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK).code == 0
    other = call("render", room, "-o", tmp_path / "out", "--resume", "--replicates", 16, *QUICK)
    assert other.code == 2
    assert "settings" in other.err
    assert call("render", room, "-o", tmp_path / "out", "--resume", "--replicates", 16, *double).code == 0
    assert_same_bits(tmp_path / "whole", tmp_path / "out")


def test_resume_refuses_another_scene(room, call, tmp_path):
    call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK)
    text = (room / "scene.toml").read_text()
    (room / "scene.toml").write_text(text.replace("reflectance = 0.2", "reflectance = 0.21"))
    outcome = call("render", room, "-o", tmp_path / "out", "--resume", *QUICK)
    assert outcome.code == 2
    assert "another scene" in outcome.err
    assert (tmp_path / "out" / "readings.csv").exists()


def test_interrupted_before_anything_is_known(room, call, tmp_path, monkeypatch):
    call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK)
    before = (tmp_path / "out" / "spectra.csv").read_bytes()
    interrupted_at(monkeypatch, 0, False)
    outcome = call("render", room, "-o", tmp_path / "out", "--seed", 7, *QUICK)
    assert outcome.code == 130
    assert "nothing was known yet" in outcome.err
    assert (tmp_path / "out" / "spectra.csv").read_bytes() == before
    assert not (tmp_path / "out.partial").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals(room, tmp_path, number):
    """A real signal in the middle of a long run; the results are whole."""
    process = subprocess.Popen(
        [sys.executable, "-m", "hradiosity", "render", str(room), "-o", "out", "--json", *ENDLESS],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    for line in process.stdout:
        event = json.loads(line)
        if event["event"] == "state" and event["replicate"] == 2:
            break
    process.send_signal(number)
    rest, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert json.loads(rest.splitlines()[-1])["state"] == "interrupted"
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert 2 <= run["replicates"] < 250
    assert len((tmp_path / "out" / "spectra.csv").read_text().splitlines()) == 8
    assert cells(tmp_path / "out")["irradiance"].shape[1] == 9
    assert "Traceback" not in errors
