"""What is looked at, and its colours for each look: a scene, a result, or two."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Drawn, Light
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.show.scale_bar import Scale
from hradiosity.show.white import WHITES, White, WhiteName, white_of_light
from hradiosity.show.window.colours import (
    LightValues,
    chosen_scale,
    chosen_white,
    gamut_marks,
    light_colours,
    luminous_reflectances,
    paint_bytes,
    scale_colours,
    unsolved_colours,
)
from hradiosity.show.window.look import Look, Quantity

GAMUT_MARK: Final = np.array([255, 0, 255], np.uint8)


@dataclass(frozen=True)
class Choices:
    """What the command line chose; None is left to the result.

    white_luminance : shown as white [cd m⁻²]
    white : name of what is shown as white
    scale_range : ends of the false colours
    """

    white_luminance: float | None = None
    white: WhiteName | None = None
    scale_range: tuple[float, float] | None = None


@dataclass(frozen=True)
class Paint:
    """Colours of cells (n, 3), or of their corners (n, 4, 3), uint8."""

    colours: NDArray[np.uint8]

    @property
    def at_corners(self) -> bool:
        """Whether they are those of corners."""
        return self.colours.ndim == 3


class Subject:
    """A scene or a result.

    Parameters
    ----------
    drawn : Drawn
    choices : Choices
    like : Subject, optional
        Whose exposure and scales are taken, so that two results can be compared.
    """

    def __init__(self, drawn: Drawn, choices: Choices, like: Subject | None = None) -> None:
        self.drawn, self.choices, self._like = drawn, choices, like
        self.values = None if drawn.light is None else LightValues(drawn, drawn.light)
        name: WhiteName = "lamps" if drawn.exposure.white == WHITES[1] else "as-measured"
        light = np.einsum("b,bc->c", drawn.lamps.flux, xyz_weights(drawn.words.bands))
        self.white: White = white_of_light(light, choices.white or name)
        self._luminance = choices.white_luminance or drawn.exposure.white_luminance
        self._scales: dict[tuple[Quantity, bool], Scale] = {}

    @property
    def cells(self) -> Cells:
        """What is drawn."""
        return self.drawn.cells

    def take_light(self, light: Light) -> None:
        """Show other light on the same cells; exposure and scales stay once they are chosen."""
        vertex = None if self.values is None else self.values.vertex
        self.drawn = replace(self.drawn, light=light)
        self.values = LightValues(self.drawn, light, vertex)

    def luminance(self, look: Look) -> float:
        """Shown as white [cd m⁻²]."""
        if self._like is not None:
            return self._like.luminance(look)
        if self._luminance is None:
            if self.values is None:
                return 1.0
            self._luminance = chosen_white(self.values, self.white, self.cells.area)
        return float(self._luminance * 2.0**-look.stops)

    def scale(self, look: Look) -> Scale:
        """Of the false colours."""
        if self._like is not None:
            return self._like.scale(look)
        if self.values is None:
            return Scale(0.0, 1.0, False, "reflectance, D65", "1")
        key = look.quantity, look.logarithmic
        if key not in self._scales:
            self._scales[key] = self._choose_scale(self.values, look)
        scale = self._scales[key]
        high = scale.high * 2.0**-look.stops
        return replace(scale, high=high, low=scale.low if scale.low < high else 0.1 * high)

    def _choose_scale(self, values: LightValues, look: Look) -> Scale:
        scale = chosen_scale(values, look.quantity, look.logarithmic)
        chosen = self.drawn.exposure
        if self.choices.scale_range is not None:
            low, high = self.choices.scale_range
            low = 1e-3 * high if look.logarithmic and low <= 0.0 else low
            return replace(scale, low=low, high=high)
        if chosen.high is not None and (chosen.quantity, chosen.logarithmic) == (look.quantity, look.logarithmic):
            return replace(scale, low=chosen.low, high=chosen.high)
        return scale

    def out_of_gamut(self) -> NDArray[np.bool_]:
        """(n,) bool, cells whose colour no sRGB display can show."""
        if self.values is None:
            return np.zeros(len(self.cells), np.bool_)
        return gamut_marks(self.values, self.white)

    def colours_on_scale(self, values: NDArray[np.float64], look: Look) -> NDArray[np.uint8]:
        """(n, 3) false colours of numbers."""
        return scale_colours(values, self.scale(look))

    def paint(self, look: Look) -> Paint:
        """Colours for a look."""
        colours = self._colours(look)
        if look.gamut and self.values is not None:
            colours = colours.copy()
            colours[self.out_of_gamut()] = GAMUT_MARK
        return Paint(colours)

    def _colours(self, look: Look) -> NDArray[np.uint8]:
        values = self.values
        if look.mode == "unshaded":
            return paint_bytes(self.drawn)
        if values is None:
            if look.mode == "false-color":
                return scale_colours(luminous_reflectances(self.drawn), self.scale(look))
            return unsolved_colours(self.drawn)
        if look.mode == "false-color":
            return scale_colours(values.smooth.of(look.quantity), self.scale(look))
        dimmed = look.mode == "wireframe"
        shown = values.flat if look.mode == "flat" else values.smooth
        return light_colours(shown.xyz, self.white, self.luminance(look), dimmed)
