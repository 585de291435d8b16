"""Drawing one view: light at its points, then pixels in each mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb, xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import View
from hradiosity.show.camera import ABOVE, PicturePoints, ViewHits, picture_points, trace_view
from hradiosity.show.channels import paint_colours
from hradiosity.show.exposure import Developed, develop, pixel_means, to_bytes
from hradiosity.show.light import PictureScene, RowLight, picture_scene, row_light, shadow_channels
from hradiosity.show.row_gather import gather_rows
from hradiosity.show.scale_bar import Scale, false_colours, with_scale_bar
from hradiosity.show.seams import level_seams
from hradiosity.show.shading import flat_light, line_mask, locate, refinement_goal, smooth_light
from hradiosity.show.white import White
from hradiosity.solution import Solution
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.refine import RefinementOptions, ShadowLight, refine_shadows

PER_PIXEL: Final = 3
"""Samples across and down a pixel."""
LEAF_PIXELS: Final = 3.0
"""Leaves are not made smaller than this on the screen."""
_CELL_LINE, _LEAF_LINE = 2, 1
"""Width of the lines in samples."""
_CELL_INK, _LEAF_INK, _DIMMED = 0.8, 0.25, 0.5


@dataclass(frozen=True)
class Picture:
    """One finished picture.

    pixels : (height, width, 3) uint8, sRGB; the false-colour mode has its scale on the right
    channels : (height, width) float32 by name, for the OpenEXR file; empty for a wireframe
    texts : units and exposure, for the files
    developed : None where colours stand for numbers
    dark, empty : shares of the picture that no light reaches, and where the view leaves the scene
    """

    view: str
    mode: str
    stem: str
    pixels: NDArray[np.uint8]
    channels: Mapping[str, NDArray[np.float32]]
    texts: Mapping[str, str]
    developed: Developed | None
    dark: float
    empty: float

    def record(self) -> dict[str, Any]:
        """The entry in ``pictures.json``."""
        shares = self.developed
        return {
            "file": f"{self.stem}.png",
            "exr": f"{self.stem}.exr" if self.channels else None,
            "view": self.view,
            "kind": "model",
            "mode": self.mode,
            "width": self.pixels.shape[1],
            "height": self.pixels.shape[0],
            "out_of_gamut_share": None if shares is None else shares.out_of_gamut,
            "overexposed_share": None if shares is None else shares.overexposed,
            "no_light_share": self.dark,
            "outside_share": self.empty,
            **self.texts,
        }


@dataclass(frozen=True)
class Drawing:
    """A view and the light of its scene; light at points is computed when first asked for."""

    picture: PictureScene
    view: View
    hits: ViewHits
    points: PicturePoints
    rows: RowLight
    shadow: ShadowLight
    at_vertex: NDArray[np.float32]
    sky: NDArray[np.float64]
    white: White

    @cached_property
    def smooth(self) -> NDArray[np.float32]:
        """(n, 4) channels at the points, interpolated."""
        located = locate(self.picture, self.shadow, self.points)
        return smooth_light(self.picture, self.rows, self.shadow, self.at_vertex, located)

    @cached_property
    def flat(self) -> NDArray[np.float32]:
        """(n, 4) channels at the points, one value a leaf."""
        located = locate(self.picture, self.shadow, self.points)
        return flat_light(self.picture, self.rows, self.shadow, self.at_vertex, located)

    @property
    def hit(self) -> NDArray[np.bool_]:
        """(n,) bool, the point lies on a surface."""
        on_surface: NDArray[np.bool_] = self.points.side >= 0
        return on_surface

    @property
    def shining(self) -> NDArray[np.bool_]:
        """(n,) bool, the point lies on an emitter's shining side."""
        emits: NDArray[np.bool_] = np.any(self.picture.emitted > 0.0, axis=1)
        on_emitter: NDArray[np.bool_] = self.hit & emits[np.maximum(self.points.side, 0)]
        return on_emitter

    def radiance(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n, 3) X, Y, Z of the radiance (M₀ + ρE) / π at the points, sky included; Y in cd m⁻²."""
        emitted = self.picture.emitted[np.maximum(self.points.side, 0)]
        xyz = np.where(self.hit[:, None], light[:, :3] + emitted, 0.0) / np.pi
        xyz[self.points.side == ABOVE] = self.sky
        return xyz.astype(np.float32)

    @cached_property
    def smooth_radiance(self) -> NDArray[np.float32]:
        """`radiance` of the smooth picture."""
        return self.radiance(self.smooth)

    def shown(self, xyz: NDArray[np.float32]) -> NDArray[np.float32]:
        """X, Y, Z (n, 3) as displays show them, adapted if that was asked for."""
        return self.white.shown(xyz).astype(np.float32)

    def dull_radiance(self) -> NDArray[np.float32]:
        """X, Y, Z of the points on surfaces that do not shine, (m, 3)."""
        return self.smooth_radiance[self.hit & ~self.shining]

    def dull_illuminance(self) -> NDArray[np.float32]:
        """Illuminance [lx] of the points on surfaces that do not shine, (m,)."""
        lux: NDArray[np.float32] = self.smooth[self.hit & ~self.shining, 3]
        return lux


def prepare_drawing(
    solution: Solution, on_device: DeviceScene, views: Sequence[View], refinement: RefinementOptions, white: White
) -> list[Drawing]:
    """Rays of all views, and shadows refined where any of them looks."""
    scene, picture = solution.scene, picture_scene(solution)
    hits = [trace_view(on_device.bvh, view, PER_PIXEL) for view in views]
    lux = np.einsum("rb,b->r", solution.surfaces.irradiance, luminous_weights(scene.bands))
    goal = refinement_goal(picture, hits, LEAF_PIXELS * PER_PIXEL, lux)
    shadow = refine_shadows(on_device, sampled_scene(scene, solution.plan.weak_emitters), goal, refinement)
    gathered = gather_rows(solution, on_device)
    light = row_light(picture, solution, shadow, gathered)
    rows = level_seams(picture, on_device.bvh, light, solution.surfaces.exposed)
    at_vertex = shadow_channels(picture, shadow)
    sky = np.zeros(3) if scene.sky is None else np.einsum("b,bc->c", scene.sky.radiance, xyz_weights(scene.bands))
    return [
        Drawing(picture, view, view_hits, picture_points(view_hits, PER_PIXEL), rows, shadow, at_vertex, sky, white)
        for view, view_hits in zip(views, hits, strict=True)
    ]


def draw_view(drawing: Drawing, mode: str, *, white: float, scale: Scale) -> Picture:
    """One picture.

    Parameters
    ----------
    drawing : Drawing
    mode : one of ``pictures.MODES``
    white : float
        Luminance shown as white [cd m⁻²].
    scale : Scale
        Of the false colours.
    """
    draw = {
        "flat": _shaded,
        "smooth": _shaded,
        "wireframe": _wireframe,
        "unshaded": _unshaded,
        "false-color": _false_color,
    }[mode]
    pixels, channels, texts, developed = draw(drawing, mode, white, scale)
    n_pixels = drawing.view.height * drawing.view.width
    unlit = drawing.hit & (drawing.smooth[:, 3] <= 0.0) & ~drawing.shining
    return Picture(
        view=drawing.view.name,
        mode=mode,
        stem=f"{file_name(drawing.view.name)}_{mode}",
        pixels=pixels,
        channels=channels,
        texts=texts,
        developed=developed,
        dark=float(drawing.points.weight[unlit].sum(dtype=np.float64)) / n_pixels,
        empty=float(drawing.points.weight[~drawing.hit].sum(dtype=np.float64)) / n_pixels,
    )


_Drawn = tuple[NDArray[np.uint8], dict[str, NDArray[np.float32]], dict[str, str], Developed | None]


def _shaded(drawing: Drawing, mode: str, white: float, _scale: Scale) -> _Drawn:
    xyz = drawing.radiance(drawing.flat) if mode == "flat" else drawing.smooth_radiance
    developed = develop(drawing.points, drawing.shown(xyz), drawing.view.height, drawing.view.width, white)
    return developed.pixels, _xyz_channels(drawing, xyz), _exposure_texts(drawing, white), developed


def _wireframe(drawing: Drawing, _mode: str, white: float, _scale: Scale) -> _Drawn:
    """Dimmed smooth shading with white outlines: faint ones of leaves, strong ones of cells."""
    xyz = drawing.shown(drawing.smooth_radiance)
    height, width = drawing.view.height, drawing.view.width
    linear = np.clip(xyz_to_linear_srgb(xyz.astype(np.float64), white), 0.0, 1.0)
    shaded = pixel_means(drawing.points, linear, height * width)
    located = locate(drawing.picture, drawing.shadow, drawing.hits)
    cells = line_mask(located.cell, drawing.hits.width, _CELL_LINE)
    leaves = line_mask(located.node, drawing.hits.width, _LEAF_LINE)
    ink = np.maximum(_CELL_INK * cells, _LEAF_INK * leaves).reshape(height, PER_PIXEL, width, PER_PIXEL)
    cover = ink.mean(axis=(1, 3)).reshape(-1, 1)
    pixels = to_bytes(encode_srgb(_DIMMED * shaded * (1.0 - cover) + cover)).reshape(height, width, 3)
    return pixels, {}, _exposure_texts(drawing, white), None


def _unshaded(drawing: Drawing, _mode: str, _white: float, _scale: Scale) -> _Drawn:
    """Colours of the paints under the illuminant D65; a perfect white is the display's white."""
    colours = paint_colours(drawing.picture.scene)
    material = drawing.picture.elements.side_material.ravel()[np.maximum(drawing.points.side, 0)]
    xyz = np.where(drawing.hit[:, None], colours[material], 0.0).astype(np.float32)
    developed = develop(drawing.points, xyz, drawing.view.height, drawing.view.width, 1.0)
    texts = {"exposure": "white is reflectance 1", "units": "X, Y, Z of the reflectance under CIE D65, Y of white 1"}
    return developed.pixels, _xyz_channels(drawing, xyz), texts, developed


