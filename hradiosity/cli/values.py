"""What users write on the command line as values: percentages, durations, switches."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import Enum
from typing import Any, Final, Literal, TypeAlias

FalseColor: TypeAlias = Literal["illuminance", "luminance"]
FalseColorScale: TypeAlias = Literal["linear", "log"]

_SECONDS: Final = {"": 1.0, "s": 1.0, "sec": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}
_NUMBER: Final = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*([a-z%]*)\s*")


class Switch(Enum):
    """An effect that is computed, left out, or as the scene calls for."""

    auto = "auto"
    on = "on"
    off = "off"

    @property
    def forced(self) -> bool | None:
        """As `Options` takes it."""
        return {"auto": None, "on": True, "off": False}[self.value]


class White(Enum):
    """What pictures show as white; names as in `hradiosity.show.white`, which is not imported for ``--help``."""

    as_measured = "as-measured"
    lamps = "lamps"


def share(kind: object, tokens: Sequence[Any]) -> float:
    """``1%`` or ``0.01`` as 0.01; called by cyclopts."""
    text = str(tokens[0].value)
    match = _NUMBER.fullmatch(text)
    if not match or match[2] not in ("", "%"):
        raise ValueError(f"{text!r} is no share; write it like 1% or 0.01")
    value = float(match[1]) / (100.0 if match[2] else 1.0)
    if not 0.0 < value < 1.0:
        hint = f"; did you mean {text}%?" if not match[2] and 1.0 <= value < 100.0 else ""
        raise ValueError(f"{text!r} must lie between 0 and 100 %{hint}")
    return value


def seconds(kind: object, tokens: Sequence[Any]) -> float:
    """``30s``, ``2min``, ``1h`` or ``30`` in seconds; called by cyclopts."""
    text = str(tokens[0].value)
    match = _NUMBER.fullmatch(text)
    if not match or match[2] not in _SECONDS:
        raise ValueError(f"{text!r} is no duration; write it like 30s, 2min or 1h")
    value = float(match[1]) * _SECONDS[match[2]]
    if not value > 0.0:
        raise ValueError(f"{text!r} must be longer than 0 s")
    return value
