"""Measured numbers against each other as lines on logarithmic axes, drawn as SVG."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hradiosity.show.log_ticks import plain_ticks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES: Final = (
    ("#0072B2", "o"),
    ("#D55E00", "s"),
    ("#009E73", "^"),
    ("#CC79A7", "D"),
    ("#E69F00", "v"),
    ("#000", "x"),
)
"""Colours after Okabe and Ito, told apart by marks as well."""


@dataclass(frozen=True)
class Line:
    """One series; `guide` draws it thin, without marks."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    guide: bool = False


@dataclass(frozen=True)
class Panel:
    """Lines on common axes; `levels` are horizontal lines with a name."""

    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    levels: Sequence[tuple[str, float]] = ()


def draw_lines(panels: Sequence[Panel], title: str) -> str:
    """An ``<svg>`` document, panels beside each other; the same numbers give the same text."""
    import matplotlib

    figure = line_figure(panels, title)
    out = io.StringIO()
    fixed: dict[Any, Any] = {"svg.hashsalt": "hradiosity", "svg.fonttype": "path"}
    with matplotlib.rc_context(fixed):
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    return out.getvalue()


def line_figure(panels: Sequence[Panel], title: str) -> Figure:
    """The same as a figure of matplotlib."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.2 * len(panels), 5.2), layout="constrained")
    for number, panel in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), number + 1)
        marked = 0
        for line in panel.lines:
            if line.guide:
                axes.plot(line.x, line.y, color="#888888", linewidth=1.0, linestyle="--", label=line.name, zorder=1)
                continue
            colour, mark = STYLES[marked % len(STYLES)]
            marked += 1
            axes.plot(line.x, line.y, color=colour, marker=mark, markersize=5.5, linewidth=1.6, label=line.name)
        for name, value in panel.levels:
            axes.axhline(value, color="#888888", linewidth=0.9, linestyle=":")
            axes.annotate(name, (0.01, value), xycoords=("axes fraction", "data"), xytext=(2, 2),
                          textcoords="offset points", fontsize=8, color="#444444")  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel=panel.x_label, ylabel=panel.y_label, title=panel.title)
        axes.grid(visible=True, which="major", color="#dddddd", linewidth=0.6)
        plain_ticks(axes, both=True)
        axes.legend(fontsize=8.5, frameon=False)
    figure.suptitle(title)
    return figure