def _false_color(drawing: Drawing, _mode: str, _white: float, scale: Scale) -> _Drawn:
    height, width = drawing.view.height, drawing.view.width
    is_illuminance = scale.quantity == "illuminance"
    values = drawing.smooth[:, 3] if is_illuminance else drawing.smooth_radiance[:, 1]
    means = pixel_means(drawing.points, np.stack([values, drawing.hit], axis=1), height * width)
    share = means[:, 1].reshape(height, width)
    of_surfaces = np.where(drawing.hit, values, 0.0)[:, None]
    shown = pixel_means(drawing.points, of_surfaces, height * width).reshape(height, width)
    shown = np.divide(shown, share, out=np.zeros_like(shown), where=share > 0.0)
    coloured = false_colours(shown, share > 0.0, scale)
    kind = "logarithmic" if scale.logarithmic else "linear"
    texts = {"units": scale.unit, "scale": f"{scale.quantity} {scale.low:g} to {scale.high:g} {scale.unit}, {kind}"}
    return with_scale_bar(coloured, scale), {scale.quantity: shown.astype(np.float32)}, texts, None


def _xyz_channels(drawing: Drawing, xyz: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
    height, width = drawing.view.height, drawing.view.width
    means = pixel_means(drawing.points, xyz, height * width).astype(np.float32)
    return {name: means[:, c].reshape(height, width) for c, name in enumerate("XYZ")}


def _exposure_texts(drawing: Drawing, white: float) -> dict[str, str]:
    return {
        "exposure": f"white is {white:.6g} cd/m²",
        "colours": drawing.white.words,
        "units": "X, Y, Z of CIE 1931, Y in cd/m²",
    }


def file_name(name: str) -> str:
    """The view's name with everything but letters, digits, dots and dashes as underscores."""
    return "".join(c if c.isalnum() or c in ".-" else "_" for c in name)
