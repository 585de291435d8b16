"""The picture of `hradiosity check`: an overview with numbers, a list, and a close-up of each finding."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.output_folder import write_file
from hradiosity.model.scene import Scene, View
from hradiosity.show.camera import project
from hradiosity.show.files import png_bytes
from hradiosity.show.findings_view import Pixels, Stage, close_view, draw, frame_lines, is_in_sight, overview
from hradiosity.space.bvh import Bvh
from hradiosity.space.check import Finding
from hradiosity.space.lit_sides import LitSides

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CLOSE_UPS: Final = 24
_COLOURS: Final = {"fault": "#c81e1e", "warning": "#d97a00", "info": "#2a6fb5"}
_LINEAR: Final = {"fault": (0.75, 0.02, 0.02), "warning": (0.85, 0.30, 0.01), "info": (0.05, 0.22, 0.65)}
_WIDTH, _MARGIN, _GAP = 1500, 24, 18
_OVERVIEW: Final = (860, 600)
_CLOSE: Final = (472, 330)
_COLUMNS: Final = 3
_DPI: Final = 100
_LINE_HEIGHT, _LETTERS, _LIST_LETTERS = 15, 78, 88
_INK, _PALE = "#222222", "#666666"


@dataclass(frozen=True, eq=False)
class _Card:
    """One finding that gets a close-up: its number in the picture, its words in lines, and what is seen of it."""

    number: int
    finding: Finding
    lines: tuple[tuple[str, str], ...]
    view: View
    frame: NDArray[np.float64]
    pixels: Pixels
    in_sight: bool


def write_findings_picture(path: Path, scene: Scene, bvh: Bvh, lit: LitSides, findings: Sequence[Finding]) -> None:
    """Draw what a check found, as a PNG file.

    The model is grey and lamps are yellow. Sides that no light reaches, such as the outsides of a room, are looked
    through, unless nothing is lit at all. Patches that a finding is about have the colour of its severity.

    Parameters
    ----------
    path : Path
        An earlier file is replaced.
    scene : Scene
        With one patch or more.
    bvh : Bvh
        Of the scene's patches.
    lit : LitSides
    findings : sequence of Finding
        As `check_scene` gives them.

    Raises
    ------
    OutputError
        When the file can't be written.
    """
    shown = lit.lit if lit.lit.any() else np.ones_like(lit.lit)
    stage = Stage(scene, bvh, shown)
    cards = [
        _card(stage, number, finding)
        for number, finding in enumerate(findings, start=1)
        if np.isfinite(finding.place).all() and (finding.severity != "info" or finding.fix)
    ][:MOST_CLOSE_UPS]
    view = overview(stage, *_OVERVIEW)
    write_file(path, _sheet(stage, view, findings, cards))


def _card(stage: Stage, number: int, finding: Finding) -> _Card:
    view = close_view(stage, finding.patches, finding.place, finding.size, *_CLOSE)
    pixels = draw(stage, view, finding.patches, _LINEAR[finding.severity])
    in_sight = is_in_sight(stage, view, finding.place, finding.patches)
    lines = [(line, _INK) for line in textwrap.wrap(finding.message, _LETTERS)]
    lines += [(line, _PALE) for line in textwrap.wrap(finding.effect, _LETTERS)]
    lines += [(line, "#1b7a34") for line in textwrap.wrap(f"→ {finding.fix}" if finding.fix else "", _LETTERS)]
    return _Card(number, finding, tuple(lines), view, frame_lines(stage, view), pixels, in_sight)


def _sheet(stage: Stage, view: View, findings: Sequence[Finding], cards: Sequence[_Card]) -> bytes:
    """The PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = [cards[k : k + _COLUMNS] for k in range(0, len(cards), _COLUMNS)]
    heights = [_CLOSE[1] + 34 + _LINE_HEIGHT * max(len(card.lines) for card in row) for row in rows]
    listed = _listed(findings, {card.number for card in cards})
    top = max(_OVERVIEW[1], 40 + 17 * len(listed))
    total = 2 * _MARGIN + 36 + top + sum(height + _GAP for height in heights)
    figure = Figure(figsize=(_WIDTH / _DPI, total / _DPI), dpi=_DPI, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    page = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    page.set(xlim=(0, _WIDTH), ylim=(total, 0))
    page.axis("off")
    page.text(_MARGIN, _MARGIN + 14, f"{stage.scene.name}: {_counted(findings)}", size=14, weight="bold", color=_INK)
    y = _MARGIN + 36
    _place_overview(figure, page, stage, view, cards, y, total)
    _write_list(page, listed, _MARGIN + _OVERVIEW[0] + _GAP, y)
    y += top + _GAP
    for row, height in zip(rows, heights, strict=True):
        for column, card in enumerate(row):
            _place_card(figure, page, card, _MARGIN + column * (_CLOSE[0] + _GAP), y, total)
        y += height + _GAP
    canvas.draw()  # type: ignore[no-untyped-call]
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]  # type: ignore[no-untyped-call]
    return png_bytes(np.ascontiguousarray(pixels), {"Title": f"{stage.scene.name}: findings"})


def _counted(findings: Sequence[Finding]) -> str:
    """Numbers of faults and warnings, in words."""
    parts = []
    for severity in ("fault", "warning"):
        number = sum(finding.severity == severity for finding in findings)
        if number:
            parts.append(f"{number} {severity}{'s' if number > 1 else ''}")
    return " and ".join(parts) or "no fault, no warning"


