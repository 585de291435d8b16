"""Charts of our numbers over references, drawn as SVG."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby
from typing import Final

WIDTH: Final = 760.0
LEFT, RIGHT, TOP = 78.0, 14.0, 26.0
VALUES, GAP, DEVIATIONS = 190.0, 16.0, 90.0
"""Heights of the two panels, and what lies between them."""
MOST_LABELS: Final = 32
LONG_LABEL: Final = 3
LOGARITHMIC_ABOVE: Final = 300.0
"""Ratio of the largest to the smallest reference from which on the values are drawn by decades."""
OURS, REFERENCE, FAILED, BAND, INK = "#c8500a", "#2b6cb0", "#b00020", "#e3efe3", "#444"


@dataclass(frozen=True)
class ChartPoint:
    """One point along a curve.

    deviation, half_width, bar : relative; half_width may be None
    curve : neighbours of one curve are joined by a line
    """

    name: str
    value: float
    reference: float
    deviation: float
    half_width: float | None
    bar: float
    curve: str = ""

    @property
    def passed(self) -> bool:
        """Whether the deviation is within the bar."""
        return abs(self.deviation) <= self.bar


@dataclass(frozen=True)
class _Axis:
    """From numbers to heights; logarithmic: by decades."""

    low: float
    high: float
    top: float
    height: float
    logarithmic: bool = False

    def at(self, value: float) -> float:
        low, high, value = (
            (math.log10(max(v, 1e-300)) for v in (self.low, self.high, value))
            if self.logarithmic
            else (self.low, self.high, value)
        )
        share = min(max((value - low) / (high - low), -0.02), 1.02)
        return self.top + self.height * (1.0 - share)

    def ticks(self) -> list[float]:
        if self.logarithmic:
            first, last = math.floor(math.log10(self.low)), math.ceil(math.log10(self.high))
            step = max(1, (last - first) // 5)
            return [10.0**k for k in range(first, last + 1, step) if self.low <= 10.0**k <= self.high]
        return nice_ticks(self.low, self.high)


def nice_ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round numbers between two limits, about `count` of them."""
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * min((s for s in (1.0, 2.0, 5.0, 10.0) if s * power >= raw), default=10.0)
    first = math.ceil(low / step - 1e-9)
    return [step * k for k in range(first, math.floor(high / step + 1e-9) + 1)]


def curve_chart(title: str, axis_label: str, points: Sequence[ChartPoint]) -> str:
    """Ours over the references, and the deviations with the band that passes below.

    Returns
    -------
    str
        An ``<svg>`` element that needs nothing from outside.
    """
    turned = len(points) > MOST_LABELS // 2 or max(len(p.name) for p in points) > LONG_LABEL
    foot = 12.0 + (5.6 * max(len(p.name) for p in points) if turned else 12.0)
    height = TOP + VALUES + GAP + DEVIATIONS + foot
    step = (WIDTH - LEFT - RIGHT) / len(points)
    place = [LEFT + step * (k + 0.5) for k in range(len(points))]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {height:.0f}" role="img" '
        f'font-family="sans-serif" font-size="11" fill="{INK}">',
        f"<title>{escape(title)}</title>",
        *_legend(axis_label),
        *_values(points, place),
        *_deviations(points, place),
        *_names(points, place, TOP + VALUES + GAP + DEVIATIONS + 12.0, turned=turned),
        "</svg>",
    ]
    return "\n".join(parts)


def _legend(axis_label: str) -> list[str]:
    right = WIDTH - RIGHT
    return [
        f'<text x="{LEFT:g}" y="15">{escape(axis_label)}</text>',
        f'<rect x="{right - 290:g}" y="5" width="22" height="12" fill="{BAND}"/>',
        f'<text x="{right - 263:g}" y="15">passes</text>',
        f'<path d="M{right - 190:g} 11h22" stroke="{REFERENCE}" stroke-width="2"/>',
        f'<text x="{right - 163:g}" y="15">reference</text>',
        _dot(right - 88, 11, OURS),
        f'<text x="{right - 78:g}" y="15">ours, 95 %</text>',
    ]


