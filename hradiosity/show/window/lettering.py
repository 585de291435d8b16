"""Words and rectangles on small transparent images that lie over the picture."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw as Pencil
    from PIL.ImageFont import FreeTypeFont, ImageFont

Rgba = tuple[int, int, int, int]
GROUND: Final[Rgba] = (20, 22, 26, 215)
INK: Final[Rgba] = (240, 240, 240, 255)
FAINT: Final[Rgba] = (165, 168, 175, 255)
CHOSEN: Final[Rgba] = (222, 200, 90, 255)
TEXT: Final = 13
"""Height of letters [pixels]."""
LINE: Final = 18


@cache
def font(size: int = TEXT) -> FreeTypeFont | ImageFont:
    """DejaVu Sans, which matplotlib brings along and which has all signs of units; Pillow's own without it."""
    from PIL import ImageFont

    found = find_spec("matplotlib")
    for folder in (found.submodule_search_locations or ()) if found else ():
        file = Path(folder, "mpl-data", "fonts", "ttf", "DejaVuSans.ttf")
        if file.is_file():
            return ImageFont.truetype(str(file), size)
    return ImageFont.load_default(size)


def text_width(text: str, size: int = TEXT) -> int:
    """Of one line [pixels]."""
    return int(np.ceil(font(size).getlength(text)))


class Sheet:
    """An image to draw on, with a ground that lets the picture shine through.

    Parameters
    ----------
    width, height : int
    ground : Rgba
    """

    def __init__(self, width: int, height: int, ground: Rgba = GROUND) -> None:
        from PIL import Image, ImageDraw

        self._image = Image.new("RGBA", (width, height), ground)
        self.draw: Pencil = ImageDraw.Draw(self._image)

    def text(self, x: float, y: float, words: str, ink: Rgba = INK, *, anchor: str = "lm", size: int = TEXT) -> None:
        """One line; `anchor` as in Pillow, left and middle if left out."""
        self.draw.text((x, y), words, fill=ink, font=font(size), anchor=anchor)

    def paste(self, x: int, y: int, pixels: NDArray[np.uint8]) -> None:
        """Pixels (h, w, 3) or (h, w, 4) at a place."""
        from PIL import Image

        self._image.paste(Image.fromarray(pixels).convert("RGBA"), (x, y))

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 4) uint8."""
        return np.asarray(self._image).copy()
