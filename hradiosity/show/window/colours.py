"""Colours of cells and of their corners in each mode: the same as in pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Drawn, Light
from hradiosity.metrics.colorimetric import encode_srgb, out_of_gamut, xyz_to_linear_srgb, xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.show.channels import colours_of_paints
from hradiosity.show.colormap import colours_of
from hradiosity.show.exposure import to_bytes, white_luminance
from hradiosity.show.scale_bar import Scale, automatic_scale
from hradiosity.show.white import White
from hradiosity.show.window.look import Quantity
from hradiosity.show.window.seams import level_seams
from hradiosity.show.window.vertices import corner_means, shared_corners

DIMMED: Final = 0.5
"""Of the light below outlines, linear, as in pictures."""
_AWAY: Final = np.array([0.30, 0.44, 0.84])
"""Direction of the light in which an unsolved scene is shown, so that its faces can be told apart."""
_SHADE: Final = 0.55


@dataclass(frozen=True)
class Values:
    """Numbers that become colours, at cells (n, …) or at corners (n, 4, …).

    xyz : (…, 3) X, Y, Z of the radiance, Y in cd m⁻²
    illuminance : (…) [lx]
    """

    xyz: NDArray[np.float64]
    illuminance: NDArray[np.float64]

    def of(self, quantity: Quantity) -> NDArray[np.float64]:
        """Illuminance [lx] or luminance [cd m⁻²]."""
        return self.illuminance if quantity == "illuminance" else self.xyz[..., 1]


class LightValues:
    """Light of a solution at its cells and corners.

    Parameters
    ----------
    drawn : Drawn
    light : Light
    """

    def __init__(self, drawn: Drawn, light: Light, vertex: NDArray[np.int64] | None = None) -> None:
        self._drawn, self._light, self._vertex = drawn, light, vertex
        cells, words = drawn.cells, drawn.words
        weights = xyz_weights(words.bands)
        per_element = np.asarray(light.irradiance, np.float64)
        lux = np.einsum("eb,b->e", per_element, luminous_weights(words.bands))
        coloured = np.einsum("mb,bc->mbc", words.reflectance, weights)
        self._reflected = np.zeros((len(cells), 3))
        # One product for each paint: elements of one paint share the weights of its reflectance.
        of_element = np.zeros((len(per_element), 3))
        paint = np.full(len(per_element), len(words.reflectance) - 1)
        paint[cells.element] = cells.material
        for material in np.unique(paint):
            those = np.flatnonzero(paint == material)
            of_element[those] = np.einsum("eb,bc->ec", per_element[those], coloured[material])
        self._reflected = of_element[cells.element]
        self._lux = lux[cells.element]
        self._emitted = np.einsum("lb,bc->lc", words.exitance, weights)[cells.luminaire]

    @property
    def light(self) -> Light:
        """What it was made of."""
        return self._light

    @property
    def shining(self) -> NDArray[np.bool_]:
        """(n,) bool, the cell shines by itself."""
        shines: NDArray[np.bool_] = self._drawn.cells.luminaire >= 0
        return shines

    @cached_property
    def flat(self) -> Values:
        """One value a cell."""
        return Values((self._reflected + self._emitted) / np.pi, self._lux)

    @property
    def vertex(self) -> NDArray[np.int64]:
        """(n, 4) vertices that corners share."""
        if self._vertex is None:
            self._vertex = shared_corners(self._drawn.cells, self._light)
        return self._vertex

    @cached_property
    def smooth(self) -> Values:
        """One value a corner."""
        columns = np.column_stack([self._reflected, self._lux])
        cells, light = self._drawn.cells, self._light
        means = level_seams(cells, light, self.vertex, corner_means(cells, light, self.vertex, columns))
        return Values((means[..., :3] + self._emitted[:, None, :]) / np.pi, means[..., 3])


def chosen_white(values: LightValues, white: White, area: NDArray[np.float64]) -> float:
    """Luminance to show as white [cd m⁻²] where no picture chose one: one in a hundred of the dull surface is brighter.

    Parameters
    ----------
    values : LightValues
    white : White
    area : (n,) [m²]
    """
    shown = white.shown(values.flat.xyz)
    dull = np.flatnonzero(~values.shining & (area > 0.0))
    share = np.cumsum(area[dull])
    if not len(dull):
        return 1.0
    # Places that are evenly spread over the area stand for pixels.
    places = np.searchsorted(share, (np.arange(4096) + 0.5) / 4096 * share[-1])
    return white_luminance([shown[dull[np.minimum(places, len(dull) - 1)]].astype(np.float32)])


def chosen_scale(values: LightValues, quantity: Quantity, logarithmic: bool) -> Scale:
    """Scale of the false colours where none was chosen."""
    unit = "lx" if quantity == "illuminance" else "cd/m²"
    seen = values.flat.of(quantity)[~values.shining]
    return automatic_scale(seen, logarithmic=logarithmic, quantity=quantity, unit=unit)


def light_colours(xyz: NDArray[np.float64], white: White, luminance: float, dimmed: bool = False) -> NDArray[np.uint8]:
    """(…, 3) sRGB of radiances (…, 3); dimmed below outlines."""
    linear = xyz_to_linear_srgb(white.shown(xyz.reshape(-1, 3)), luminance)
    if dimmed:
        linear = DIMMED * np.clip(linear, 0.0, 1.0)
    return to_bytes(encode_srgb(linear)).reshape(xyz.shape)


def scale_colours(values: NDArray[np.float64], scale: Scale) -> NDArray[np.uint8]:
    """(…, 3) sRGB of numbers on a scale."""
    return to_bytes(colours_of(scale.share(values)))


def paint_bytes(drawn: Drawn) -> NDArray[np.uint8]:
    """(n, 3) sRGB of the cells' paints under D65."""
    paints = colours_of_paints(drawn.words.reflectance, drawn.words.bands)
    return to_bytes(encode_srgb(xyz_to_linear_srgb(paints, 1.0)))[drawn.cells.material]


def luminous_reflectances(drawn: Drawn) -> NDArray[np.float64]:
    """(n,) Y of the cells' paints under D65, 1 for a perfect white."""
    reflectances: NDArray[np.float64] = colours_of_paints(drawn.words.reflectance, drawn.words.bands)[:, 1]
    return reflectances[drawn.cells.material]


def unsolved_colours(drawn: Drawn) -> NDArray[np.uint8]:
    """(n, 3) sRGB of a scene without light: paints, darker as they turn away from one direction; lamps white."""
    paints = colours_of_paints(drawn.words.reflectance, drawn.words.bands)[drawn.cells.material]
    shade = 1.0 - _SHADE * 0.5 * (1.0 - np.einsum("nk,k->n", drawn.cells.normal, _AWAY / np.linalg.norm(_AWAY)))
    linear = xyz_to_linear_srgb(paints, 1.0) * shade[:, None]
    linear[drawn.cells.luminaire >= 0] = 1.0
    return to_bytes(encode_srgb(linear))


def gamut_marks(values: LightValues, white: White) -> NDArray[np.bool_]:
    """(n,) bool, cells whose colour is too saturated for an sRGB display at any exposure."""
    return out_of_gamut(xyz_to_linear_srgb(white.shown(values.flat.xyz), 1.0))
