"""Keys, buttons and the commands they give; README and the help panel tell the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Key:
    """symbols : as the window system names them; shown : in the help; command; what : it does."""

    symbols: tuple[str, ...]
    shown: str
    command: str
    what: str


@dataclass(frozen=True)
class Button:
    """label, and the command it gives."""

    label: str
    command: str


KEYS: Final = (
    Key(("1",), "1", "flat", "flat: one colour for each element"),
    Key(("2",), "2", "smooth", "smooth: colours between elements"),
    Key(("3",), "3", "wireframe", "wireframe over dimmed light"),
    Key(("4",), "4", "unshaded", "unshaded: paints in daylight"),
    Key(("5",), "5", "false-color", "false colours"),
    Key(("i",), "i", "quantity", "illuminance or luminance"),
    Key(("k",), "k", "logarithmic", "linear or logarithmic scale"),
    Key(("plus", "equal", "KP_Add"), "+", "brighter", "brighter: white, or end of scale, lower"),
    Key(("minus", "KP_Subtract"), "−", "darker", "darker"),
    Key(("0",), "0", "exposure", "exposure and scale as at the start"),
    Key(("l",), "l", "coarser lines", "outlines: elements, then coarser levels"),
    Key(("L",), "L", "finer lines", "outlines: finer, then none"),
    Key(("x",), "x", "section", "section across x, y, z, none"),
    Key(("comma",), ",", "section back", "move the section back"),
    Key(("period",), ".", "section ahead", "move the section ahead"),
    Key(("slash",), "/", "section flip", "hide the other side"),
    Key(("b",), "b", "backs", "faces that look away: seen through, or grey"),
    Key(("m",), "m", "marks", "sensors, aims of lamps, cameras"),
    Key(("g",), "g", "gamut", "mark colours that no display can show"),
    Key(("c",), "c", "next view", "next camera of the scene"),
    Key(("r",), "r", "overview", "all of the scene from outside"),
    Key(("f",), "f", "walk", "walk, or orbit"),
    Key(("w", "Up"), "w, ↑", "ahead", "step ahead; orbit: look from higher up"),
    Key(("s", "Down"), "s, ↓", "back", "step back; orbit: from lower down"),
    Key(("a", "Left"), "a, ←", "left", "step left; orbit: from the left"),
    Key(("d", "Right"), "d, →", "right", "step right; orbit: from the right"),
    Key(("e", "Prior"), "e, Page ↑", "up", "rise; orbit: nearer"),
    Key(("q", "Next"), "q, Page ↓", "down", "sink; orbit: farther"),
    Key(("t",), "t", "curve", "other spectrum of what was picked"),
    Key(("v",), "v", "compare", "two results: side by side, or difference"),
    Key(("p",), "p", "screenshot", "write a screenshot"),
    Key(("o",), "o", "page", "write an HTML page"),
    Key(("h", "F1", "question"), "h", "help", "this help"),
    Key(("Escape",), "Esc", "close", "close help or what was picked; then the window"),
    Key((), "click", "", "pick a patch or a sensor"),
    Key((), "drag", "", "turn; with shift or the middle button, move"),
    Key((), "wheel", "", "nearer, farther"),
)
BUTTONS: Final = (
    Button("Flat", "flat"),
    Button("Smooth", "smooth"),
    Button("Wireframe", "wireframe"),
    Button("Unshaded", "unshaded"),
    Button("False colours", "false-color"),
    Button("lx | cd/m²", "quantity"),
    Button("Log", "logarithmic"),
    Button("−", "darker"),
    Button("+", "brighter"),
    Button("Lines", "coarser lines"),
    Button("Section", "section"),
    Button("Gamut", "gamut"),
    Button("Marks", "marks"),
    Button("Backs", "backs"),
    Button("Walk", "walk"),
    Button("Camera", "next view"),
    Button("All", "overview"),
    Button("Compare", "compare"),
    Button("Shot", "screenshot"),
    Button("HTML", "page"),
    Button("Help", "help"),
)


def command_of(symbol: str) -> str | None:
    """The command that a key gives."""
    for key in KEYS:
        if symbol in key.symbols:
            return key.command
    return None
