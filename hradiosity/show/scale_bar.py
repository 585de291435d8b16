"""Numbers as colours, with the scale that says which is which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.colormap import colours_of
from hradiosity.show.exposure import to_bytes

STRIP_WIDTH: Final = 96
"""Pixels that the scale takes beside the picture."""
DECADES: Final = 3
"""Of a logarithmic scale whose ends nobody named, at most."""
TICK_STEPS: Final = (1.0, 2.0, 5.0, 10.0)
TOPS: Final = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""First digits of the ends of a scale: closer together than ticks, so that little of the colours goes unused."""
_NOTHING: Final = 0.25
"""Grey where the view leaves the scene."""
_MARGIN, _BAR, _TICK, _TEXT = 14, 18, 4, 12


@dataclass(frozen=True)
class Scale:
    """Numbers and colours.

    low, high : ends of the scale, in `unit`
    logarithmic : equal ratios are equal steps; `low` is above 0 then
    quantity, unit : what is shown
    """

    low: float
    high: float
    logarithmic: bool
    quantity: str
    unit: str

    def __post_init__(self) -> None:
        lowest = 0.0 if self.logarithmic else -np.inf
        if not (np.isfinite([self.low, self.high]).all() and lowest < self.low < self.high):
            raise ValueError(f"a scale from {self.low} to {self.high} {self.unit} is no scale")

    def record(self) -> dict[str, Any]:
        """The scale in ``pictures.json``."""
        return {name: getattr(self, name) for name in ("quantity", "unit", "low", "high", "logarithmic")}

    def share(self, values: NDArray[np.floating]) -> NDArray[np.float64]:
        """Place of values on the scale, 0 … 1 within it."""
        if not self.logarithmic:
            linear: NDArray[np.float64] = (np.asarray(values, np.float64) - self.low) / (self.high - self.low)
            return linear
        floor = np.maximum(np.asarray(values, np.float64), self.low)
        logs: NDArray[np.float64] = np.log(floor / self.low) / np.log(self.high / self.low)
        return logs

    def ticks(self) -> NDArray[np.float64]:
        """Round numbers on the scale."""
        if self.logarithmic:
            decades = 10.0 ** np.arange(np.floor(np.log10(self.low)), np.ceil(np.log10(self.high)) + 1)
            candidates = (decades[:, None] * np.array([1.0, 2.0, 5.0])).ravel()
        else:
            step = round_up((self.high - self.low) / 8.0)
            candidates = step * np.arange(np.floor(self.low / step), np.ceil(self.high / step) + 1)
        inside = (self.share(candidates) > -1e-9) & (self.share(candidates) < 1.0 + 1e-9)
        ticks: NDArray[np.float64] = candidates[inside & (candidates >= self.low - 1e-9 * abs(self.low))]
        return ticks


def round_up(value: float, numbers: Sequence[float] = TICK_STEPS) -> float:
    """The next of …, 1, 2, 5, 10, 20, … that is no smaller than ``value`` > 0, or of other `numbers` 1 … 10."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(next(decade * m for m in numbers if decade * m >= value * (1.0 - 1e-9)))


def round_down(value: float) -> float:
    """The next number with one of the first digits of `TOPS` that is no larger than ``value`` > 0."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(next(decade * m for m in reversed(TOPS) if decade * m <= value * (1.0 + 1e-9)))


def automatic_scale(values: NDArray[np.floating], *, logarithmic: bool, quantity: str, unit: str) -> Scale:
    """A scale that holds all but the brightest hundredth of the values, from 0.

    A logarithmic one leaves the darkest hundredth out too, and all that is more than three decades below its end.
    """
    dark, bright = (float(q) for q in np.quantile(values, [0.01, 0.99])) if len(values) else (0.0, 0.0)
    high = round_up(bright, TOPS) if bright > 0.0 else 1.0
    lowest = high * 10.0**-DECADES
    low = lowest if dark <= lowest else min(round_down(dark), high / 10.0)
    return Scale(low if logarithmic else 0.0, high, logarithmic, quantity, unit)


def false_colours(values: NDArray[np.float64], seen: NDArray[np.bool_], scale: Scale) -> NDArray[np.uint8]:
    """(height, width, 3) colours of values (height, width); grey where nothing is seen."""
    colours = np.where(seen[..., None], colours_of(scale.share(values)), _NOTHING)
    return to_bytes(colours)


def with_scale_bar(pixels: NDArray[np.uint8], scale: Scale) -> NDArray[np.uint8]:
    """The picture with a strip on its right: the scale's colours, round numbers, quantity and unit."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = pixels.shape[:2]
    canvas = np.zeros((height, width + STRIP_WIDTH, 3), np.uint8)
    canvas[:, :width] = pixels
    top, bottom = min(3 * _MARGIN, height // 3), height - min(_MARGIN, height // 6)
    rows = np.linspace(1.0, 0.0, bottom - top)
    left = width + _MARGIN
    canvas[top:bottom, left : left + _BAR] = to_bytes(colours_of(rows))[:, None, :]
    image = Image.fromarray(canvas)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(_TEXT)
    draw.text((left, 4), scale.quantity, fill="white", font=font)
    draw.text((left, 4 + _TEXT + 3), f"[{scale.unit}]", fill="white", font=font)
    for value in scale.ticks():
        y = top + (1.0 - float(scale.share(np.array(value)))) * (bottom - top - 1)
        draw.line([(left + _BAR, y), (left + _BAR + _TICK, y)], fill="white")
        draw.text((left + _BAR + _TICK + 4, y), f"{value:g}", fill="white", font=font, anchor="lm")
    return np.asarray(image)
