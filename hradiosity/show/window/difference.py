"""Two results of one room: their difference, on a scale that is even to both sides of 0."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.drawn_scene import Cells, Drawn
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb
from hradiosity.show.colormap import SIZE, lab_to_xyz
from hradiosity.show.exposure import to_bytes
from hradiosity.show.scale_bar import TOPS, Scale, round_up
from hradiosity.show.window.colours import LightValues
from hradiosity.show.window.locating import Located, locate, middles, values_inside
from hradiosity.show.window.look import NO_LINES, Look, Quantity
from hradiosity.show.window.outlines import hierarchy_levels

if TYPE_CHECKING:
    from hradiosity.show.window.subject import Subject

SAME_PLACE: Final = 1e-9
"""Corners of two results may differ by so much, over the size of the scene."""
SAME_FACING: Final = 1e-3
"""Of unit normals."""
CANDIDATES: Final = (8, 64)
"""Cells of the other mesh that are tried for a point, the nearest first."""
MARGIN: Final = 1e-3
"""Of an edge: cells of two meshes may end a little beside each other."""
MOST_LOST: Final = 0.5
"""Of the area, that may have no counterpart: more is another room."""
ROUNDING: Final = 1e-9
"""Differences below this share of the largest value are none."""
_LOST: Final = np.array([96, 96, 100], np.uint8)
"""Where one of the results has no surface."""
_LESS: Final = np.array([[28.0, 4.0, -38.0], [55.0, -6.0, -34.0], [78.0, -8.0, -18.0], [95.0, 0.0, 0.0]])
"""CIE L*, a*, b* from dark blue to near white: told apart from `_MORE` without red and green."""
_MORE: Final = np.array([[95.0, 0.0, 0.0], [80.0, 12.0, 36.0], [58.0, 30.0, 50.0], [32.0, 34.0, 38.0]])
"""From near white over orange to brown."""


class Comparison:
    """Second − first, at the cells of the one that has more of them.

    Where both have the same elements, values of elements are compared. Else the light of both, smooth inside of their
    surfaces, is compared in the middle of each cell: steps from element to element would show up where they differ.

    Parameters
    ----------
    first, second : Subject
    names : (str, str)

    Raises
    ------
    SceneError
        When one is a scene, or less than half of the area of the surfaces is in both.
    """

    def __init__(self, first: Subject, second: Subject, names: tuple[str, str]) -> None:
        if first.values is None or second.values is None:
            raise _not_comparable(names, "one of them is a scene", "two results")
        self._pair = first.values, second.values
        self._drawn = first.drawn, second.drawn
        self.same_mesh = _same_cells(first.cells, second.cells)
        self.base = 0 if self.same_mesh or len(first.cells) >= len(second.cells) else 1
        cells, other = self._drawn[self.base].cells, self._drawn[1 - self.base].cells
        self.lost: NDArray[np.bool_] = np.zeros(len(cells), np.bool_)
        if not self.same_mesh:
            points, self._own = middles(cells)
            self._place = _counterparts(cells, other, points)
            self.lost = self._place.cell < 0
            self._check_overlap(names)

    @property
    def shown(self) -> LightValues:
        """Of the result whose cells are drawn."""
        return self._pair[self.base]

    @property
    def cells(self) -> Cells:
        """That are drawn."""
        return self._drawn[self.base].cells

    @property
    def lost_share(self) -> float:
        """Of the area, that one of the results lacks."""
        area = self.cells.area
        return float(area[self.lost].sum() / max(float(area.sum()), 1e-300))

    @property
    def words(self) -> str:
        """What is shown, for the legend."""
        return "second − first" if self.same_mesh else "second − first, smooth"

    def values(self, quantity: Quantity) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n,) of the first and of the second result [lx] or [cd m⁻²]; NaN where one has no surface."""
        if self.same_mesh:
            return self._pair[0].flat.of(quantity), self._pair[1].flat.of(quantity)
        own = _smooth_at(self._drawn[self.base], self.shown, self._own, quantity)
        other = np.full(len(own), np.nan)
        met = np.flatnonzero(~self.lost)
        place = self._place.of(met)
        other[met] = _smooth_at(self._drawn[1 - self.base], self._pair[1 - self.base], place, quantity)
        own[self.lost] = np.nan
        return (own, other) if self.base == 0 else (other, own)

    def summary(self, quantity: Quantity) -> Summary:
        """Of all surfaces that do not shine, by area."""
        first, second = self.values(quantity)
        area = np.where(self.shown.shining | self.lost, 0.0, self.cells.area)
        share = area / max(float(area.sum()), 1e-300)
        used = share > 0.0
        change = second[used] - first[used]
        largest = float(np.abs(first[used]).max(initial=0.0))
        return Summary(
            mean=float(share[used] @ change),
            rms=float(np.sqrt(share[used] @ change**2)),
            level=float(share[used] @ first[used]),
            equal=float(np.abs(second - first)[~self.lost].max(initial=0.0)) <= ROUNDING * largest,
        )

    def _check_overlap(self, names: tuple[str, str]) -> None:
        if self.lost_share > MOST_LOST:
            found = f"their surfaces lie elsewhere: {100.0 * (1.0 - self.lost_share):.0f} % of the area is in both"
            raise _not_comparable(names, f"{found}, so no difference can be shown", "two results of one room")


