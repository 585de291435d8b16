"""``hradiosity cost``: from a scene and a budget to tables, picture and what plan makes of it."""

import csv
import io
import json

import numpy as np
import pytest

from hradiosity.suites.cost import extras, running, settings
from hradiosity.suites.cost.bench import SceneBench
from hradiosity.suites.cost.budget import Budget
from hradiosity.suites.cost.files import COLUMNS
from hradiosity.suites.cost.running import CostRun

FILES = {"bands.csv", "cost.csv", "cost.json", "cost.md", "cost.png", "referee.npz", "run.json"}


@pytest.fixture(autouse=True)
def short(monkeypatch, device):
    """One device serves all calls, so that its kernels are loaded once; few things are measured, whatever the load."""
    monkeypatch.setattr("hradiosity.device.Device", lambda spec=None: device)
    monkeypatch.setattr(extras, "SOLVERS", ("cg", "jacobi"))
    monkeypatch.setattr(extras, "BANDS", (9, 24))
    monkeypatch.setattr(running, "single_knobs", lambda: settings.single_knobs()[:1])
    monkeypatch.setattr(running, "classic", lambda: settings.classic()[:1])
    monkeypatch.setattr(running, "methods", lambda: settings.methods()[1:2])
    monkeypatch.setattr(running, "SEEDS", 1)
    monkeypatch.setattr(SceneBench, "clock", lambda bench: bench.device.work_cpu_seconds())


@pytest.mark.slow
def test_from_scene_to_report(call, room, tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr(Budget, "holds", lambda budget, predicted, share=1.0: True)
    out = tmp_path / "prices"
    outcome = call("cost", room, "--budget", "5s", "--out", out)
    assert outcome.code == 0
    assert {path.name for path in out.iterdir()} == FILES
    rows = list(csv.DictReader(io.StringIO((out / "cost.csv").read_text(encoding="utf-8"))))
    assert tuple(rows[0]) == COLUMNS and {"draft", "normal", "fine"} <= {row["setting"] for row in rows}
    assert any(row["on_front"] == "True" or row["illuminance_below_noise"] == "True" for row in rows)
    seconds = [float(row["cpu_s"]) for row in rows]
    assert seconds == sorted(seconds) and seconds[0] > 0.0
    assert all(0.0 < float(row["illuminance_rms"]) < 0.5 for row in rows)
    record = json.loads((out / "cost.json").read_text(encoding="utf-8"))
    assert record["complete"] and record["recommendation"] and record["paths"] > 0
    assert [s["name"] for s in record["solvers"]] == ["cg", "jacobi"] and len(record["effects"]) == 4
    assert [b["bands"] for b in record["bands"]] == [9, 24]
    assert record["bands"][0]["cct"] > 0.0 and abs(record["bands"][0]["melanopic"]) < 0.2
    rows = list(csv.DictReader(io.StringIO((out / "bands.csv").read_text(encoding="utf-8"))))
    assert [row["bands"] for row in rows] == ["9", "24"] and float(rows[0]["ra_rms"]) > 0.0
    assert "| setting" in outcome.out and "referee:" in outcome.out
    assert np.asarray(Image.open(out / "cost.png")).std() > 10.0
    wanted = "accuracy 5 %: about"
    plans = call("plan", room, "--accuracy", "5%").out
    assert wanted in plans and "as hradiosity cost measured" in plans
    assert "run hradiosity cost" in call("plan", room, "--accuracy", "5%", "--elements", "77").out
    assert "accuracy" not in call("plan", room).out
    with np.load(out / "referee.npz") as kept:
        before = int(kept["paths"])
    assert call("cost", room, "--budget", "1s", "--out", out, "--quiet").out == ""
    with np.load(out / "referee.npz") as kept:
        assert int(kept["paths"]) > before


def test_interrupted(call, room, tmp_path, monkeypatch):
    """What is known after the second setting is written, and the status says so."""
    whole = CostRun.events

    def broken(self):
        for event in whole(self):
            yield event
            if len(self.runs) == 2 and self.bench.reference.paths:
                raise KeyboardInterrupt

    monkeypatch.setattr(CostRun, "events", broken)
    out = tmp_path / "prices"
    outcome = call("cost", room, "--budget", "60s", "--out", out, "--json")
    assert outcome.code == 130
    record = json.loads((out / "cost.json").read_text(encoding="utf-8"))
    assert not record["complete"] and len(record["prices"]) == 2
    events = [json.loads(line) for line in outcome.out.splitlines()]
    assert [event["event"] for event in events][:2] == ["run", "run"]
    assert events[-1]["event"] == "result" and events[-1]["state"] == "interrupted"


@pytest.mark.parametrize("budget", ["0s", "soon", "-3s"])
def test_bad_budget(call, room, tmp_path, budget):
    outcome = call("cost", room, f"--budget={budget}", "--out", tmp_path / "prices")
    assert outcome.code == 2 and not (tmp_path / "prices").exists()


def test_a_budget_for_nothing(call, room, tmp_path):
    outcome = call("cost", room, "--budget", "0.01s", "--out", tmp_path / "prices")
    assert outcome.code == 2
    assert "--budget" in outcome.err and "suffice" in outcome.err
    assert not (tmp_path / "prices").exists() and not (tmp_path / "prices.partial").exists()


def test_a_scene_without_sensors(call, room, tmp_path):
    file = room / "scene.toml"
    file.write_text(file.read_text(encoding="utf-8").split("[[sensor]]")[0], encoding="utf-8")
    outcome = call("cost", room, "--out", tmp_path / "prices")
    assert outcome.code == 2 and "no sensor" in outcome.err
