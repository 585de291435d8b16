"""Exchange areas between row elements when nothing stands between, from form factors of all pairs of their cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from hradiosity.errors import Fault, SceneError
from hradiosity.model.geometry import BACK, Patches
from hradiosity.space.bvh import Bvh
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import Elements
from hradiosity.space.shafts import UNKNOWN, EmitterShapes, Receivers, prove_sight
from hradiosity.transport.facing import FacingCells
from hradiosity.transport.form_factor.methods import Settings, pair_exchange
from hradiosity.transport.form_factor.pairs import Pairs
from hradiosity.transport.form_factor.polygons import polygon_set

METHOD_SETTINGS: Final[Mapping[str, Settings]] = MappingProxyType(
    {
        "auto": Settings(method="auto", tolerance=1e-3),
        "contour": Settings(method="contour", tolerance=1e-6),
        "hemisphere": Settings(method="hemisphere", tolerance=1e-3),
        "quasi-hemisphere": Settings(method="quasi-hemisphere", samples=2, resolution=8),
        "monte-carlo": Settings(method="monte-carlo", samples=64),
        "point": Settings(method="point"),
        "point-disk": Settings(method="point-disk"),
    }
)
"""How each method is used on pairs of cells: millions of them, whose errors average out in a row."""
RANDOM: Final = ("monte-carlo",)
"""Methods that give other numbers in each replicate."""
BYTES_A_PAIR: Final = 160
MOST_BYTES: Final = 2**32
"""Of all that is held for pairs."""
RAYS_OF_A_PAIR: Final[Mapping[str, float]] = MappingProxyType(
    {
        "auto": 2.0,
        "contour": 8.0,
        "hemisphere": 95.0,
        "quasi-hemisphere": 24.0,
        "monte-carlo": 25.0,
        "point": 1.0,
        "point-disk": 1.0,
    }
)
"""Exchange rays that take as long as the form factor of a pair, as measured in the Cornell box and the two rooms."""
BATCH_PAIRS: Final = 2**20
"""Pairs on the device at a time."""
FLAT: Final = 2.0**-20
"""Height over a plane, in half extents of the scene, that counts as none."""


def pair_bytes(n_pairs: int) -> int:
    """Memory that so many pairs may need."""
    return n_pairs * BYTES_A_PAIR


def check_pairs(n_pairs: int, n_elements: int, method: str) -> None:
    """`SceneError` when there are too many pairs, of cells that face each other or of elements."""
    needed = pair_bytes(n_pairs)
    if needed <= MOST_BYTES:
        return
    # Pairs grow with the square of the elements; a tenth is left for borders.
    asked = max(int(0.9 * n_elements * np.sqrt(MOST_BYTES / needed)), 1)
    found = f"{method} would hold {n_pairs / 1e6:.3g} million pairs for {n_elements} elements, {needed:.3g} bytes"
    most = f"{most_pairs() / 1e6:.3g} million pairs, {MOST_BYTES:.3g} bytes, or less"
    remedy = f"--elements {asked}, or a larger --element-size where the mean free path forbids so few; or rays"
    raise SceneError([Fault("command line", "--form-factors", found, f"{most}: {remedy}")])


def most_pairs() -> int:
    """Pairs that fit."""
    return MOST_BYTES // BYTES_A_PAIR


@dataclass(frozen=True)
class RowPairs:
    """Pairs of row elements that may see each other, and their exchange when nothing stands between.

    first, second : (n,) int64, first <= second; a group of cells may see itself
    exchange, error : (n,) float64 [m²], K of the pair with the method's estimate of its error
    proved : (n,) bool, nothing stands between any two points of both
    n_cell_pairs : number of pairs of cells that these are made of
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    exchange: NDArray[np.float64]
    error: NDArray[np.float64]
    proved: NDArray[np.bool_]
    n_cell_pairs: int


