"""Picture files: PNG for eyes, OpenEXR for numbers."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import OutputError


def png_bytes(pixels: NDArray[np.uint8], texts: Mapping[str, str]) -> bytes:
    """A PNG file of sRGB pixels (height, width, 3), with texts that name what it shows."""
    from PIL import Image, PngImagePlugin

    info = PngImagePlugin.PngInfo()
    for name, text in texts.items():
        info.add_itxt(name, text)
    memory = io.BytesIO()
    Image.fromarray(pixels).save(memory, "PNG", pnginfo=info, compress_level=4)
    return memory.getvalue()


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file.

    Raises
    ------
    OutputError
        When it can't be written.
    """
    try:
        path.write_bytes(content)
    except OSError as error:
        raise OutputError(f"{path} can't be written: {error.strerror or error}") from error


def write_exr(path: Path, channels: Mapping[str, NDArray[np.floating]], texts: Mapping[str, str]) -> None:
    """Write an OpenEXR file of float channels (height, width) by name.

    Raises
    ------
    OutputError
        When it can't be written.
    """
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **texts}
    arrays = {name: np.ascontiguousarray(channel, np.float32) for name, channel in channels.items()}
    try:
        with OpenEXR.File(header, arrays) as file:
            file.write(str(path))
    except (OSError, RuntimeError) as error:
        raise OutputError(f"{path} can't be written: {error}") from error