def _listed(findings: Sequence[Finding], drawn: set[int]) -> list[tuple[str, str]]:
    """Lines of the list, with their colours; findings without a picture have no number there."""
    lines = []
    for number, finding in enumerate(findings, start=1):
        label = f"{number:>2}  " if number in drawn else "  –  "
        text = f"{label}{finding.kind}: {finding.message}"
        wrapped = textwrap.wrap(text, _LIST_LETTERS, subsequent_indent="      ", max_lines=2, placeholder=" …")
        lines += [(line, _COLOURS[finding.severity]) for line in wrapped]
    return lines


def _write_list(page: Axes, lines: Sequence[tuple[str, str]], x: float, y: float) -> None:
    for severity, step in (("fault", 0), ("warning", 90), ("info", 200)):
        page.plot([x + step + 6], [y + 8], "s", color=_COLOURS[severity], markersize=9)
        page.text(x + step + 18, y + 12, severity if severity != "info" else "worth knowing", size=9, color=_INK)
    page.plot([x + 326], [y + 8], "s", color="#f3e08c", markeredgecolor=_PALE, markersize=9)
    page.text(x + 338, y + 12, "lamp", size=9, color=_INK)
    for row, (text, colour) in enumerate(lines):
        page.text(x, y + 40 + 17 * row, text, size=8, color=colour)


def _picture(figure: Figure, pixels: Pixels, x: float, y: float, total: float) -> Axes:
    """Axes in the pixels of an image whose upper left corner is at x, y of the page."""
    height, width = pixels.shape[:2]
    axes = figure.add_axes((x / _WIDTH, 1.0 - (y + height) / total, width / _WIDTH, height / total))
    axes.imshow(pixels, extent=(0, width, height, 0), interpolation="none", aspect="auto")
    axes.set(xlim=(0, width), ylim=(height, 0), xticks=[], yticks=[])
    for side in axes.spines.values():
        side.set_color("#bbbbbb")
    return axes


def _place_overview(
    figure: Figure, page: Axes, stage: Stage, view: View, cards: Sequence[_Card], y: float, total: float
) -> None:
    marked = sorted({patch for card in cards for patch in card.finding.patches if card.finding.severity != "info"})
    axes = _picture(figure, draw(stage, view, marked, _LINEAR["warning"]), _MARGIN, y, total)
    _dash(axes, frame_lines(stage, view))
    places = project(view, np.array([card.finding.place for card in cards]).reshape(-1, 3))
    for card, place, badge in zip(cards, places, _apart(places), strict=True):
        _badge(axes, card, place, badge)


def _place_card(figure: Figure, page: Axes, card: _Card, x: float, y: float, total: float) -> None:
    axes = _picture(figure, card.pixels, x, y, total)
    _dash(axes, card.frame)
    (place,) = project(card.view, card.finding.place[None])
    if not card.in_sight:
        said = "hidden: it lies behind or inside what is seen here"
        axes.text(6, _CLOSE[1] - 8, said, size=8, color=_INK, backgroundcolor="white")
    _badge(axes, card, place, place + [28.0, -28.0])
    colour, finding = _COLOURS[card.finding.severity], card.finding
    page.text(x, y + _CLOSE[1] + 20, f"{card.number}  {finding.kind}", size=10, weight="bold", color=colour)
    for row, (line, ink) in enumerate(card.lines):
        page.text(x, y + _CLOSE[1] + 38 + _LINE_HEIGHT * row, line, size=8, color=ink)


def _dash(axes: Axes, lines: NDArray[np.float64]) -> None:
    """The edges of the scene's box, which may be those of walls that are looked through."""
    for line in lines:
        axes.plot(*line.T, linewidth=0.8, linestyle=(0, (6, 4)), color="#8d97a5")


def _badge(axes: Axes, card: _Card, place: NDArray[np.float64], badge: NDArray[np.float64]) -> None:
    """A number in a circle, with a line to the place it is about."""
    from matplotlib.patheffects import withStroke

    colour = _COLOURS[card.finding.severity]
    halo = [withStroke(linewidth=4.0, foreground="white")]
    axes.plot(*np.stack([place, badge], axis=1), "-", linewidth=1.4, color=colour, path_effects=halo)
    axes.plot(*place, "o", markersize=5, color=colour, markeredgecolor="white", markeredgewidth=1.5)
    box = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": colour, "linewidth": 1.6}
    axes.text(
        badge[0], badge[1], str(card.number), size=9, weight="bold", ha="center", va="center", bbox=box, color=colour
    )


def _apart(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) where the numbers go: up and to the right of their places, pushed apart where they would overlap."""
    badges = places + [26.0, -26.0]
    for _ in range(60):
        offset = badges[:, None] - badges[None]
        distance = np.linalg.norm(offset, axis=2) + np.eye(len(badges)) * 1e9
        close = distance < 30.0
        if not close.any():
            break
        angle = 2.4 * np.arange(len(badges))
        away = np.where(distance[..., None] > 1e-6, offset / np.maximum(distance, 1e-6)[..., None], 0.0)
        same = np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, None] * (distance <= 1e-6)[..., None]
        badges = badges + 4.0 * ((away + same) * close[..., None]).sum(axis=1)
    return np.clip(badges, 16.0, np.array(_OVERVIEW, dtype=np.float64) - 16.0)
