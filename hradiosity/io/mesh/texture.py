"""The one colour that stands for a picture on a surface."""

import io
import struct
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.mesh.raw import Texture

if TYPE_CHECKING:
    from PIL import Image

_DAMAGE: Final = (OSError, SyntaxError, ValueError, EOFError, IndexError, TypeError, struct.error, zlib.error)
"""What Pillow raises on files that are damaged or no picture."""


def linear_from_srgb(encoded: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear light of sRGB values, both 0 … 1, after IEC 61966-2-1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def mean_colour(texture: Texture) -> tuple[float, float, float]:
    """Linear sRGB, the mean over all texels of the picture, decoded one by one, times the texture's factor.

    Each texel counts the same, however much of it lies on faces, and its opacity does not count.

    Raises
    ------
    ValueError
        When the picture is missing or can't be read, in words for the user.
    """
    from PIL import Image

    if texture.source is None:
        raise ValueError("the file holds no picture for it in a format that is read")
    if not isinstance(texture.source, bytes) and not _is_file(texture.source):
        raise ValueError(f"no file {texture.source}")
    opened = io.BytesIO(texture.source) if isinstance(texture.source, bytes) else texture.source
    try:
        with Image.open(opened) as image:
            image.load()
            mean = _grey_mean(image) if image.mode.startswith("I") else _mean_of_bytes(image.convert("RGB"))
    except (*_DAMAGE, Image.DecompressionBombError) as error:
        raise ValueError("the picture is damaged, or of a format that is not read") from error
    red, green, blue = (float(value) for value in mean * np.array(texture.factor))
    return red, green, blue


def _mean_of_bytes(image: "Image.Image") -> NDArray[np.float64]:
    """(3,) from the 256 values that a texel can have in each channel."""
    counts = np.array(image.histogram(), dtype=np.float64).reshape(3, 256)
    total = np.einsum("cv,v->c", counts, linear_from_srgb(np.arange(256) / 255.0))
    mean: NDArray[np.float64] = total / counts.sum(axis=1)
    return mean


def _is_file(path: Path) -> bool:
    """Whether there is one; names that the system takes for none, such as overlong ones, name none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _grey_mean(image: "Image.Image") -> NDArray[np.float64]:
    """(3,) of a picture of one channel with 16 bits."""
    encoded = np.clip(np.asarray(image, dtype=np.float64) / 65535.0, 0.0, 1.0)
    return np.full(3, linear_from_srgb(encoded).mean())
