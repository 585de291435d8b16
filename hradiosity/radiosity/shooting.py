"""Where patches shoot from, and the form-factor rows that they shoot along."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from hradiosity.model.geometry import BACK, Patches
from hradiosity.space.bvh import Bvh
from hradiosity.space.cells import cell_corners
from hradiosity.space.covered import starts_inside
from hradiosity.space.hierarchy import Elements
from hradiosity.transport.form_factor.hemicube import OFFSET, Hemicube, Views

TRIES: Final = 16
"""Random points of a cell that are tried until one lies outside all solids."""
KEPT_BYTES: Final = 1 << 30
"""Views that are kept item by item; the others are drawn once more at the end."""

PAIRED_POINTS: Final = 1024
LEAST_PIXELS: Final = 5.0
"""Of the comparison of a pair's two factors: points that take part, and pixels that either must show."""

_Row: TypeAlias = tuple[NDArray[np.int32], NDArray[np.float32]]
"""Groups, and factors to them."""


@dataclass(frozen=True)
class ShootingPoints:
    """One random point on each of some cells.

    position, normal : (n, 3) float64, world frame [m], unit normals
    patch : (n,) int64
    exposed : (n,) bool, False where all points tried lie inside solids
    angle : (n,) float64, by which the hemicube there is turned [rad]
    """

    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    patch: NDArray[np.int64]
    exposed: NDArray[np.bool_]
    angle: NDArray[np.float64]


def shooting_points(
    bvh: Bvh, patches: Patches, grid: Elements, cells: NDArray[np.int64], rng: np.random.Generator
) -> ShootingPoints:
    """A point on each cell, evenly distributed over the part that no solid covers."""
    corners, is_triangle = cell_corners(patches, grid)
    corners, is_triangle = corners[cells], is_triangle[cells]
    side = grid.cell_side[cells].astype(np.int64)
    patch = side // 2
    normal = patches.normal[patch] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
    position = _random_points(corners, is_triangle, rng)
    solids = bool((patches.solid >= 0).any())
    covered = np.full(len(cells), solids)
    for attempt in range(TRIES if solids else 0):
        left = np.flatnonzero(covered)
        if not len(left):
            break
        if attempt > 0:
            position[left] = _random_points(corners[left], is_triangle[left], rng)
        direction = normal[left] + 0.9 * _unit(rng.standard_normal((len(left), 3)))
        reach = OFFSET * np.maximum(np.abs(position[left] - bvh.local_origin).max(axis=1), bvh.scale)
        start = position[left] + reach[:, None] * normal[left]
        covered[left] = starts_inside(bvh, patches, start, direction, patch[left])
    return ShootingPoints(position, normal, patch, ~covered, rng.random(len(cells)) * 2.0 * np.pi)


