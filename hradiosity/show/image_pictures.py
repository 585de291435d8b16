"""Images as files: for eyes, for numbers and for other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.model.scene import View
from hradiosity.show.exposure import white_luminance
from hradiosity.show.image import PASSES, SAMPLES, GrowingImage, Image, device_scene
from hradiosity.show.image_files import write_image
from hradiosity.show.image_light import image_light
from hradiosity.show.pictures import PictureOptions, PictureSet, make_folder, scale_of, views_of, write_record
from hradiosity.show.white import white_of
from hradiosity.solution import Solution
from hradiosity.transport.device_scene import DeviceScene

MOST_SAMPLES: Final = 1024
"""In each pixel, where noise is asked for."""
WHOLLY: Final = 0.999
"""Share of a pixel from which on it shows surfaces only."""


@dataclass(frozen=True, kw_only=True)
class ImageOptions:
    """How images are computed.

    samples : in each pixel; None: 16, or 1024 at most where noise is asked for
    noise : passes are added until the median over the pixels of the standard error of the luminance, over the
        luminance, is no more than this; None for as many samples as are asked for
    spectra : write the spectrum of each pixel too
    size : width and height of all images in place of those of the views; the angle of view across stays
    """

    samples: int | None = None
    noise: float | None = None
    spectra: bool = False
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.samples is not None and self.samples < 1:
            raise ValueError(f"samples must be at least 1, is {self.samples}")
        if self.noise is not None and not self.noise > 0.0:
            raise ValueError(f"noise must be > 0, is {self.noise}")
        if self.size is not None and not all(1 <= side <= 1 << 15 for side in self.size):
            raise ValueError(f"size must be two numbers from 1 to 32768, is {self.size}")

    @property
    def most_samples(self) -> int:
        """In each pixel."""
        return self.samples or (SAMPLES if self.noise is None else MOST_SAMPLES)

    def goes_on(self, growing: GrowingImage) -> bool:
        """Whether an image needs a further pass."""
        if growing.passes < PASSES:
            return True
        if self.noise is None or growing.samples >= self.most_samples:
            return False
        return growing.image().noise_quantiles[0] > self.noise


def write_images(
    solution: Solution,
    folder: Path,
    device: Device,
    options: PictureOptions | None = None,
    image_options: ImageOptions | None = None,
    on_device: DeviceScene | None = None,
    progress: Callable[[str], None] | None = None,
) -> tuple[PictureSet, bool]:
    """Compute the image of each view of the scene, into ``folder``.

    For each view there are ``<view>_image.png``, ``.exr`` (X, Y, Z and their standard errors, illuminance), ``.hdr``
    (Radiance), ``<view>_image_false-color.png``, and with ``spectra`` ``<view>_image_spectral.exr``;
    ``pictures.json`` states exposure, scale, noise, and how far the display is from the colours.

    Parameters
    ----------
    solution : Solution
    folder : Path
        Made if there is none.
    device : Device
    options : PictureOptions, optional
        Its modes and refinement are of no use here.
    image_options : ImageOptions, optional
    on_device : DeviceScene, optional
        The scene's ray structure, where it is at hand already.
    progress : callable, optional
        Is told what is done, and from the second pass on how long all images will still take, at the last pass's pace.

    Returns
    -------
    PictureSet, and whether a keyboard interrupt broke it off; what had two passes by then is written.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    options, image_options = options or PictureOptions(), image_options or ImageOptions()
    if not len(solution.scene.patches):
        return PictureSet((), {"pictures": []}, ()), False
    on_device = device_scene(solution, device) if on_device is None else on_device
    views, notes = views_of(solution, on_device)
    traced = perf_counter()
    images, finished, interrupted = _images(solution, on_device, views, image_options, progress)
    traced = perf_counter() - traced
    make_folder(folder)
    record = {
        **_written(solution, folder, images, finished, options),
        "noise_asked_for": image_options.noise,
        "seconds": traced,
        "points": sum(_size(image.view) * image.samples for image in images),
        "notes": [str(note) for note in notes],
    }
    write_record(folder, record)
    return PictureSet((), record, notes), interrupted


