"""The program refuses a job that does not fit into memory, and leaves no folder behind."""

from dataclasses import replace

import pytest
from cli_room import QUICK

from hradiosity import planning_memory


@pytest.fixture
def machine_of_a_mebibyte(device, monkeypatch):
    monkeypatch.setattr(device, "info", replace(device.info, global_memory_bytes=2**30))
    monkeypatch.setattr(planning_memory, "available_host_bytes", lambda: 2**20)


def test_render_refuses(room, call, tmp_path, machine_of_a_mebibyte):
    outcome = call("render", room, "-o", tmp_path / "out", "--elements", 5000, *QUICK[2:])
    assert outcome.code == 2
    assert "command line: --elements: the run needs about" in outcome.err
    assert "this machine has free 0.000977 GiB; --elements" in outcome.err and "or less" in outcome.err
    assert "Traceback" not in outcome.err
    assert not (tmp_path / "out").exists() and not (tmp_path / "out.partial").exists()


def test_an_earlier_result_stays(room, call, tmp_path, device, monkeypatch):
    assert call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK).code == 0
    before = (tmp_path / "out" / "readings.csv").read_bytes()
    monkeypatch.setattr(device, "info", replace(device.info, global_memory_bytes=1000))
    assert call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK).code == 2
    assert (tmp_path / "out" / "readings.csv").read_bytes() == before
