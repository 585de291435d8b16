"""Collects what is wrong or worth saying while a scene is read, so that all of it reaches the user at once."""

import difflib
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

from hradiosity.errors import Fault, SceneError
from hradiosity.io.scene.lines import Location, find_lines, line_of
from hradiosity.model.scene import Note


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A sentence that offers the closest known word, or else lists what is known."""
    choices = sorted(known)
    folded = {choice.casefold(): choice for choice in choices}
    close = difflib.get_close_matches(word.casefold(), folded, n=1, cutoff=0.6)
    if close:
        return f"did you mean {folded[close[0]]!r}?"
    if not choices:
        return "none is defined"
    shown = ", ".join(choices[:12])
    return f"known: {shown}, …" if len(choices) > 12 else f"known: {shown}"


def entry_name(location: Location) -> str:
    """``("box", 2, "size")`` as ``box[2].size``."""
    name = ""
    for part in location:
        if isinstance(part, int):
            name += f"[{part}]"
        else:
            name += f".{part}" if name else part
    return name


class Report:
    """Faults and notes of one scene file, with the line that each belongs to.

    Parameters
    ----------
    path : Path
        The scene file; other files are looked for beside it.
    text : str
        Its content.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.notes: list[Note] = []
        self._text = text
        self._faults: list[tuple[int, Fault]] = []
        self._numbers: dict[str, list[int]] = {}

    @cached_property
    def _lines(self) -> dict[Location, int]:
        """Where entries stand: only asked for where there is something to say of one."""
        return find_lines(self._text)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All faults so far, in the order of the lines they stand in."""
        return tuple(fault for _, fault in sorted(self._faults, key=lambda entry: entry[0]))

    def renumber(self, key: str, kept: list[int]) -> None:
        """Say that only some entries of a list are looked at from now on: entry i is number ``kept[i]`` so far."""
        before = self._numbers.get(key)
        self._numbers[key] = kept if before is None else [before[i] for i in kept]

    def _in_file(self, location: Location) -> Location:
        """Location with the numbers that the entries have in the file."""
        if len(location) > 1 and isinstance(location[1], int) and location[0] in self._numbers:
            return (location[0], self._numbers[str(location[0])][location[1]], *location[2:])
        return location

    def place(self, location: Location) -> str:
        """``scene.toml:12 box[2].size``, without the line where none is known."""
        location = self._in_file(location)
        return f"{self._file_line(location)} {entry_name(location)}"

    def _file_line(self, location: Location) -> str:
        line = line_of(self._lines, location)
        return f"{self.path}:{line}" if line is not None else str(self.path)

    def fault(self, location: Location, found: str, expected: str) -> None:
        """Add a fault of the scene file."""
        location = self._in_file(location)
        fault = Fault(self._file_line(location), entry_name(location), found, expected)
        self._faults.append((line_of(self._lines, location) or 0, fault))

    def warn(self, location: Location, message: str) -> None:
        """Add a warning: a number may be affected."""
        self.notes.append(Note("warning", self.place(location), message))

    def inform(self, location: Location, message: str) -> None:
        """Add a note on something that was assumed."""
        self.notes.append(Note("info", self.place(location), message))

    def adopt(self, error: SceneError, location: Location) -> None:
        """Take over the faults of another file, saying which entry asked for it."""
        line = line_of(self._lines, self._in_file(location)) or 0
        asked = f"asked for by {self.place(location)}"
        for fault in error.faults:
            expected = f"{fault.expected} ({asked})" if fault.expected else asked
            self._faults.append((line, Fault(fault.file, fault.entry, fault.found, expected)))

    def find_file(self, name: str, location: Location) -> Path | None:
        """The file that an entry names, relative to the scene file's folder; None and a fault when there is none."""
        path = self.path.parent / name
        if path.is_file():
            return path
        folder = path.parent
        beside = [other.name for other in folder.iterdir() if other.is_file()] if folder.is_dir() else []
        close = difflib.get_close_matches(path.name, beside, n=1, cutoff=0.6)
        hint = f"did you mean {close[0]!r}?" if close else "paths are relative to the folder of the scene file"
        self.fault(location, f"no file {path}", hint)
        return None

    def raise_faults(self) -> None:
        """Raise ``SceneError`` if there is any fault."""
        if self._faults:
            raise SceneError(self.faults)
