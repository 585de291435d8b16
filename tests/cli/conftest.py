"""A small room on disk, and the program run in this process."""

from dataclasses import dataclass

import pytest
from cli_room import ROOM

from hradiosity.cli import main, session
from hradiosity.device import Device
from hradiosity.io.cache import CACHE_VARIABLE


@dataclass(frozen=True)
class Outcome:
    """What a run gave back."""

    code: int
    out: str
    err: str


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    """Nothing that a test measures reaches the user's own cache."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path_factory.getbasetemp() / "speeds"))


@pytest.fixture
def room(tmp_path):
    """Folder of the small room."""
    folder = tmp_path / "room"
    folder.mkdir()
    (folder / "scene.toml").write_text(ROOM)
    return folder


@pytest.fixture
def call(capsys, device, monkeypatch):
    """Call the program with arguments; one device serves all calls, so that its kernels are loaded once. Each call says
    for itself what is built.
    """
    monkeypatch.setattr(session, "Device", lambda spec: device if spec is None else Device(spec))

    def run(*arguments):
        device.on_build = None
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return run
