"""Error and memory against time, as one picture."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hradiosity.show.labels import label_points
from hradiosity.show.log_ticks import plain_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GROUPS: Final[dict[str, tuple[str, str]]] = {
    "quality": ("#000000", "*"),
    "elements": ("#E69F00", "s"),
    "rays per element": ("#56B4E9", "v"),
    "light points": ("#009E73", "^"),
    "light samples": ("#F0C808", "D"),
    "gather samples": ("#0072B2", "o"),
    "lookup": ("#D55E00", "P"),
    "replicates": ("#CC79A7", "X"),
    "form factors": ("#8C564B", "<"),
    "links": ("#117733", ">"),
    "combined": ("#777777", "h"),
    "classic": ("#7B3294", "p"),
}
"""Colour and mark of each group of settings; colours after Okabe and Ito, told apart by marks as well."""
CHAINS: Final = ("elements", "rays per element", "light points", "light samples", "gather samples", "classic")
"""Groups whose settings lie along a line; those of a knob go through normal."""
NORMAL: Final = "normal"
NAMED: Final = ("quality", "form factors", "links")
"""Groups whose marks have no order that would tell them apart."""
FEW_POINTS: Final = 12
"""Up to so many, all have their names."""
FLOOR, FRONT = "#d9d9d9", "#222222"


@dataclass(frozen=True)
class CostPoint:
    """One setting.

    illuminance, spectrum : relative errors: root mean square, 95th percentile, largest
    illuminance_hidden, spectrum_hidden : they can't be told from the noise of the reference
    efforts : by group, what grows along its line
    """

    name: str
    group: str
    seconds: float
    memory_bytes: int | None
    illuminance: tuple[float, float, float]
    spectrum: tuple[float, float, float]
    illuminance_hidden: bool
    spectrum_hidden: bool
    on_front: bool
    on_spectral_front: bool
    efforts: Mapping[str, float]


@dataclass(frozen=True)
class BandsPoint:
    """One number of bands; the rest are changes against the most bands.

    illuminance, melanopic : of the means, relative
    chromaticity, cct, ra : root mean square; NaN where no reading has such a number
    """

    bands: int
    seconds: float
    illuminance: float
    chromaticity: float
    cct: float
    ra: float
    melanopic: float


@dataclass(frozen=True)
class CostPicture:
    """What is drawn.

    noise, spectral_noise : of the reference, relative
    """

    title: str
    points: Sequence[CostPoint]
    noise: float
    spectral_noise: float
    bands: Sequence[BandsPoint]


def draw_costs(picture: CostPicture) -> bytes:
    """PNG: errors of illuminance and of spectra above, memory and numbers of bands below, all against CPU seconds."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 9.6), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 2, height_ratios=(2.0, 1.0))
    lux = figure.add_subplot(grid[0, 0])
    spectrum = figure.add_subplot(grid[0, 1], sharex=lux, sharey=lux)
    has_bands = len(picture.bands) > 1
    memory = figure.add_subplot(grid[1, 0] if has_bands else grid[1, :], sharex=lux)
    points = picture.points
    _errors(lux, points, picture.noise, "illuminance", "illuminance_hidden", "on_front")
    _errors(spectrum, points, picture.spectral_noise, "spectrum", "spectrum_hidden", "on_spectral_front")
    lux.set_ylim(*_limits(picture))
    plain_ticks(lux, both=True)
    plain_ticks(spectrum, both=True)
    lux.set(ylabel="error of the readings, %", title="illuminance")
    spectrum.set(title="spectrum (readings and bands)")
    _memory(memory, points)
    if has_bands:
        _bands(figure.add_subplot(grid[1, 1]), picture.bands)
    _legend(figure, points)
    figure.suptitle(f"What accuracy costs: {picture.title}", fontsize=14)
    canvas.draw()  # type: ignore[no-untyped-call]
    renderer = canvas.get_renderer()  # type: ignore[no-untyped-call]
    for axes, front in ((lux, "on_front"), (spectrum, "on_spectral_front")):
        name = "illuminance" if axes is lux else "spectrum"
        places = [(p.seconds, 100.0 * getattr(p, name)[0]) for p in points]
        named = [getattr(p, front) or p.group in NAMED or len(points) <= FEW_POINTS for p in points]
        texts = [(*place, p.name) for place, p, told in zip(places, points, named) if told]
        line = sorted(place for place, p in zip(places, points) if getattr(p, front))
        label_points(axes, texts, [*places, *_along(line)], renderer)
    out = io.BytesIO()
    figure.savefig(out, dpi=110, format="png", metadata={"Software": None})
    return out.getvalue()


def _errors(axes: Axes, points: Sequence[CostPoint], noise: float, name: str, hidden: str, front: str) -> None:
    """Errors against time: marks at the rms, whiskers to the 95th percentile, ticks at the largest."""
    for point in points:
        colour, mark = GROUPS[point.group]
        rms, p95, largest = (100.0 * value for value in getattr(point, name))
        is_hidden = getattr(point, hidden)
        faint: dict[str, Any] = {"color": colour, "alpha": 0.28, "zorder": 1}
        axes.plot([point.seconds] * 2, [rms, p95], linewidth=1.0, **faint)
        axes.plot(point.seconds, largest, marker="_", markersize=5, linestyle="", **faint)
        axes.plot(
            point.seconds,
            rms,
            marker=mark,
            markersize=13 if mark == "*" else 7,
            markerfacecolor="white" if is_hidden else colour,
            markeredgecolor=colour if is_hidden else "white",
            markeredgewidth=1.2 if is_hidden else 0.5,
            linestyle="",
            zorder=4,
        )
    _chains(axes, points, name)
    on_front = sorted((p for p in points if getattr(p, front)), key=lambda p: p.seconds)
    axes.plot(
        [p.seconds for p in on_front],
        [100.0 * getattr(p, name)[0] for p in on_front],
        color=FRONT,
        linewidth=2.2,
        alpha=0.75,
        zorder=3,
    )
    axes.set(xscale="log", yscale="log")
    if noise > 0.0:
        axes.axhspan(1e-9, 100.0 * noise, color=FLOOR, alpha=0.7, zorder=0, linewidth=0)
        axes.axhline(100.0 * noise, color="#888888", linewidth=1.0, linestyle="--", zorder=1)
        axes.annotate(
            f"noise of the referee, {100.0 * noise:.2g} %",
            (0.01, 100.0 * noise),
            xycoords=("axes fraction", "data"),
            xytext=(3, -3),
            textcoords="offset points",
            va="top",
            fontsize=8.5,
            color="#444444",
        )


