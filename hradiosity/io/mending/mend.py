"""The mended copy: mend, write, read again and check, until nothing is left that can be mended."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from hradiosity.errors import OutputError
from hradiosity.io.mending.repairs import repairs
from hradiosity.io.mending.scene_copy import CannotMend, SceneCopy
from hradiosity.io.output_folder import reason
from hradiosity.io.scene_toml import SCENE_FILE, load_scene
from hradiosity.model.scene import Scene
from hradiosity.space.check import Finding, Subject, all_findings, ordered

_ROUNDS: Final = 8
_TRIES: Final = 2
"""How often one finding is mended before it counts as one that can't be."""

Examine = Callable[[Scene], Subject]


@dataclass(frozen=True)
class Mended:
    """What became of a scene.

    done : what was mended, in words, with the kind of finding in front
    refused : findings that can't be mended safely, and why, by kind and object
    findings : about the copy, as `check_scene` orders them
    """

    done: tuple[str, ...]
    refused: tuple[str, ...]
    findings: tuple[Finding, ...]


@dataclass
class _Log:
    """What was done and refused so far, and how often each repair was tried."""

    done: list[str] = field(default_factory=list)
    refused: dict[str, None] = field(default_factory=dict)
    tried: dict[tuple[str, tuple[str, ...]], int] = field(default_factory=dict)


def check_target(folder: Path) -> None:
    """Raise `OutputError` unless a copy can be written to a folder, which must be new or empty."""
    if folder.is_dir() and not any(folder.iterdir()):
        return
    if folder.exists():
        raise OutputError(f"{folder} exists and is left as it is; name a new folder for the mended copy")


def write_mended_copy(file: Path, folder: Path, examine: Examine) -> Mended:
    """Write a copy of a scene in which everything is mended that can be without asking.

    The original is only read. The folder appears when the copy is whole.

    Parameters
    ----------
    file : Path
        A scene file that can be read without faults.
    folder : Path
        New or empty.
    examine : callable
        From a scene to what checks look at.

    Raises
    ------
    OutputError
        When the folder holds something or can't be written.
    """
    check_target(folder)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent) as place:
            mended, work = _mend(file, Path(place), examine)
            if folder.exists():
                folder.rmdir()
            work.rename(folder)
    except OSError as error:
        raise OutputError(f"{folder} can't be written: {reason(error)}") from error
    return mended


def _mend(file: Path, place: Path, examine: Examine) -> tuple[Mended, Path]:
    """Rounds of mending, each in a folder of its own that begins with what the one before has written."""
    work = place / "0"
    work.mkdir()
    SceneCopy(file).write(work)
    subject = examine(load_scene(work))
    findings = all_findings(subject)
    log = _Log()
    for number in range(1, _ROUNDS + 1):
        scene = SceneCopy(work / SCENE_FILE)
        said = _change(scene, subject, findings, log)
        if not said:
            break
        work = place / str(number)
        work.mkdir()
        scene.write(work)
        subject = examine(load_scene(work))
        findings = all_findings(subject)
        log.done += said
    return Mended(tuple(log.done), tuple(log.refused), ordered(findings)), work


def _change(scene: SceneCopy, subject: Subject, findings: list[Finding], log: _Log) -> list[str]:
    """Make all changes of one round, of no object twice; says what was done."""
    changed: set[str] = set()
    said = []
    for repair in repairs(subject, findings):
        key = (repair.kind, repair.objects)
        if log.tried.get(key, 0) == _TRIES or changed & set(repair.objects):
            continue
        log.tried[key] = log.tried.get(key, 0) + 1
        try:
            changed.add(repair.apply(scene))
        except CannotMend as error:
            names = " and ".join(f"'{name}'" for name in dict.fromkeys(repair.objects))
            log.refused[f"{repair.kind} of {names}: {error}"] = None
            log.tried[key] = _TRIES
            continue
        said.append(f"{repair.kind}: {repair.done}")
    return said