def _values(points: Sequence[ChartPoint], place: Sequence[float]) -> list[str]:
    known = [p.reference for p in points]
    everything = [v for v in (*known, *(p.value for p in points)) if math.isfinite(v)]
    logarithmic = min(known) > 0.0 and max(known) > LOGARITHMIC_ABOVE * min(known)
    low, high = min(everything), max(everything)
    if logarithmic:
        axis = _Axis(10.0 ** math.floor(math.log10(min(known))), max(high, max(known)) * 1.5, TOP, VALUES, True)
    else:
        high = high or 1.0 if low >= 0.0 else high
        low = 0.0 if 0.0 <= low < 0.6 * high else low - 0.08 * ((high - low) or abs(high) or 1.0)
        axis = _Axis(low, high + 0.06 * ((high - low) or abs(high) or 1.0), TOP, VALUES)
    parts = [*_frame(axis, axis.ticks(), plain_number)]
    for _, run in groupby(range(len(points)), key=lambda k: points[k].curve):
        path = "L".join(f"{place[k]:.1f} {axis.at(known[k]):.1f}" for k in run)
        parts.append(f'<path d="M{path}" fill="none" stroke="{REFERENCE}" stroke-width="2" stroke-linejoin="round"/>')
    for x, point in zip(place, points):
        parts.append(
            f'<circle cx="{x:.1f}" cy="{axis.at(point.reference):.1f}" r="4.5" fill="none" stroke="{REFERENCE}"/>'
        )
        if math.isfinite(point.value):
            parts.append(_dot(x, axis.at(point.value), OURS if point.passed else FAILED))
    return parts


def _deviations(points: Sequence[ChartPoint], place: Sequence[float]) -> list[str]:
    most = max((abs(p.deviation) for p in points if math.isfinite(p.deviation)), default=0.0)
    limit = 100.0 * max(1.25 * min(p.bar for p in points), min(1.15 * most, 20.0 * max(p.bar for p in points)))
    if most >= 0.5 * min(p.bar for p in points):
        limit = max(limit, 125.0 * max(p.bar for p in points))
    axis = _Axis(-limit, limit, TOP + VALUES + GAP, DEVIATIONS)
    step = place[1] - place[0] if len(place) > 1 else WIDTH - LEFT - RIGHT
    parts = []
    for bar, run in groupby(range(len(points)), key=lambda k: points[k].bar):
        members = list(run)
        upper, lower = axis.at(min(100.0 * bar, limit)), axis.at(max(-100.0 * bar, -limit))
        size = f'width="{step * len(members):.1f}" height="{lower - upper:.1f}"'
        parts.append(f'<rect x="{place[members[0]] - step / 2:.1f}" y="{upper:.1f}" {size} fill="{BAND}"/>')
    parts += _frame(axis, nice_ticks(-limit, limit, 4), lambda v: f"{v:.12g}")
    parts.append(f'<path d="M{LEFT:g} {axis.at(0):.1f}H{WIDTH - RIGHT:g}" stroke="{REFERENCE}"/>')
    middle = axis.top + axis.height / 2
    parts.append(f'<text transform="translate(14 {middle:.0f}) rotate(-90)" text-anchor="middle">deviation, %</text>')
    for x, point in zip(place, points):
        if not math.isfinite(point.deviation):
            continue
        if point.half_width is not None:
            ends = (axis.at(100.0 * (point.deviation + sign * point.half_width)) for sign in (-1.0, 1.0))
            parts.append('<path d="M{x:.1f} {0:.1f}V{1:.1f}" stroke="{c}"/>'.format(*ends, x=x, c=OURS))
        parts.append(_dot(x, axis.at(100.0 * point.deviation), OURS if point.passed else FAILED))
    return parts


def _frame(axis: _Axis, ticks: Sequence[float], text: Callable[[float], str]) -> list[str]:
    right = WIDTH - RIGHT
    parts = []
    for tick in ticks:
        y = axis.at(tick)
        parts.append(f'<path d="M{LEFT:g} {y:.1f}H{right:g}" stroke="#ddd" stroke-width="0.7"/>')
        parts.append(f'<text x="{LEFT - 6:g}" y="{y + 4:.1f}" text-anchor="end">{text(tick)}</text>')
    size = f'width="{right - LEFT:g}" height="{axis.height:g}"'
    return [*parts, f'<rect x="{LEFT:g}" y="{axis.top:g}" {size} fill="none" stroke="#999"/>']


def _names(points: Sequence[ChartPoint], place: Sequence[float], y: float, *, turned: bool) -> list[str]:
    every = math.ceil(len(points) / MOST_LABELS)
    parts = []
    for k, (x, point) in enumerate(zip(place, points)):
        if k % every:
            continue
        if turned:
            where = f'transform="translate({x + 4:.1f} {y - 4:.1f}) rotate(-90)" text-anchor="end"'
        else:
            where = f'x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle"'
        parts.append(f"<text {where}>{escape(point.name)}</text>")
    return parts


def _dot(x: float, y: float, colour: str) -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{colour}"/>'


def plain_number(value: float) -> str:
    """``0.2``, ``1500``, ``1e-07``."""
    return f"{value:.6g}"
