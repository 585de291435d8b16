"""Tables as TOML text, since the standard library only reads it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_text(tables: Mapping[str, Any], remark: str) -> str:
    """A document: a remark, then each table with a header, and lists of tables with a header for each entry."""
    lines = [f"# {line}" for line in remark.splitlines()]
    for key, value in tables.items():
        if isinstance(value, Mapping):
            lines += _table((key,), value)
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                lines += ["", f"[[{_key(key)}]]", *_entries(item)]
        else:
            lines.insert(len(remark.splitlines()), f"{_key(key)} = {_value(value)}")
    return "\n".join(lines) + "\n"


def _table(path: tuple[str, ...], table: Mapping[str, Any]) -> list[str]:
    """A table; if it holds nothing but tables, such as ``materials``, each of them gets a header of its own."""
    if table and all(isinstance(value, Mapping) for value in table.values()):
        return [line for key, value in table.items() for line in _headed((*path, key), value)]
    return _headed(path, table)


def _headed(path: tuple[str, ...], table: Mapping[str, Any]) -> list[str]:
    return ["", f"[{'.'.join(map(_key, path))}]", *_entries(table)]


def _entries(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items()]


def _key(key: str) -> str:
    plain = key.isascii() and key.replace("-", "").replace("_", "").isalnum()
    return key if plain else _string(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_entries(value)) + " }" if value else "{}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise TypeError(f"no scene holds a value like {value!r}")


def _string(text: str) -> str:
    """A basic string: its escapes are those of JSON, and DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
