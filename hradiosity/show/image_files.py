"""One image as files: for eyes, for numbers and for other programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.color_difference import delta_e_2000, lab
from hradiosity.metrics.colorimetric import (
    SRGB_WHITE,
    encode_srgb,
    linear_srgb_to_xyz,
    out_of_gamut,
    overexposed,
    xyz_to_linear_srgb,
)
from hradiosity.show.drawing import file_name
from hradiosity.show.exposure import to_bytes
from hradiosity.show.files import png_bytes, write_bytes, write_exr
from hradiosity.show.image import Image
from hradiosity.show.radiance_file import radiance_picture
from hradiosity.show.scale_bar import Scale, false_colours, with_scale_bar
from hradiosity.show.white import White

SPECTRAL_LAYOUT: Final = {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1.nm^-1"}
"""Attributes of spectral OpenEXR files (Fichet, Pacanowski & Wilkie 2021, "An OpenEXR layout for spectral images")."""


@dataclass(frozen=True)
class Shown:
    """An image on a display.

    pixels : (height, width, 3) uint8, sRGB
    record : shares that the display can't show, and colour differences to what it shows
    """

    pixels: NDArray[np.uint8]
    record: dict[str, float]


def develop_image(image: Image, white: White, white_level: float) -> Shown:
    """Colours for a display.

    What shines and what does not are clipped apart and then mixed by their shares of the pixel, else the edge of a
    lamp a thousand times brighter than white would be a staircase. Samples are never clipped, which would darken noise.
    """
    share = image.shining[..., None]
    parts = [
        np.divide(light, part, out=np.zeros_like(light), where=part > 0.0)
        for light, part in ((image.dull, 1.0 - share), (image.bright, share))
    ]
    dull, bright = (xyz_to_linear_srgb(white.shown(part.reshape(-1, 3)), white_level) for part in parts)
    weight = share.reshape(-1, 1)
    mean = (1.0 - weight) * dull + weight * bright
    clipped = (1.0 - weight) * np.clip(dull, 0.0, 1.0) + weight * np.clip(bright, 0.0, 1.0)
    pixels = to_bytes(encode_srgb(clipped))
    true = white.shown(image.xyz.reshape(-1, 3)) / white_level
    difference = display_difference(np.maximum(true, 0.0), linear_srgb_to_xyz(clipped))
    record = {
        "out_of_gamut_share": float(out_of_gamut(mean).mean()),
        "overexposed_share": float(overexposed(mean).mean()),
        "delta_e_2000_to_display_mean": float(difference.mean()),
        "delta_e_2000_to_display_95": float(np.quantile(difference, 0.95)),
    }
    return Shown(pixels.reshape(*image.shining.shape, 3), record)


def display_difference(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIEDE2000 between X, Y, Z (…, 3) of a display whose white is D65 with Y = 1."""
    x, y = SRGB_WHITE
    white = np.array([x / y, 1.0, (1.0 - x - y) / y])
    return delta_e_2000(lab(first, white), lab(second, white))


def write_image(
    folder: Path, image: Image, scene_name: str, white: White, white_level: float, scale: Scale, *, complete: bool
) -> dict[str, Any]:
    """All files of one image; returns its entry in ``pictures.json``, which says whether it is `complete`."""
    stem = f"{file_name(image.view.name)}_image"
    shown = develop_image(image, white, white_level)
    noise = image.noise_quantiles
    texts = {
        "method": "final gather in every pixel, box filter, no denoising",
        "exposure": f"white is {white_level:.6g} cd/m²",
        "colours": white.words,
        "sampling": f"{image.samples} points a pixel in {image.passes} passes",
        "noise": f"standard error of the luminance {noise[0]:.2%} median, {noise[1]:.2%} 95th percentile of the pixels",
    }
    title = {"Title": f"{scene_name}: {image.view.name}, image"}
    write_bytes(folder / f"{stem}.png", png_bytes(shown.pixels, {**title, **texts}))
    units = {"units": "X, Y, Z of CIE 1931, Y in cd/m²; SE: standard errors of these; E: illuminance in lx"}
    write_exr(folder / f"{stem}.exr", _channels(image), {**title, **texts, **units})
    remark = {"SOFTWARE": "hradiosity", "VIEWNAME": image.view.name, "NOISE": texts["noise"]}
    write_bytes(folder / f"{stem}.hdr", radiance_picture(image.xyz, remark))
    values = image.illuminance if scale.quantity == "illuminance" else image.xyz[..., 1]
    coloured = with_scale_bar(false_colours(values, image.surface > 0.0, scale), scale)
    scale_text = {"scale": f"{scale.quantity} {scale.low:g} to {scale.high:g} {scale.unit}"}
    write_bytes(folder / f"{stem}_false-color.png", png_bytes(coloured, {**title, **scale_text}))
    spectral = None
    if image.spectrum is not None:
        spectral = f"{stem}_spectral.exr"
        write_exr(folder / spectral, spectral_channels(image), {**title, **texts, **SPECTRAL_LAYOUT})
    return {
        "file": f"{stem}.png",
        "exr": f"{stem}.exr",
        "hdr": f"{stem}.hdr",
        "false_color": f"{stem}_false-color.png",
        "spectral_exr": spectral,
        "view": image.view.name,
        "kind": "image",
        "mode": "image",
        "width": image.view.width,
        "height": image.view.height,
        "samples": image.samples,
        "passes": image.passes,
        "complete": complete,
        "noise_median": noise[0],
        "noise_95": noise[1],
        **shown.record,
        **texts,
    }


def _channels(image: Image) -> dict[str, NDArray[np.floating]]:
    named = {name: image.xyz[..., c] for c, name in enumerate("XYZ")}
    errors = {f"SE.{name}": image.standard_error[..., c] for c, name in enumerate("XYZ")}
    return {**named, **errors, "E": image.illuminance, "SE.E": image.illuminance_error}


def spectral_channels(image: Image) -> dict[str, NDArray[np.floating]]:
    """A channel for each band, named by its centre as the layout of Fichet et al. 2021 has it: ``S0.562,5nm``.

    Radiance [W m⁻² sr⁻¹ nm⁻¹]. R, G, B are linear sRGB with luminances in cd m⁻², for programs that know no spectra.
    """
    if image.spectrum is None:
        raise ValueError("the image was made without spectra")
    rgb = xyz_to_linear_srgb(image.xyz, 1.0)
    names = [f"S0.{f'{centre:g}'.replace('.', ',')}nm" for centre in image.bands.centre]
    bands = {name: image.spectrum[..., b] for b, name in enumerate(names)}
    return {**bands, **{name: rgb[..., c] for c, name in enumerate("RGB")}}