class ShootingRows:
    """Exchange areas of shooting points with groups of items, drawn when first asked for.

    Parameters
    ----------
    hemicube : Hemicube
    points : ShootingPoints
    area : (n,) float64
        Exposed area that shoots from each point [m²].
    group : (n_items,) int64
        Group of each item; with substructuring, the patch that an element is a part of.

    Attributes
    ----------
    sky : (n,) float64, share of the sky in the view of each point; NaN where it was not drawn
    lost : (n,) float64, share of the view inside solids or on sides that no light reaches; NaN likewise
    """

    def __init__(
        self, hemicube: Hemicube, points: ShootingPoints, area: NDArray[np.float64], group: NDArray[np.integer]
    ) -> None:
        self.sky = np.full(len(area), np.nan)
        self.lost = np.full(len(area), np.nan)
        self._hemicube, self._points, self._area = hemicube, points, area
        n = len(group)
        self._group = csr_array((np.ones(n, np.float32), (np.arange(n), group)))
        self._rows: dict[int, _Row] = {}
        self._views: list[tuple[NDArray[np.int64], csr_array]] = []
        self._bytes = 0

    def __call__(self, chosen: NDArray[np.int64]) -> csr_array:
        """A_i F_ij of the chosen points i with all groups j, (k, n_groups) CSR [m²]."""
        self._draw(np.array([i for i in chosen if int(i) not in self._rows], np.int64))
        rows = [self._rows[int(i)] for i in chosen]
        length = np.array([len(index) for index, _ in rows], np.int64)
        value = np.concatenate([np.zeros(0), *(factor for _, factor in rows)])
        index = np.concatenate([np.zeros(0, np.int32), *(index for index, _ in rows)])
        start = np.concatenate([[0], np.cumsum(length)])
        shape = (len(chosen), self._group.shape[1])
        return csr_array((value * np.repeat(self._area[chosen], length), index, start), shape=shape)

    def arriving(self, exitance: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_items, n_columns) power that reaches each item when every point has sent out an exitance (n, n_columns).

        Views that were not kept are drawn again; points that send nothing are not drawn at all.
        """
        power = self._area[:, None] * exitance
        kept = np.zeros(len(power), bool)
        total = np.zeros((self._hemicube.n_items, power.shape[1]))
        for points, factor in self._views:
            total += factor.T @ power[points]
            kept[points] = True
        left = np.flatnonzero(~kept & power.any(axis=1))
        for first in range(0, len(left), self._hemicube.batch):
            part = left[first : first + self._hemicube.batch]
            total += self._look(part).factor.T @ power[part]
        return total

    def reciprocity_defect(self) -> float:
        """Rms of |A_i F_ij − A_j F_ji| over the mean of both, for pairs of points that each drew the other.

        The groups must be those that the points shoot from. Pairs that either shows in fewer than about five pixels do
        not count, as their factors are rounded; a thousand points, evenly picked, stand for all.
        """
        drawn = np.array(sorted(self._rows), np.int64)
        drawn = drawn[self._area[drawn] > 0.0][:: max(1, len(drawn) // PAIRED_POINTS)]
        area = self._area[drawn, None]
        there = self(drawn)[:, drawn].toarray()
        often = there > area * LEAST_PIXELS / (3.0 * self._hemicube.resolution**2)
        both = np.triu(often & often.T, k=1)
        if not both.any():
            return 0.0
        here = there.T[both]
        difference = 2.0 * (there[both] - here) / (there[both] + here)
        return float(np.sqrt(np.mean(difference**2)))

    def _draw(self, wanted: NDArray[np.int64]) -> None:
        """Rows of points that were not drawn yet; keeps the items of their views while there is room."""
        if not len(wanted):
            return
        views, hidden = self._look(wanted), ~self._points.exposed[wanted]
        self.sky[wanted] = np.where(hidden, 0.0, views.sky)
        self.lost[wanted] = np.where(hidden, 0.0, views.covered + views.unlit)
        grouped = csr_array(views.factor @ self._group)
        ends = grouped.indptr
        for k, i in enumerate(wanted):
            part = slice(int(ends[k]), int(ends[k + 1]))
            self._rows[int(i)] = (grouped.indices[part], grouped.data[part])
        size = views.factor.data.nbytes + views.factor.indices.nbytes
        if self._bytes + size <= KEPT_BYTES:
            self._views.append((wanted, views.factor))
            self._bytes += size

    def _look(self, wanted: NDArray[np.int64]) -> Views:
        points = self._points
        return self._hemicube.views(
            points.position[wanted], points.normal[wanted], points.angle[wanted], points.patch[wanted]
        )


def over_area(power: NDArray[np.float64], area: NDArray[np.float64]) -> NDArray[np.float64]:
    """Power by area, 0 where there is no area."""
    irradiance: NDArray[np.float64] = np.divide(
        power, area[:, None], out=np.zeros_like(power), where=area[:, None] > 0.0
    )
    return irradiance


def _random_points(
    corners: NDArray[np.float64], is_triangle: NDArray[np.bool_], rng: np.random.Generator
) -> NDArray[np.float64]:
    """(n, 3) points spread evenly over parallelograms and triangles given by (n, 4, 3) corners."""
    share = rng.random((len(corners), 2))
    outside = is_triangle & (share.sum(axis=1) > 1.0)
    share[outside] = 1.0 - share[outside]
    along, across = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    points: NDArray[np.float64] = corners[:, 0] + share[:, :1] * along + share[:, 1:] * across
    return points


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return unit
