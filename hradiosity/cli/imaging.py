"""What images are expected to take, and what is kept of those that were made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from hradiosity.cli.text import percent
from hradiosity.io.calibration import load_image_pace, store_image_pace
from hradiosity.show.image import SAMPLES

if TYPE_CHECKING:
    from hradiosity.model.scene import Scene

LEAST_SECONDS: Final = 0.5
"""Of images that tell how fast a device is."""
UNNAMED_VIEW: Final = (1280, 720)
_BYTES_WHILE_TRACED, _BYTES_KEPT = 330, 230
"""Of a pixel of the largest image, and of every image, without spectra."""


def image_plan_lines(
    scene: Scene,
    device: str,
    *,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    noise: float | None = None,
    spectra: bool = False,
) -> list[str]:
    """What a plan says of images.

    Parameters
    ----------
    scene : Scene
    device : str
        Its description.
    size, samples, noise, spectra
        As asked for on the command line.
    """
    views = [size or (view.width, view.height) for view in scene.views] or [size or UNNAMED_VIEW]
    pixels = [width * height for width, height in views]
    each = samples or SAMPLES
    pace = load_image_pace(device)
    of_spectra = 8 * len(scene.bands) * spectra
    memory = max(pixels) * (_BYTES_WHILE_TRACED + of_spectra) + sum(pixels) * (_BYTES_KEPT + of_spectra)
    until = f"until the noise is {percent(noise)}, from" if noise is not None else "with"
    told = f"images: {len(views)}, {sum(pixels) / 1e6:.3g} million pixels {until} {each} points each"
    if pace is None:
        seconds = "seconds unknown before a first image was made on this device"
    else:
        whole = pace * sum(pixels) * each * _groups(len(scene.bands))
        seconds = f"about {whole:.2g} s" + (
            " for these, and in proportion to their number" if noise is not None else ""
        )
    return [f"{told}: {seconds}, {memory / 2**20:.0f} MiB"]


def remember_images(device: str, record: Mapping[str, Any], n_bands: int) -> None:
    """Keep how fast the images of a record were made, unless they took no time to speak of."""
    if record.get("points") and record["seconds"] >= LEAST_SECONDS:
        store_image_pace(device, record["seconds"] / (record["points"] * _groups(n_bands)))


def _groups(n_bands: int) -> int:
    """Groups of eight bands."""
    return -(-n_bands // 8)
