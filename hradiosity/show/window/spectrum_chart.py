"""The chart of one spectrum: steps of bands, and the 95 % interval around them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.scale_bar import round_up
from hradiosity.show.window.facts import Curve
from hradiosity.show.window.lettering import FAINT, INK, Rgba, Sheet, text_width

FINER: Final = 3
"""Lines are drawn so many times larger and made smaller, which smooths them."""
_BAND: Final[Rgba] = (222, 200, 90, 95)
CURVE: Final[Rgba] = (245, 225, 130, 255)
OTHER: Final[Rgba] = (110, 190, 240, 255)
_AXIS: Final[Rgba] = (110, 114, 122, 255)
_LEFT, _TOP, _RIGHT, _BOTTOM = 58, 24, 12, 34


def chart(curve: Curve, width: int, height: int) -> NDArray[np.uint8]:
    """(height, width, 4) uint8."""
    sheet = Sheet(width, height, (0, 0, 0, 0))
    inner = (width - _LEFT - _RIGHT, height - _TOP - _BOTTOM)
    top = top_of(curve)
    sheet.paste(_LEFT, _TOP, _curve_pixels(curve, top, inner))
    first, last = float(curve.lower[0]), float(curve.upper[-1])
    sheet.text(8, 10, f"{curve.name} [{curve.unit}]", INK)
    for value in np.linspace(0.0, top, 5):
        y = _TOP + inner[1] * (1.0 - value / top)
        sheet.draw.line([(_LEFT - 4, y), (_LEFT, y)], fill=_AXIS)
        sheet.text(_LEFT - 7, y, f"{value:.3g}", FAINT, anchor="rm", size=11)
    step = round_up((last - first) / max(inner[0] / 60.0, 1.0))
    for wavelength in step * np.arange(np.ceil(first / step), np.floor(last / step) + 1):
        x = _LEFT + inner[0] * (wavelength - first) / (last - first)
        sheet.draw.line([(x, height - _BOTTOM), (x, height - _BOTTOM + 4)], fill=_AXIS)
        sheet.text(x, height - _BOTTOM + 12, f"{wavelength:.0f}", FAINT, anchor="mm", size=11)
    sheet.text(width - _RIGHT, height - 9, "wavelength [nm]", FAINT, anchor="rm", size=11)
    _key(sheet, curve)
    return sheet.pixels


def _key(sheet: Sheet, curve: Curve) -> None:
    """What the interval and a second curve are, from the right."""
    marks: list[tuple[str, Rgba]] = []
    if curve.half_width is not None:
        marks.append(("± 95 % interval", _BAND))
    if curve.other is not None:
        marks += [("second", OTHER), ("first", CURVE)]
    right = sheet.pixels.shape[1] - _RIGHT
    for words, ink in marks:
        sheet.text(right, 10, words, FAINT, anchor="rm", size=11)
        right -= text_width(words, 11) + 18
        sheet.draw.rectangle([right, 5, right + 12, 15], fill=ink)
        right -= 8


def top_of(curve: Curve) -> float:
    """Highest number of the axis."""
    half = 0.0 if curve.half_width is None else curve.half_width
    other = curve.value if curve.other is None else curve.other
    highest = float(np.max([curve.value + half, other], initial=0.0))
    if curve.unit == "1":
        return 1.0
    return round_up(highest, (1.0, 1.2, 1.6, 2.0, 2.4, 3.2, 4.0, 5.0, 6.0, 8.0, 10.0)) if highest > 0.0 else 1.0


def _curve_pixels(curve: Curve, top: float, inner: tuple[int, int]) -> NDArray[np.uint8]:
    """(height, width, 4) the area inside of the axes."""
    from PIL import Image, ImageDraw

    width, height = (FINER * n for n in inner)
    image = Image.new("RGBA", (width, height), (38, 41, 47, 235))
    draw = ImageDraw.Draw(image, "RGBA")
    for y in (height * quarter / 4 for quarter in range(1, 4)):
        draw.line([(0, y), (width, y)], fill=(70, 73, 80, 255), width=FINER // 2 + 1)
    first, last = curve.lower[0], curve.upper[-1]
    edges = np.stack([curve.lower, curve.upper], axis=1)
    x = (edges.ravel() - first) / (last - first) * (width - 1)

    def heights(value: NDArray[np.float64]) -> NDArray[np.float64]:
        share: NDArray[np.float64] = np.clip(np.repeat(value, 2) / top, 0.0, 1.0)
        return (1.0 - share) * (height - 1)

    if curve.half_width is not None:
        high, low = heights(curve.value + curve.half_width), heights(curve.value - curve.half_width)
        outline = [*zip(x, high, strict=True), *zip(x[::-1], low[::-1], strict=True)]
        draw.polygon(outline, fill=_BAND)
    for value, ink in ((curve.other, OTHER), (curve.value, CURVE)):
        if value is not None:
            draw.line([*zip(x, heights(value), strict=True)], fill=ink, width=2 * FINER - 1)
    return np.asarray(image.resize(inner, Image.Resampling.BOX))
