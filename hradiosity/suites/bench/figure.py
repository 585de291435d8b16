"""One measured number, and what its unit says about better and worse."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

CPU: Final = "CPU s"
WALL: Final = "wall s"
MICROSECONDS: Final = "CPU µs"
SPEED: Final = "Mray/CPU-s"
RATIO: Final = "× peer"
ERROR: Final = "relative error"
PRODUCTS: Final = "products"

WORDS: Final = {
    CPU: ("faster", "slower"),
    WALL: ("faster", "slower"),
    MICROSECONDS: ("faster", "slower"),
    SPEED: ("slower", "faster"),
    RATIO: ("slower", "faster"),
    ERROR: ("more accurate", "less accurate"),
    PRODUCTS: ("faster", "slower"),
}
"""What to say of a later figure in each unit, when it is smaller and when it is larger than an earlier one."""


@dataclass(frozen=True)
class Figure:
    """A number with its unit and its spread.

    name : ``section: what``, the same in each run
    value : median of the repeats
    unit : one of `WORDS`
    spread : half the range of the repeats, in the same unit; 0 where repeats can't differ, None if there was only one
    """

    name: str
    value: float
    unit: str
    spread: float | None

    def __post_init__(self) -> None:
        if self.unit not in WORDS:
            raise ValueError(f"unit must be one of {', '.join(WORDS)}, is {self.unit!r}")
        if not math.isfinite(self.value):
            raise ValueError(f"{self.name}: the value must be finite, is {self.value}")
        if self.spread is not None and not (math.isfinite(self.spread) and self.spread >= 0.0):
            raise ValueError(f"{self.name}: the spread must be finite and not negative, is {self.spread}")


def figure_of(name: str, repeats: Sequence[float], unit: str) -> Figure:
    """Median and half range of what was measured again and again."""
    spread = 0.5 * (max(repeats) - min(repeats)) if len(repeats) > 1 else None
    return Figure(name, float(statistics.median(repeats)), unit, spread)


def exact_figure(name: str, value: float, unit: str) -> Figure:
    """What comes out the same each time."""
    return Figure(name, float(value), unit, 0.0)
