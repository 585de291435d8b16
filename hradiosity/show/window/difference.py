"""Two results of one mesh: their difference, on a scale that is even to both sides of 0."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.drawn_scene import Drawn
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb
from hradiosity.show.colormap import SIZE, lab_to_xyz
from hradiosity.show.exposure import to_bytes
from hradiosity.show.scale_bar import TOPS, Scale, round_up
from hradiosity.show.window.colours import LightValues
from hradiosity.show.window.look import Quantity

SAME_PLACE: Final = 1e-9
"""Corners of two results may differ by so much, over the size of the scene."""
_LESS: Final = np.array([[28.0, 4.0, -38.0], [55.0, -6.0, -34.0], [78.0, -8.0, -18.0], [95.0, 0.0, 0.0]])
"""CIE L*, a*, b* from dark blue to near white: told apart from `_MORE` without red and green."""
_MORE: Final = np.array([[95.0, 0.0, 0.0], [80.0, 12.0, 36.0], [58.0, 30.0, 50.0], [32.0, 34.0, 38.0]])
"""From near white over orange to brown."""


def check_same_mesh(first: Drawn, second: Drawn, names: tuple[str, str]) -> None:
    """Raise `SceneError` unless both results have the same elements and bands."""
    a, b = first.cells, second.cells
    hint = "render both with the same scene, --elements and --refinement off"
    if first.light is None or second.light is None:
        raise SceneError([Fault(f"{names[0]}, {names[1]}", "", "one of them is a scene", "two results")])
    found = ""
    if len(a) != len(b) or not np.array_equal(a.element, b.element):
        found = f"they have other elements: {a.element.max(initial=-1) + 1} and {b.element.max(initial=-1) + 1}"
    elif np.abs(a.corners - b.corners).max(initial=0.0) > SAME_PLACE * max(np.abs(a.corners).max(initial=0.0), 1e-30):
        found = "their surfaces lie elsewhere"
    elif not np.array_equal(first.words.bands.centre, second.words.bands.centre):
        found = "they have other bands"
    if found:
        raise SceneError([Fault(f"{names[0]}, {names[1]}", "", f"{found}, so no difference can be shown", hint)])


def difference(first: LightValues, second: LightValues, quantity: Quantity) -> NDArray[np.float64]:
    """(n,) second − first at the cells [lx] or [cd m⁻²]."""
    change: NDArray[np.float64] = second.flat.of(quantity) - first.flat.of(quantity)
    return change


def difference_scale(change: NDArray[np.float64], dull: NDArray[np.bool_], quantity: Quantity) -> Scale:
    """Even to both sides, holding all but the largest hundredth of what does not shine."""
    seen = np.abs(change[dull])
    largest = float(np.quantile(seen, 0.99)) if len(seen) else 0.0
    end = round_up(largest, TOPS) if largest > 0.0 else 1.0
    return Scale(-end, end, False, quantity, "lx" if quantity == "illuminance" else "cd/m²")


@cache
def difference_colours() -> NDArray[np.float64]:
    """(255, 3) sRGB from the most negative number to the most positive one; white in the middle."""
    half = SIZE // 2
    steps = np.linspace(0.0, 1.0, half)
    parts = [
        np.stack([np.interp(steps, np.linspace(0.0, 1.0, len(knots)), column) for column in knots.T], axis=1)
        for knots in (_LESS, _MORE)
    ]
    lab = np.concatenate([parts[0], parts[1][1:]])
    return encode_srgb(xyz_to_linear_srgb(lab_to_xyz(lab), 1.0))


def difference_bytes(change: NDArray[np.float64], scale: Scale) -> NDArray[np.uint8]:
    """(n, 3) colours of differences."""
    colours = difference_colours()
    index = np.rint(np.clip(scale.share(change), 0.0, 1.0) * (len(colours) - 1)).astype(np.int64)
    return to_bytes(colours[index])
