"""Arguments of ``hradiosity render`` about what is written and shown."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hradiosity.cli.settings import OUTPUT
from hradiosity.cli.values import FalseColor, FalseColorScale, White, share
from hradiosity.errors import Fault, SceneError

if TYPE_CHECKING:
    from hradiosity.model.scene import Scene

MOST_IMAGE_SAMPLES = 1024
"""A quarter of them are one launch, which nothing breaks off: minutes, for a large image."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What a run writes and shows, as written on the command line.

    Parameters
    ----------
    resume
        Go on from an interrupted run, or from the result in the folder.
    pictures
        Draw the views of the scene.
    view
        Open a window that shows the light as it is found; the run does not depend on it, and goes on when it is closed.
    white
        What pictures show as white: as-measured, the display's own white, so that warm light looks warm; or lamps,
        the mean light of the scene's lamps, as to an eye that has got used to it.
    false_color
        What false colours stand for: illuminance or luminance.
    false_color_scale
        Linear, or log for equal ratios in equal steps, which shows dark rooms beside bright ones.
    false_color_range
        Lowest and highest number of the false colours, in lx or cd/m²; from the pictures if left out, logarithmic
        ones then over three decades at most.
    image_samples
        Points in each pixel of an image (--quality image); noise halves with four times as many. With --image-noise at
        most so many.
    image_noise
        Add points until the median over the pixels of the noise (standard error over luminance) is no more than this.
    image_size
        Width and height of images, in place of those of the views.
    image_spectra
        Write the spectrum of every pixel of an image, as spectral OpenEXR.
    maps
        Map the illuminance on all sides of the object with this name, or on those that face one way: room:up is the
        floor of a box, room:-y the wall that looks along -y. maps/NAME.png in false colours, maps/NAME.csv and .npz
        with numbers. Once for each map.
    map_error
        Error of the maps, root mean square over the mean illuminance: what their cells and the noise may leave beside
        the error of the solution.
    sensitivity
        Write sensitivity.csv: what reflectances, lamps and the sky change, which intervals do not cover.
    interval_parts
        In readings.csv, tell what the intervals are made of: sampling, mesh, iteration, spectral, precision.
    full_metrics
        In readings.csv, R1 to R14, Rf and Rg too.
    quiet
        Show nothing but errors.
    json
        One JSON object a line on standard output in place of words.
    """

    resume: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    pictures: Annotated[bool, Parameter(negative="--no-pictures", group=OUTPUT)] = True
    view: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    white: Annotated[White, Parameter(group=OUTPUT)] = White.as_measured
    false_color: Annotated[FalseColor, Parameter(group=OUTPUT)] = "illuminance"
    false_color_scale: Annotated[FalseColorScale, Parameter(group=OUTPUT)] = "linear"
    false_color_range: Annotated[tuple[float, float] | None, Parameter(negative="", group=OUTPUT)] = None
    image_samples: Annotated[int | None, Parameter(group=OUTPUT)] = None
    image_noise: Annotated[float | None, Parameter(converter=share, group=OUTPUT)] = None
    image_size: Annotated[tuple[int, int] | None, Parameter(negative="", group=OUTPUT)] = None
    image_spectra: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    maps: Annotated[list[str] | None, Parameter(name="--map", negative="", show_default=False, group=OUTPUT)] = None
    map_error: Annotated[float, Parameter(converter=share, group=OUTPUT)] = 0.02
    sensitivity: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    interval_parts: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    full_metrics: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    quiet: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    json: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False

    @property
    def mapped(self) -> tuple[str, ...]:
        """Objects to map, each once."""
        return tuple(dict.fromkeys(self.maps or ()))

    def check_objects(self, scene: Scene) -> None:
        """Raise `SceneError` for maps of what the scene has not."""
        from hradiosity.model.facing import FACINGS, named_part

        unknown = [name for name in self.mapped if named_part(scene.objects, name) is None]
        if unknown:
            names = ", ".join(map(repr, scene.objects))
            wanted = f"one of {names}, or one of them with {', '.join(FACINGS)} behind it"
            raise SceneError([Fault("command line", "map", f"no object {', '.join(map(repr, unknown))}", wanted)])

    @property
    def asks_for_images(self) -> bool:
        """Whether something is said that only images have."""
        given = self.image_samples, self.image_noise, self.image_size
        return self.image_spectra or any(value is not None for value in given)

    def check(self, *, images: bool) -> None:
        """Raise `SceneError` for what makes no sense.

        Parameters
        ----------
        images : bool
            Whether pictures are images.
        """
        faults = [*self._range_faults(), *self._image_faults(images)]
        if faults:
            raise SceneError([Fault("command line", "", found, wanted) for found, wanted in faults])

    def _image_faults(self, images: bool) -> list[tuple[str, str]]:
        faults = []
        if self.asks_for_images and not (images and self.pictures):
            faults.append(
                ("image-samples, image-noise, image-size and image-spectra are for images", "--quality image")
            )
        if self.image_samples is not None and not 1 <= self.image_samples <= MOST_IMAGE_SAMPLES:
            wanted = f"at least 1 and at most {MOST_IMAGE_SAMPLES}"
            faults.append((f"image-samples must be {wanted}, is {self.image_samples}", ""))
        if self.image_size is not None and not all(1 <= side <= 1 << 15 for side in self.image_size):
            faults.append(("image-size {} {} is no size".format(*self.image_size), "two numbers from 1 to 32768"))
        return faults

    def _range_faults(self) -> list[tuple[str, str]]:
        if self.false_color_range is None:
            return []
        low, high = self.false_color_range
        is_log = self.false_color_scale == "log"
        if math.isfinite(low) and math.isfinite(high) and low < high and (low > 0.0 or not is_log):
            return []
        wanted = "the lower number first" + (", and above 0 for a logarithmic scale" if is_log else "")
        return [(f"false-color-range {low:g} {high:g} is no range", wanted)]
