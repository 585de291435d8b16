"""Results are swapped in as a whole, whatever interrupts it, and nothing else is ever touched."""

import errno
import json
import os
import subprocess
from pathlib import Path

import pytest

from hradiosity.errors import OutputError
from hradiosity.io import output_folder
from hradiosity.io.output_folder import (
    RUN_FILE,
    close_partial,
    old_of,
    open_partial,
    partial_of,
    publish,
    recover,
    write_file,
)


def result(folder, text, state="complete"):
    folder.mkdir()
    (folder / "pictures").mkdir()
    (folder / "pictures" / "a.png").write_text(text)
    (folder / "readings.csv").write_text(text)
    (folder / RUN_FILE).write_text(json.dumps({"program": "hradiosity", "state": state}))
    return folder


def content(out):
    return (out / "readings.csv").read_text()


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def only(out, text):
    assert content(out) == text
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_publish_replaces(out):
    result(out, "earlier")
    result(partial_of(out), "new")
    publish(out)
    only(out, "new")


def test_publish_first_result(out):
    result(partial_of(out), "new")
    publish(out)
    only(out, "new")


def test_nothing_to_recover(out):
    result(out, "earlier")
    assert recover(out) is None
    only(out, "earlier")


def test_recover_before_the_swap(out):
    result(out, "earlier")
    result(partial_of(out), "new")
    assert "finished" in recover(out)
    only(out, "new")


def test_recover_between_the_renames(out):
    result(old_of(out), "earlier")
    result(partial_of(out), "new")
    assert "finished" in recover(out)
    only(out, "new")


def test_recover_after_the_swap(out):
    result(out, "new")
    result(old_of(out), "earlier")
    assert "deleted" in recover(out)
    only(out, "new")


@pytest.mark.parametrize("left", [[RUN_FILE], [RUN_FILE, "readings.csv"], []])
def test_recover_in_the_middle_of_deleting(out, left):
    result(out, "new")
    old = result(old_of(out), "earlier")
    (old / "pictures" / "a.png").unlink()
    (old / "pictures").rmdir()
    for name in (RUN_FILE, "readings.csv"):
        if name not in left:
            (old / name).unlink()
    output_folder.check_free(out)
    assert "deleted" in recover(out)
    only(out, "new")


def test_recover_without_a_new_result(out):
    result(old_of(out), "earlier")
    result(partial_of(out), "half", state="running")
    assert "put" in recover(out)
    assert content(out) == "earlier"
    assert partial_of(out).exists()


def test_every_step_of_publishing_may_be_the_last(out, monkeypatch):
    """Stop before each call that changes the disk in turn; recovery ends with one whole result."""
    changing = [(Path, "rename"), (Path, "unlink"), (Path, "rmdir"), (output_folder.shutil, "rmtree")]
    for allowed in range(20):
        result(out, "earlier")
        result(partial_of(out), "new")
        steps = iter(range(allowed))

        def stopping(original, steps=steps):
            def call(*arguments, **keywords):
                if next(steps, None) is None:
                    raise KeyboardInterrupt
                return original(*arguments, **keywords)

            return call

        with monkeypatch.context() as patched:
            for owner, name in changing:
                patched.setattr(owner, name, stopping(getattr(owner, name)))
            try:
                publish(out)
                finished = True
            except KeyboardInterrupt:
                finished = False
        output_folder.check_free(out)
        recover(out)
        only(out, "new")
        subprocess.run(["rm", "-r", str(out)], check=True)
        if finished:
            assert allowed > 4
            return
    pytest.fail("publishing never ended")


def test_open_partial_deletes_what_was_left_unless_asked_to_keep(out):
    result(partial_of(out), "half", state="running")
    assert content(open_partial(out, keep=True)) == "half"
    assert [path.name for path in open_partial(out).iterdir()] == [RUN_FILE]
    close_partial(out)
    assert list(out.parent.iterdir()) == []


@pytest.mark.parametrize("place", ["out", "out.partial", "out.old"])
def test_what_is_not_ours_stays(tmp_path, out, place):
    (tmp_path / place).mkdir()
    (tmp_path / place / "thesis.txt").write_text("years")
    with pytest.raises(OutputError, match="left as it is"):
        open_partial(out)
    assert (tmp_path / place / "thesis.txt").read_text() == "years"


def test_a_file_in_the_way_stays(out):
    out.write_text("mine")
    with pytest.raises(OutputError, match="left as it is"):
        open_partial(out)
    assert out.read_text() == "mine"


def test_write_file_leaves_the_earlier_one_when_the_disk_is_full(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    write_file(path, b"earlier")

    def full(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"a\.csv can't be written: no space left"):
        write_file(path, b"new")
    assert path.read_bytes() == b"earlier"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.csv"]


def test_full_disk(small_disk):
    out = small_disk / "out"
    result(out, "earlier")
    partial = open_partial(out)
    with pytest.raises(OutputError, match="no space left"):
        write_file(partial / "spectra.csv", bytes(200_000))
    close_partial(out)
    assert content(out) == "earlier"
    assert [path.name for path in small_disk.iterdir()] == ["out"]
