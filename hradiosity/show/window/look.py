"""What the window shows and how: one value that keys, buttons and the command line change."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal

Mode = Literal["flat", "smooth", "wireframe", "unshaded", "false-color"]
MODES: Final[tuple[Mode, ...]] = ("flat", "smooth", "wireframe", "unshaded", "false-color")
Quantity = Literal["illuminance", "luminance"]
Compare = Literal["side by side", "difference"]
NO_LINES: Final = -1
"""No outlines; 0 stands for those of elements, k for those of 2ᵏ × 2ᵏ cells, up to whole patches."""
AXES: Final = "xyz"


@dataclass(frozen=True)
class Section:
    """A plane that hides what lies on one side of it.

    axis : 0, 1 or 2
    share : 0 … 1 of the way through the scene
    flipped : hide what lies below the plane, and not above
    """

    axis: int = 2
    share: float = 0.8
    flipped: bool = False

    def moved(self, step: float) -> Section:
        """Further through the scene."""
        return replace(self, share=min(max(self.share + step, 0.0), 1.0))


@dataclass(frozen=True)
class Look:
    """How things are shown.

    lines : outlines of elements and coarser levels, NO_LINES for none
    section : None for none
    gamut : mark colours that no sRGB display can show
    marks : sensors, aims of lamps and cameras
    backs : paint faces that look away in grey; else one looks through them
    quantity, logarithmic : of the false colours
    stops : exposure beside the fixed one, in factors of two
    compare : how two results are shown
    """

    mode: Mode = "flat"
    lines: int = NO_LINES
    section: Section | None = None
    gamut: bool = False
    marks: bool = True
    backs: bool = False
    quantity: Quantity = "illuminance"
    logarithmic: bool = False
    stops: float = 0.0
    compare: Compare = "side by side"

    def next_section(self) -> Look:
        """From none over x, y and z to none."""
        if self.section is None:
            return replace(self, section=Section(axis=0))
        return replace(self, section=None if self.section.axis == 2 else Section(axis=self.section.axis + 1))

    def next_lines(self, step: int, n_levels: int) -> Look:
        """Coarser or finer outlines, between none and those of whole patches."""
        return replace(self, lines=min(max(self.lines + step, NO_LINES), n_levels))
