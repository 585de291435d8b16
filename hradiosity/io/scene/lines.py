"""Where an entry stands in a TOML file: the parser gives no positions, so the text is searched for its keys."""

import re
from functools import lru_cache

Location = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*(\[\[?)\s*(.+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"^\s*((?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'))*)\s*=")
_PART = re.compile(r"[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'")


@lru_cache(maxsize=1024)
def _parts(dotted: str) -> Location:
    return tuple(part.strip("\"'") for part in _PART.findall(dotted))


def find_lines(text: str) -> dict[Location, int]:
    """Line number (from 1) of each table header and each key that begins a line.

    Entries of an array of tables carry their number: ``("box", 2, "size")``.
    """
    lines: dict[Location, int] = {}
    count: dict[Location, int] = {}
    table: Location = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            name = _parts(header.group(2))
            if header.group(1) == "[[":
                index = count.get(name, 0)
                count[name] = index + 1
                lines.setdefault(name, number)
                table = (*name, index)
            else:
                table = name
            lines.setdefault(table, number)
        elif key := _KEY.match(line):
            lines.setdefault(table + _parts(key.group(1)), number)
    return lines


def line_of(lines: dict[Location, int], location: Location) -> int | None:
    """Line of an entry, or of the closest entry around it; None at the top of the file."""
    for length in range(len(location), 0, -1):
        if location[:length] in lines:
            return lines[location[:length]]
    return None