@dataclass(frozen=True)
class Summary:
    """Mean and rms of a difference and mean of the first result [lx] or [cd m⁻²]; whether both are equal."""

    mean: float
    rms: float
    level: float
    equal: bool


def _not_comparable(names: tuple[str, str], found: str, expected: str) -> SceneError:
    return SceneError([Fault(f"{names[0]}, {names[1]}", "", found, expected)])


def _same_cells(a: Cells, b: Cells) -> bool:
    if len(a) != len(b) or not np.array_equal(a.element, b.element):
        return False
    size = max(float(np.abs(a.corners).max(initial=0.0)), 1e-30)
    return bool(np.abs(a.corners - b.corners).max(initial=0.0) <= SAME_PLACE * size)


def _counterparts(cells: Cells, other: Cells, points: NDArray[np.float64]) -> Located:
    """Where the middles (n, 3) of cells lie in the other mesh: on a cell that faces the same way."""
    facing = np.round(np.concatenate([cells.normal, other.normal]) / SAME_FACING).astype(np.int64)
    kind = np.unique(facing, axis=0, return_inverse=True)[1].reshape(-1)
    own, theirs = kind[: len(cells)], kind[len(cells) :]
    found = locate(other, theirs, points, own, CANDIDATES[0], MARGIN)
    for candidates in CANDIDATES[1:]:
        left = np.flatnonzero(found.cell < 0)
        if not len(left):
            break
        more = locate(other, theirs, points[left], own[left], candidates, MARGIN)
        for column, new in zip(found, more, strict=True):
            column[left] = new
    return found


def _smooth_at(drawn: Drawn, values: LightValues, place: Located, quantity: Quantity) -> NDArray[np.float64]:
    return values_inside(drawn.cells, values.smooth.of(quantity)[..., None], place)[:, 0]


def difference_scale(change: NDArray[np.float64], dull: NDArray[np.bool_], quantity: Quantity) -> Scale:
    """Even to both sides, holding all but the largest hundredth of what does not shine."""
    seen = np.abs(change[dull & np.isfinite(change)])
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
    """(n, 3) colours of differences; grey where there is none."""
    colours, known = difference_colours(), np.isfinite(change)
    share = np.clip(scale.share(np.where(known, change, 0.0)), 0.0, 1.0)
    painted = to_bytes(colours[np.rint(share * (len(colours) - 1)).astype(np.int64)])
    painted[~known] = _LOST
    return painted


@dataclass(frozen=True)
class PaintedDifference:
    """colours : (n, 3) uint8, of the cells that are drawn; look : with outlines."""

    colours: NDArray[np.uint8]
    scale: Scale
    summary: Summary
    look: Look


def painted_difference(comparison: Comparison, look: Look) -> PaintedDifference:
    """A difference as a look says, with outlines of patches at least: where nothing differs, all is white."""
    quantity = look.quantity
    first, second = comparison.values(quantity)
    summary = comparison.summary(quantity)
    change = np.where(comparison.lost, np.nan, 0.0) if summary.equal else second - first
    scale = difference_scale(change, ~comparison.shown.shining, quantity)
    end = scale.high * 2.0**-look.stops
    if look.lines == NO_LINES:
        look = replace(look, lines=hierarchy_levels(comparison.cells))
    scale = replace(scale, low=-end, high=end)
    return PaintedDifference(difference_bytes(change, scale), scale, summary, look)
