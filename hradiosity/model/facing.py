"""Objects by name, and those of their sides that face one way."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final

FACINGS: Final = MappingProxyType(
    {
        ":up": (0.0, 0.0, 1.0),
        ":down": (0.0, 0.0, -1.0),
        ":+x": (1.0, 0.0, 0.0),
        ":-x": (-1.0, 0.0, 0.0),
        ":+y": (0.0, 1.0, 0.0),
        ":-y": (0.0, -1.0, 0.0),
    }
)
"""What may stand behind the name of an object, and the direction that sides then face."""


def named_part(objects: Sequence[str], name: str) -> tuple[int, tuple[float, float, float] | None] | None:
    """Number of an object and the direction that its sides are to face, None for all of them.

    Returns None when there is no such object. A name that an object has is that object, whatever it ends with.
    """
    if name in objects:
        return objects.index(name), None
    for ending, direction in FACINGS.items():
        if name.endswith(ending) and name.removesuffix(ending) in objects:
            return objects.index(name.removesuffix(ending)), direction
    return None