def _written(
    solution: Solution, folder: Path, images: Sequence[Image], finished: int, options: PictureOptions
) -> dict[str, Any]:
    """Write all images with one exposure and one scale; what ``pictures.json`` says of them."""
    white_name = white_of(solution.scene, options.white)
    white = options.white_luminance or white_luminance([white_name.shown(_dull(i)).astype(np.float32) for i in images])
    scale = scale_of(options, [_seen(image, options.quantity) for image in images])
    chosen = options.white_luminance is not None
    return {
        "exposure": {
            "white_luminance_cd_m2": white,
            "rule": "as asked for" if chosen else "1 in 100 pixels that do not shine is brighter, all views together",
            "colours": f"{white_name.words}; clipped, no tone curve",
        },
        "false_color": scale.record(),
        "pictures": [
            write_image(folder, image, solution.scene.name, white_name, white, scale, complete=number < finished)
            for number, image in enumerate(images)
        ],
    }


def _images(
    solution: Solution,
    on_device: DeviceScene,
    views: Sequence[View],
    options: ImageOptions,
    progress: Callable[[str], None] | None,
) -> tuple[list[Image], int, bool]:
    """Images of all views, how many are finished, and whether an interrupt came; the last one has two passes then."""
    images: list[Image] = []
    growing: GrowingImage | None = None
    pace = 0.0
    try:
        sized_views = [_sized(view, options.size) for view in views]
        light = image_light(solution, on_device, sized_views)
        for view in sized_views:
            growing = GrowingImage(
                light,
                view,
                solution.scene.bands,
                samples=options.most_samples if options.noise is None else min(options.most_samples, SAMPLES),
                seed=int(solution.record["options"]["seed"]),
                spectra=options.spectra,
            )
            while options.goes_on(growing):
                if progress is not None:
                    later = PASSES * sum(map(_size, sized_views[len(images) + 1 :]))
                    progress(_progress(growing, view, options, pace, later))
                start = perf_counter()
                growing.add_pass()
                pace = (perf_counter() - start) / _size(view)
            images.append(growing.image())
            growing = None
    except KeyboardInterrupt:
        finished = len(images)
        if growing is not None and growing.passes >= 2:
            images.append(growing.image())
        return images, finished, True
    return images, len(images), False


def _progress(growing: GrowingImage, view: View, options: ImageOptions, pace: float, later: int) -> str:
    """What is done, and how long it will take where that is known: `later` pixels and passes, after this image."""
    if options.noise is None or growing.passes < PASSES:
        left = (PASSES - growing.passes) * _size(view) + later
        told = "" if options.noise is not None else time_left(left * pace)
        return f"image of {view.name!r}: pass {growing.passes + 1} of {PASSES}{told}"
    found = growing.image().noise_quantiles[0]
    so_far = f"noise {found:.2%} so far, {options.noise:.2%} wanted"
    return f"image of {view.name!r}: {growing.samples} points a pixel, {so_far}"


def time_left(seconds: float) -> str:
    """What to say of the time that images will still take; nothing while it is unknown (0)."""
    if seconds <= 0.0:
        return ""
    return f", about {seconds:.0f} s left" if seconds < 100.0 else f", about {seconds / 60.0:.0f} min left"


def _size(view: View) -> int:
    """Pixels."""
    return view.width * view.height


def _sized(view: View, size: tuple[int, int] | None) -> View:
    return view if size is None else replace(view, width=size[0], height=size[1])


def _dull(image: Image) -> NDArray[np.float64]:
    """(n, 3) X, Y, Z of the pixels that show only surfaces that do not shine."""
    return image.dull[image.surface - image.shining > WHOLLY]


def _seen(image: Image, quantity: str) -> NDArray[np.float64]:
    """Illuminance or luminance of the same pixels."""
    values = image.illuminance if quantity == "illuminance" else image.xyz[..., 1]
    return values[image.surface - image.shining > WHOLLY]
