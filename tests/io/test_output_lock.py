"""Two runs never write to one folder, and a killed one stands in nobody's way."""

import errno
import os
import signal
import subprocess
import sys

import pytest

from hradiosity.errors import OutputError
from hradiosity.io import output_lock
from hradiosity.io.output_lock import lock_of, locked

HOLD = """
import sys, time
from pathlib import Path
from hradiosity.io.output_lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def out(tmp_path):
    return tmp_path / "results" / "out"


@pytest.fixture
def other(out):
    """Another process that holds the lock."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(out)], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_second_run_is_told_who_is_there(out, other):
    with (
        pytest.raises(OutputError, match=rf"another run \(process {other.pid} on .+ since 20.+\) is writing to .*out;"),
        locked(out),
    ):
        pass
    assert lock_of(out).exists()
    with locked(out.with_name("another")):
        pass


def test_a_killed_run_does_not_block_the_next(out, other):
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert lock_of(out).exists()
    with locked(out):
        assert str(os.getpid()) in lock_of(out).read_text()
    assert not lock_of(out).exists()


@pytest.mark.parametrize("left", ["", "no JSON", '{"pid": 1, "host": "elsewhere", "since": "2020"}', '["x"]'])
def test_what_an_earlier_run_left_is_taken_over(out, left):
    out.parent.mkdir()
    lock_of(out).write_text(left)
    with locked(out), pytest.raises(OutputError, match=f"process {os.getpid()} on"), locked(out):
        pass
    assert list(out.parent.iterdir()) == []


def test_an_error_lets_go(out):
    with pytest.raises(RuntimeError), locked(out):
        raise RuntimeError
    with locked(out):
        pass


def test_a_lock_removed_before_it_was_taken_is_not_trusted(out, monkeypatch):
    """Its holder ends between our opening and our locking: a third run could lock a new file of that name."""
    take, taken = output_lock._take, []

    def removed_first(descriptor):
        if not taken:
            lock_of(out).unlink()
        taken.append(descriptor)
        take(descriptor)

    monkeypatch.setattr(output_lock, "_take", removed_first)
    with locked(out):
        assert len(taken) == 2
        with pytest.raises(OutputError, match="another run"), locked(out):
            pass


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"out\.lock can't be made"), locked(tmp_path / "file" / "out"):
        pass


def test_file_systems_without_locks_still_take_results(out, monkeypatch):
    def refuse(descriptor):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(output_lock, "_take", refuse)
    with locked(out):
        pass
    assert not lock_of(out).exists()
