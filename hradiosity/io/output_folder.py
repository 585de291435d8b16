"""The folder of a run: written beside the earlier result and swapped in at the end, so that nothing is ever half there.

A run writes to ``OUT.partial``. At the end ``OUT`` becomes ``OUT.old``, ``OUT.partial`` becomes ``OUT``, and the old
one is deleted; `recover` puts right whatever an interruption in between leaves. `output_lock` keeps a second run away.
"""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

from hradiosity.errors import OutputError

RUN_FILE = "run.json"
CHECKPOINT_FILE = "checkpoint.h5"
PROGRAM = "hradiosity"
RUNNING = "running"
"""Value of ``state`` in ``run.json`` while the folder is not whole yet."""


def partial_of(out: Path) -> Path:
    """Where a run writes before its result is whole."""
    return out.with_name(f"{out.name}.partial")


def old_of(out: Path) -> Path:
    """Where the earlier result lies while the new one takes its place."""
    return out.with_name(f"{out.name}.old")


def write_file(path: Path, data: bytes) -> None:
    """Write a file as a whole or not at all.

    Raises
    ------
    OutputError
        When it can't be written; what was there before is still there.
    """
    draft = _draft_of(path)
    try:
        with draft.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(path)
    except OSError as error:
        _discard(draft)
        raise OutputError(f"{path} can't be written: {reason(error)}") from error


def _draft_of(path: Path) -> Path:
    """Where a file is written before it takes its place."""
    return path.with_name(f"{path.name}.draft")


def reason(error: OSError) -> str:
    """What the system says, without number and path."""
    return (error.strerror or str(error)).lower()


def check_free(out: Path) -> None:
    """Raise `OutputError` when something that is no result of this program is in the way."""
    for path in (out, partial_of(out), old_of(out)):
        if path.exists() and not _is_result(path):
            raise OutputError(f"{path} exists and is no result of {PROGRAM}; it is left as it is, name another folder")
    if out.exists() and out.is_mount():
        raise OutputError(f"{out} is a mount point and can't be renamed; name a folder inside it")


def open_partial(out: Path, *, keep: bool = False) -> Path:
    """Recover, then make ``OUT.partial`` and prove that it can be written.

    Parameters
    ----------
    keep : bool
        Keep what an interrupted run left there, to go on from it; otherwise it is deleted.

    Returns
    -------
    Path
        Of the folder to write to.

    Raises
    ------
    OutputError
        When it can't be written or something else is in the way; nothing was changed then.
    """
    check_free(out)
    recover(out)
    partial = partial_of(out)
    try:
        if partial.exists() and not keep:
            _delete(partial)
        partial.mkdir(parents=True, exist_ok=True)
        for draft in partial.rglob("*.draft"):
            draft.unlink()
    except OSError as error:
        raise OutputError(f"{partial} can't be made: {reason(error)}") from error
    if not (partial / RUN_FILE).exists():
        write_file(partial / RUN_FILE, json.dumps({"program": PROGRAM, "state": RUNNING}).encode())
    return partial


def close_partial(out: Path) -> None:
    """Delete ``OUT.partial``, when there is nothing in it to keep."""
    partial = partial_of(out)
    if partial.exists() and _is_result(partial):
        _delete(partial)


def publish(out: Path) -> None:
    """Let ``OUT.partial`` take the place of ``OUT``; its ``run.json`` must no longer say that it is running.

    A live checkpoint goes first: the result holds one, too, and is whole without this one.

    Raises
    ------
    OutputError
        When a folder can't be renamed; `recover` puts it right at the next start.
    """
    partial, old = partial_of(out), old_of(out)
    try:
        (partial / CHECKPOINT_FILE).unlink(missing_ok=True)
        if out.exists():
            out.rename(old)
        partial.rename(out)
        _sync_folder(out.parent)
        if old.exists():
            _delete(old)
    except OSError as error:
        raise OutputError(f"{partial} can't take the place of {out}: {reason(error)}") from error


def recover(out: Path) -> str | None:
    """Put right what an interrupted `publish` left.

    Returns
    -------
    str or None
        What was done, in words; None when there was nothing to do.
    """
    partial, old = partial_of(out), old_of(out)
    try:
        if old.exists() and out.exists():
            _delete(old)
            return f"deleted {old}, left by an interrupted run"
        if _is_whole(partial):
            publish(out)
            return f"finished {out}, which an interrupted run had left in {partial}"
        if old.exists():
            old.rename(out)
            return f"put {out} back, which an interrupted run had moved to {old}"
    except OSError as error:
        raise OutputError(f"{out} can't be recovered: {reason(error)}") from error
    return None


def read_run(folder: Path) -> dict[str, Any] | None:
    """``run.json`` of a folder; None when there is none of ours."""
    try:
        found = json.loads((folder / RUN_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and found.get("program") == PROGRAM else None


def _is_result(path: Path) -> bool:
    """A folder of ours, or one that was just made: empty, or with the draft of its first file."""
    if not path.is_dir():
        return False
    return read_run(path) is not None or all(entry == _draft_of(path / RUN_FILE) for entry in path.iterdir())


def _is_whole(partial: Path) -> bool:
    run = read_run(partial)
    return run is not None and run.get("state") != RUNNING


def _delete(folder: Path) -> None:
    """Delete a result, its ``run.json`` last: what is left after an interruption can still be told to be ours."""
    for path in folder.iterdir():
        if path.name == RUN_FILE:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
    (folder / RUN_FILE).unlink(missing_ok=True)
    folder.rmdir()


def _discard(draft: Path) -> None:
    try:
        draft.unlink(missing_ok=True)
    except OSError:
        return


def _sync_folder(folder: Path) -> None:
    """Make renames last through a loss of power, where the system can."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
