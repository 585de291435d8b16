"""TOML of long scene files in less time: plain entries of lists, such as thousands of boxes, are read as JSON.

Everything else, and all of the file wherever something is not plain, goes to ``tomllib``.
"""

from __future__ import annotations

import json
import re
import tomllib
from typing import Any, Final

SHORT: Final = 20_000
"""Characters up to which ``tomllib`` alone is quick enough."""
_KEY = r"[A-Za-z][A-Za-z0-9_-]*"
_STRING = r'"[^"\\\x00-\x1f\x7f]*"'
_NUMBER = r"-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
_LISTS = "|".join(rf"\[ *{value}(?: *, *{value})* *\]" for value in (_NUMBER, _STRING))
_TABLE = rf"\{{ *{_KEY} *= *{_STRING}(?: *, *{_KEY} *= *{_STRING})* *\}}"
_PLAIN = re.compile(rf"^({_KEY}) *= *(?:({_STRING}|{_NUMBER}|true|false|{_LISTS})|({_TABLE}))$")
"""Values that TOML and JSON write alike, and tables of strings."""
_PAIR = re.compile(rf"({_KEY}) *= *({_STRING})")
_HEADER = re.compile(rf"^\[\[({_KEY})\]\]$")


def parse(text: str) -> dict[str, Any]:
    """What ``tomllib.loads`` finds.

    Raises
    ------
    tomllib.TOMLDecodeError, RecursionError, ValueError
        As that does.
    """
    found = _parse_plain(text) if len(text) > SHORT else None
    return tomllib.loads(text) if found is None else found


def _parse_plain(text: str) -> dict[str, Any] | None:
    """The tables; None where it takes ``tomllib`` to tell."""
    if '"""' in text or "'''" in text:
        return None
    read = [(block, *_entry(block)) for block in _blocks(text)]
    mixed = {name for _, name, entry in read if entry is None}
    other = [line for block, name, _ in read if name in mixed for line in block]
    plain: dict[str, list[dict[str, Any]]] = {}
    for _, name, entry in read:
        if name not in mixed and entry is not None:
            plain.setdefault(name, []).append(entry)
    if any(line.count("[") != line.count("]") or ("#" in line and "[" in line) for line in other):
        return None  # a list over several lines may hold what looks like an entry
    try:
        rest = tomllib.loads("\n".join(other))
    except (ValueError, RecursionError):
        return None
    if any(name in rest for name in plain):  # it goes on there
        return None
    return rest | plain


def _blocks(text: str) -> list[list[str]]:
    """Lines up to the next that begins with a bracket."""
    blocks: list[list[str]] = [[""]]
    for line in text.split("\n"):
        if line.startswith("["):
            blocks.append([line])
        else:
            blocks[-1].append(line)
    return blocks


def _entry(block: list[str]) -> tuple[str, dict[str, Any] | None]:
    """Name of the list and the entry, if that is plain; no name where the block begins with something else."""
    header = _HEADER.match(block[0])
    return ("", None) if header is None else (header.group(1), _plain_entry(block[1:]))


def _plain_entry(lines: list[str]) -> dict[str, Any] | None:
    """Keys and values of plain lines; None where one is not, or a key is there twice."""
    pairs = []
    for line in filter(None, lines):
        match = _PLAIN.match(line)
        if match is None:
            return None
        key, value, table = match.groups()
        if table is not None:
            inner = _PAIR.findall(table)
            if len(dict(inner)) < len(inner):
                return None
            value = "{" + ",".join(f'"{name}":{word}' for name, word in inner) + "}"
        pairs.append(f'"{key}":{value}')
    entry: dict[str, Any] = json.loads("{" + ",".join(pairs) + "}")
    return entry if len(entry) == len(pairs) else None
