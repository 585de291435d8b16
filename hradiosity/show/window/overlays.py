"""What lies over the picture: buttons, legend, what was picked, help, and a line that says what is shown."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.window.keys import Button
from hradiosity.show.window.lettering import CHOSEN, FAINT, INK, Rgba
from hradiosity.show.window.look import AXES, NO_LINES, Look
from hradiosity.show.window.panels import facts_panel, help_panel, scale_legend, toolbar, words_sheet
from hradiosity.show.window.stage import ORANGE, PURPLE, SKY_BLUE, ImageActor

if TYPE_CHECKING:
    from hradiosity.show.window.viewer import Viewer

_GAP: Final = 8
_LEGEND_HEIGHT: Final = 330
Words = tuple[tuple[str, Rgba], ...]


class Overlays:
    """Images in a layer of their own, made anew where they changed.

    Parameters
    ----------
    window : vtkRenderWindow

    Attributes
    ----------
    places : dict
        Left, top, right and bottom of each image that is shown, by name [pixels].
    """

    def __init__(self, window: Any) -> None:
        from vtkmodules.vtkRenderingCore import vtkRenderer

        layer = vtkRenderer()
        layer.SetLayer(1)
        layer.InteractiveOff()
        window.SetNumberOfLayers(2)
        window.AddRenderer(layer)
        self._actors = {name: ImageActor(layer) for name in ("buttons", "legend", "facts", "status", "help")}
        self._shown: dict[str, Hashable] = {}
        self._sizes: dict[str, tuple[int, int]] = {}
        self.places: dict[str, tuple[int, int, int, int]] = {}
        self._bar = toolbar(frozenset(), 1000)

    def button_at(self, x: float, y: float) -> Button | None:
        """The button at a place, in pixels from the upper left corner."""
        return self._bar.button_at(x - _GAP, y - _GAP)

    def update(self, viewer: Viewer) -> None:
        """Show what the viewer's state calls for."""
        width, height = viewer.size
        chosen = chosen_commands(viewer)
        if self._shown.get("buttons") != (chosen, width, height):
            self._bar = toolbar(chosen, width - 2 * _GAP)
        self._put("buttons", (chosen, width, height), lambda: self._bar.pixels, lambda _: (_GAP, _GAP), height)
        below = self._bar.pixels.shape[0] + 2 * _GAP
        if viewer.legend is None:
            self._hide("legend")
        else:
            scale, note, colours = viewer.legend.scale, viewer.legend.note, viewer.legend.colours
            room = min(_LEGEND_HEIGHT, height - 100)
            self._put(
                "legend",
                (scale, note, width, height, below),
                lambda: scale_legend(scale, room, colours, note),
                lambda legend: (width - legend.shape[1] - _GAP, below),
                height,
            )
        words = status_words(viewer)
        self._put(
            "status",
            (words, width, height),
            lambda: words_sheet(words, width - 2 * _GAP),
            lambda status: (_GAP, height - status.shape[0] - _GAP),
            height,
        )
        facts, rise = viewer.facts(), self._sizes["status"][0]
        beside = 0 if viewer.legend is None else self._sizes["legend"][1] + _GAP
        if facts is None:
            self._hide("facts")
        else:
            self._put(
                "facts",
                (facts.title, facts.lines, viewer.curve, viewer.facts_right, beside, below, width, height, rise),
                lambda: facts_panel(facts, viewer.curve),
                lambda panel: (
                    width - panel.shape[1] - beside - _GAP if viewer.facts_right else _GAP,
                    max(height - rise - panel.shape[0] - 2 * _GAP, below),
                ),
                height,
            )
        if viewer.help_shown:
            self._put(
                "help",
                (width, height),
                help_panel,
                lambda page: ((width - page.shape[1]) // 2, (height - page.shape[0]) // 2),
                height,
            )
        else:
            self._hide("help")

    def _hide(self, name: str) -> None:
        self._shown.pop(name, None)
        self.places.pop(name, None)
        self._actors[name].hide()

    def _put(
        self,
        name: str,
        key: Hashable,
        make: Callable[[], NDArray[np.uint8]],
        place: Callable[[NDArray[np.uint8]], tuple[int, int]],
        height: int,
    ) -> None:
        """Show an image at its place in a window of that height, unless it is there already by its key."""
        if self._shown.get(name) != key:
            self._shown[name] = key
            pixels = make()
            self._sizes[name] = pixels.shape[0], pixels.shape[1]
            left, top = place(pixels)
            self.places[name] = left, top, left + pixels.shape[1], top + pixels.shape[0]
            self._actors[name].show(pixels, left, top, height)


def chosen_commands(viewer: Viewer) -> frozenset[str]:
    """Commands whose buttons are marked."""
    look = viewer.look
    states = {
        "logarithmic": look.logarithmic,
        "quantity": look.quantity == "luminance",
        "coarser lines": look.lines != NO_LINES,
        "section": look.section is not None,
        "gamut": look.gamut,
        "marks": look.marks,
        "backs": look.backs,
        "walk": viewer.walking,
        "compare": viewer.shows_difference,
        "help": viewer.help_shown,
    }
    mode = set() if viewer.shows_difference else {look.mode}
    return frozenset({*mode, *(name for name, on in states.items() if on)})


def status_words(viewer: Viewer) -> Words:
    """What is shown, in words with their ink."""
    look, subject = viewer.look, viewer.subject
    names = f"{viewer.names[-1]} − {viewer.names[0]}" if viewer.shows_difference else " | ".join(viewer.names)
    words: list[tuple[str, Rgba]] = [(names, CHOSEN)]
    if viewer.running:
        words.append((viewer.running, INK))
    elif subject.values is None:
        words.append(("not solved yet: paints", INK))
    words += [
        (text, INK)
        for text in (
            _difference_words(viewer),
            _exposure_words(viewer),
            _lines_words(look, subject.values is not None),
            _section_words(viewer),
        )
        if text
    ]
    if look.gamut and subject.values is not None:
        area = subject.cells.area
        share = float(area[subject.out_of_gamut()].sum() / max(float(area.sum()), 1e-300))
        words.append((f"magenta: outside sRGB, {100.0 * share:.2g} % of the area", (255, 110, 255, 255)))
    if look.marks:
        words += [("sensors", _ink(SKY_BLUE)), ("lamps", _ink(ORANGE)), ("cameras", _ink(PURPLE))]
    words.append(("on foot" if viewer.walking else "orbit", FAINT))
    words.append((viewer.message or "h: help", CHOSEN if viewer.message else FAINT))
    return tuple(words)


def _difference_words(viewer: Viewer) -> str:
    summary, comparison = viewer.summary, viewer.compare() if viewer.shows_difference else None
    if summary is None or comparison is None:
        return ""
    lost = comparison.lost_share
    grey = f"; grey: in one of them only, {100.0 * lost:.2g} % of the area" if lost > 0.0 else ""
    if summary.equal:
        return f"both are equal: no difference anywhere{grey}"
    unit = "lx" if viewer.look.quantity == "illuminance" else "cd/m²"
    percent = f" ({100.0 * summary.rms / summary.level:.2g} %)" if summary.level > 0.0 else ""
    words = f"mean {summary.mean:+.3g}, rms {summary.rms:.3g} {unit}{percent} by area".replace("-", "−")
    return f"{words}{grey}"


def _exposure_words(viewer: Viewer) -> str:
    look, subject = viewer.look, viewer.subject
    if viewer.legend is not None:
        return ""
    if look.mode == "unshaded":
        return "unshaded: white is reflectance 1 under D65"
    if subject.values is None:
        return ""
    adapted = ", adapted to the lamps" if "CAT16" in subject.white.words else ""
    return f"{look.mode}: white is {subject.luminance(look):.4g} cd/m²{adapted}"


def _lines_words(look: Look, solved: bool) -> str:
    if look.lines == NO_LINES:
        return ""
    if look.lines > 0:
        return f"lines: blocks of {1 << look.lines} × {1 << look.lines} cells"
    return "lines: elements" if solved else "lines: patches"


def _section_words(viewer: Viewer) -> str:
    section, cells = viewer.look.section, viewer.subject.cells
    if section is None or not len(cells):
        return ""
    low, high = (float(corner[section.axis]) for corner in cells.bounds)
    kept = ">" if section.flipped else "<"
    return f"section {AXES[section.axis]} {kept} {low + section.share * (high - low):.2f} m"


def _ink(colour: tuple[float, float, float]) -> Rgba:
    red, green, blue = (round(255.0 * c) for c in colour)
    return red, green, blue, 255