class CellPairs:
    """All pairs of cells of one lit space that face each other.

    Parameters
    ----------
    bvh : Bvh
    patches : Patches
    elements : Elements
    space : (n_rows,) int
        Lit space that each row element looks into: none exchanges light with another space.
    """

    def __init__(self, bvh: Bvh, patches: Patches, elements: Elements, space: NDArray[np.integer]) -> None:
        self._bvh, self._elements = bvh, elements
        self._corners, is_triangle = cell_corners(patches, elements)
        side = elements.cell_side.astype(np.int64)
        self._patch = side // 2
        self._normal = patches.normal[self._patch] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
        polygons = polygon_set(self._corners, np.where(is_triangle, 3, 4), [""] * len(side))
        self._polygons = polygons
        of_cell = space[elements.cell_row.astype(np.int64)]
        self._facing = FacingCells(self._corners - bvh.local_origin, self._normal, of_cell, FLAT * bvh.scale)

    def count(self) -> int:
        """Number of pairs, without holding them."""
        return self._facing.count()

    @cached_property
    def _pairs(self) -> Pairs:
        """The smaller cell first."""
        one, other = self._facing.pairs()
        swap = self._polygons.area[one] > self._polygons.area[other]
        first, second = np.where(swap, other, one), np.where(swap, one, other)
        return Pairs(self._polygons, first, second, self._bvh.device)

    def __len__(self) -> int:
        return len(self._pairs)

    def by_rows(self, method: str, seed: int, proved: NDArray[np.bool_]) -> RowPairs:
        """Exchange of the row elements by a method of `METHOD_SETTINGS`; `proved` (n,) is of the pairs of cells."""
        settings = replace(METHOD_SETTINGS[method], seed=seed)
        exchange, error = np.zeros(len(self)), np.zeros(len(self))
        for low in range(0, len(self), BATCH_PAIRS):
            part = slice(low, low + BATCH_PAIRS)
            chosen = self._pairs.with_pairs(self._pairs.first[part], self._pairs.second[part])
            estimate, _ = pair_exchange(chosen, settings)
            exchange[part] = estimate.exchange
            # No more than all that the smaller one has.
            error[part] = np.minimum(estimate.error, self._pairs.polygons.area[self._pairs.first[part]])
        n_rows = len(self._elements)
        row = self._elements.cell_row.astype(np.int64)
        one, other = row[self._pairs.first], row[self._pairs.second]
        seen = exchange > 0.0
        # A group's exchange with itself counts in both directions.
        twice = np.where(one == other, 2.0, 1.0)
        index = (np.minimum(one, other) * n_rows + np.maximum(one, other))[seen]
        pair, which = np.unique(index, return_inverse=True)
        n = len(pair)

        def summed(values: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.bincount(which, weights=(twice * values)[seen], minlength=n).astype(np.float64)

        return RowPairs(
            first=pair // max(n_rows, 1),
            second=pair % max(n_rows, 1),
            exchange=summed(exchange),
            error=summed(error),
            proved=np.bincount(which, weights=~proved[seen], minlength=n) == 0,
            n_cell_pairs=len(self),
        )

    def prove(self, reach: float) -> NDArray[np.bool_]:
        """(n,) between which cells shafts prove that nothing stands; not tried where they are farther than `reach`."""
        everywhere = np.zeros(len(self._patch), bool)
        receivers = Receivers(self._corners, self._normal, self._patch)
        emitters = EmitterShapes(self._corners, self._normal, self._patch, everywhere)
        pairs = self._pairs
        sight = prove_sight(self._bvh, receivers, emitters, pairs.first, pairs.second, reach=reach)
        proved: NDArray[np.bool_] = sight != UNKNOWN
        return proved


def symmetric(pairs: RowPairs, exchange: NDArray[np.float64], n_rows: int) -> csr_array:
    """(n_rows, n_rows) CSR of exchange areas (n,) of pairs; pairs without any are left out."""
    seen = exchange > 0.0
    first, second, value = pairs.first[seen], pairs.second[seen], exchange[seen]
    apart = first != second
    ends = (np.concatenate([first, second[apart]]), np.concatenate([second, first[apart]]))
    matrix = csr_array((np.concatenate([value, value[apart]]), ends), shape=(n_rows, n_rows))
    matrix.sort_indices()
    return matrix