def _limits(picture: CostPicture) -> tuple[float, float]:
    """Of the errors in percent, both panels together."""
    every = [value for point in picture.points for value in (*point.illuminance, *point.spectrum) if value > 0.0]
    noises = [value for value in (picture.noise, picture.spectral_noise) if value > 0.0]
    return 100.0 * min([*every, *noises, 1.0]) / 1.8, 100.0 * max([*every, *noises, 1e-3]) * 1.3


def _chains(axes: Axes, points: Sequence[CostPoint], name: str) -> None:
    """Thin lines along each knob, through normal."""
    usual = [p for p in points if p.name == NORMAL]
    for group in CHAINS:
        members = [p for p in points if p.group == group]
        if not members:
            continue
        along = members + (usual if group != "classic" else [])
        chain = sorted(along, key=lambda p: p.efforts[group])
        axes.plot(
            [p.seconds for p in chain],
            [100.0 * getattr(p, name)[0] for p in chain],
            color=GROUPS[group][0],
            linewidth=1.0,
            alpha=0.8,
            zorder=2,
        )


def _along(line: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points on the straight lines, in log-log, between those of a front."""
    steps = [k / 10 for k in range(1, 10)]
    return [(x0 ** (1 - t) * x1**t, y0 ** (1 - t) * y1**t) for (x0, y0), (x1, y1) in pairwise(line) for t in steps]


def _memory(axes: Axes, points: Sequence[CostPoint]) -> None:
    """Memory that each run adds."""
    for point in points:
        if point.memory_bytes is None:
            continue
        colour, mark = GROUPS[point.group]
        axes.plot(
            point.seconds,
            point.memory_bytes / 2**20,
            marker=mark,
            markersize=11 if mark == "*" else 6.5,
            color=colour,
            markeredgecolor="white",
            markeredgewidth=0.5,
            linestyle="",
        )
    axes.set(
        xscale="log", yscale="log", xlabel="CPU seconds of a run", ylabel="MiB", title="peak memory that a run adds"
    )
    if not any(point.memory_bytes for point in points):
        axes.text(0.5, 0.5, "not measured on this system", transform=axes.transAxes, ha="center")
    plain_ticks(axes, both=True)


def _bands(axes: Axes, bands: Sequence[BandsPoint]) -> None:
    """Change by fewer bands; seconds of each number beside its mark."""
    others = bands[:-1]
    count = [b.bands for b in others]
    lines = (
        ("mean illuminance, %", [100.0 * b.illuminance for b in others], "o-", "#0072B2"),
        ("x, y in thousandths", [1000.0 * b.chromaticity for b in others], "s--", "#D55E00"),
        ("CCT in 10 K", [0.1 * b.cct for b in others], "^-.", "#E69F00"),
        ("Ra", [b.ra for b in others], "D:", "#CC79A7"),
        ("mean melanopic EDI, %", [100.0 * b.melanopic for b in others], "v-", "#009E73"),
    )
    for label, values, style, colour in lines:
        if any(math.isfinite(value) for value in values):
            axes.plot(count, [max(value, 1e-4) for value in values], style, color=colour, label=label)
    axes.set(xscale="log", yscale="log", xlabel="bands (CPU seconds of a draft below)")
    axes.set_title(f"change against {bands[-1].bands} bands ({bands[-1].seconds:.2g} s)")
    from matplotlib.ticker import FixedLocator, NullLocator

    axes.xaxis.set_major_locator(FixedLocator(count))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([f"{b.bands}\n{b.seconds:.2g} s" for b in others])
    axes.margins(x=0.12)
    plain_ticks(axes, both=False)
    axes.legend(fontsize=9, frameon=False)


def _legend(figure: Figure, points: Sequence[CostPoint]) -> None:
    """Marks of the groups that were run, and what the lines are."""
    from matplotlib.lines import Line2D

    there = {point.group for point in points}
    handles: list[Any] = [
        Line2D([], [], color=colour, marker=mark, linestyle="", markersize=11 if mark == "*" else 7, label=group)
        for group, (colour, mark) in GROUPS.items()
        if group in there
    ]
    if max(sum(p.on_front for p in points), sum(p.on_spectral_front for p in points)) > 1:
        handles.append(Line2D([], [], color=FRONT, linewidth=2.2, label="Pareto front"))
    handles.append(Line2D([], [], color="#888888", marker="_", label="to the 95th percentile; largest", linewidth=0.0))
    if any(p.illuminance_hidden or p.spectrum_hidden for p in points):
        hollow: dict[str, Any] = {
            "marker": "o",
            "markerfacecolor": "white",
            "markeredgecolor": "#444444",
            "linestyle": "",
        }
        handles.append(Line2D([], [], label="not to be told from the noise", **hollow))
    figure.legend(handles=handles, loc="outside lower center", ncols=7, fontsize=9, frameon=False)
