"""Images that lie over the picture: what was picked, legends, help, buttons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.colormap import colours_of
from hradiosity.show.exposure import to_bytes
from hradiosity.show.scale_bar import Scale
from hradiosity.show.window.facts import Facts
from hradiosity.show.window.keys import BUTTONS, KEYS, Button
from hradiosity.show.window.lettering import CHOSEN, FAINT, GROUND, INK, LINE, Rgba, Sheet, text_width
from hradiosity.show.window.spectrum_chart import chart

PANEL_WIDTH: Final = 400
CHART_HEIGHT: Final = 190
_LABEL: Final = 108
_BUTTON_HEIGHT: Final = 24
_BUTTON: Final[Rgba] = (60, 64, 72, 235)
_BUTTON_CHOSEN: Final[Rgba] = (222, 200, 90, 235)


@dataclass(frozen=True)
class Legend:
    """Of colours that stand for numbers: scale, colours if they are not those of pictures, and a note."""

    scale: Scale
    colours: NDArray[np.float64] | None
    note: str


def facts_panel(facts: Facts, curve: int) -> NDArray[np.uint8]:
    """(h, w, 4) what was picked, and the spectrum that is chosen of its curves."""
    room = CHART_HEIGHT if facts.curves else 0
    sheet = Sheet(PANEL_WIDTH, 32 + LINE * len(facts.lines) + room)
    sheet.text(10, 15, facts.title, CHOSEN, size=15)
    if len(facts.curves) > 1:
        sheet.text(PANEL_WIDTH - 10, 15, "t: other spectrum", FAINT, anchor="rm", size=11)
    for number, (label, value) in enumerate(facts.lines):
        y = 30 + LINE * (number + 0.5)
        sheet.text(10, y, label, FAINT)
        sheet.text(_LABEL, y, _fitting(value, PANEL_WIDTH - _LABEL - 8), INK)
    image = sheet.pixels
    if facts.curves:
        drawn = chart(facts.curves[curve % len(facts.curves)], PANEL_WIDTH, CHART_HEIGHT)
        below = image[-CHART_HEIGHT:]
        share = drawn[..., 3:].astype(np.float64) / 255.0
        below[..., :3] = np.rint(share * drawn[..., :3] + (1.0 - share) * below[..., :3]).astype(np.uint8)
        below[..., 3] = np.maximum(below[..., 3], drawn[..., 3])
    return image


def _fitting(text: str, width: int) -> str:
    """The text, cut where it would be too wide."""
    while len(text) > 4 and text_width(text) > width:
        text = text[:-2].rstrip("…") + "…"
    return text


def scale_legend(
    scale: Scale, height: int, colours: NDArray[np.float64] | None = None, note: str = ""
) -> NDArray[np.uint8]:
    """(height, w, 4) colours and round numbers with quantity and unit.

    Parameters
    ----------
    scale : Scale
    height : int
    colours : (n, 3) sRGB from the lowest number to the highest, optional
        Of another map than that of the pictures.
    note : str
        A line below.
    """
    ticks = [f"{value:g}".replace("-", "−") for value in scale.ticks()]
    words = [scale.quantity, f"[{scale.unit}]", note]
    width = max(52 + max((text_width(tick) for tick in ticks), default=0), 20 + max(text_width(w) for w in words))
    sheet = Sheet(width, height)
    for number, word in enumerate(words[:2]):
        sheet.text(10, 6 + LINE * (number + 0.5), word, INK)
    top, bottom = 8 + 2 * LINE + 8, height - 12 - (LINE if note else 0)
    share = np.linspace(1.0, 0.0, bottom - top)
    bar = colours_of(share) if colours is None else colours[np.rint(share * (len(colours) - 1)).astype(np.int64)]
    sheet.paste(10, top, np.repeat(to_bytes(bar)[:, None, :], 20, axis=1))
    for value, tick in zip(scale.ticks(), ticks, strict=True):
        y = top + (1.0 - float(scale.share(np.array(value)))) * (bottom - top - 1)
        sheet.draw.line([(30, y), (35, y)], fill=INK)
        sheet.text(40, y, tick, INK)
    if note:
        sheet.text(10, height - 6 - LINE / 2, note, FAINT)
    return sheet.pixels


def help_panel() -> NDArray[np.uint8]:
    """(h, w, 4) all keys, in two columns."""
    half = -(-len(KEYS) // 2)
    column = max(text_width(key.what) for key in KEYS) + 130
    sheet = Sheet(2 * column + 10, 56 + LINE * half, (20, 22, 26, 240))
    sheet.text(16, 20, "Keys and mouse", CHOSEN, size=16)
    sheet.text(2 * column, 20, "h closes this", FAINT, anchor="rm")
    for number, key in enumerate(KEYS):
        x, y = 16 + column * (number // half), 42 + LINE * (number % half + 0.5)
        sheet.text(x, y, key.shown, CHOSEN)
        sheet.text(x + 106, y, key.what, INK)
    return sheet.pixels


@dataclass(frozen=True)
class Toolbar:
    """Buttons in rows.

    pixels : (h, w, 4)
    places : left, top, right and bottom of each, in pixels
    """

    pixels: NDArray[np.uint8]
    places: tuple[tuple[int, int, int, int], ...]

    def button_at(self, x: float, y: float) -> Button | None:
        """The one at a place, if there is one."""
        for button, (left, top, right, bottom) in zip(BUTTONS, self.places, strict=True):
            if left <= x < right and top <= y < bottom:
                return button
        return None


def toolbar(chosen: frozenset[str], room: int) -> Toolbar:
    """All buttons, those whose commands are `chosen` marked, in as many rows as a width of `room` pixels calls for."""
    places, x, y, widest = [], 2, 2, 0
    for button in BUTTONS:
        width = text_width(button.label, 12) + 16
        if x + width > room and x > 2:
            x, y = 2, y + _BUTTON_HEIGHT + 3
        places.append((x, y, x + width, y + _BUTTON_HEIGHT))
        x += width + 3
        widest = max(widest, x)
    sheet = Sheet(widest, y + _BUTTON_HEIGHT + 2, GROUND)
    for button, (left, top, right, bottom) in zip(BUTTONS, places, strict=True):
        on = button.command in chosen
        fill = _BUTTON_CHOSEN if on else _BUTTON
        sheet.draw.rounded_rectangle([left, top, right - 1, bottom - 1], radius=4, fill=fill)
        middle = (left + right) / 2, (top + bottom) / 2
        sheet.text(*middle, button.label, (20, 20, 20, 255) if on else INK, anchor="mm", size=12)
    return Toolbar(sheet.pixels, tuple(places))


def words_sheet(words: Sequence[tuple[str, Rgba]], room: int) -> NDArray[np.uint8]:
    """(h, w, 4) words with their ink in a row, or in as many as a width of `room` pixels calls for."""
    places, x, y, widest = [], 8, 4 + LINE / 2, 0
    for text, _ in words:
        width = text_width(text)
        if x + width > room and x > 8:
            x, y = 8, y + LINE
        places.append((x, y))
        x += width + 18
        widest = max(widest, x)
    sheet = Sheet(min(widest, room), round(y + LINE / 2) + 4)
    for (text, ink), place in zip(words, places, strict=True):
        sheet.text(*place, text, ink)
    return sheet.pixels
