"""Pairs of cells that face each other, block by block: only those can exchange light."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

BLOCK: Final = 2**20
"""Pairs of cells that are looked at at a time."""


COUNTED: Final = 8192
"""Cells whose pairs are counted in a second or so; more would have hundreds of millions of pairs, and never fit."""


class FacingCells:
    """Cells of the lit spaces, any two of which face each other if each has a corner before the plane of the other.

    Parameters
    ----------
    corners : (n, 4, 3) float64 [m]
    normal : (n, 3) float64, unit
    space : (n,) int
        Cells of two spaces never face each other.
    flat : float
        Height over a plane that counts as none [m].
    """

    def __init__(
        self, corners: NDArray[np.float64], normal: NDArray[np.float64], space: NDArray[np.integer], flat: float
    ) -> None:
        self._corners, self._normal, self._space, self._flat = corners, normal, space, flat
        self._own = np.einsum("nd,nd->n", normal, corners[:, 0]) + flat

    def count(self) -> int:
        """Number of pairs; of more than `COUNTED` cells, from every k-th of them."""
        step = -(-len(self._normal) // COUNTED)
        if step > 1:
            some = FacingCells(self._corners[::step], self._normal[::step], self._space[::step], self._flat)
            return round(some.count() * (len(self._normal) / len(some._normal)) ** 2)
        return sum(int(np.count_nonzero(faces)) for _, faces in self._blocks())

    def pairs(self) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """All of them, i < j."""
        one, other = [np.zeros(0, np.uint32)], [np.zeros(0, np.uint32)]
        for low, faces in self._blocks():
            i, j = np.nonzero(faces)
            one.append((i + low).astype(np.uint32))
            other.append((j + low).astype(np.uint32))
        return np.concatenate(one), np.concatenate(other)

    def _blocks(self) -> Iterator[tuple[int, NDArray[np.bool_]]]:
        """First cell of some, and which of those (m, n − first) face which of the cells from there on."""
        n = len(self._normal)
        step = max(1, BLOCK // max(n, 1))
        for low in range(0, n, step):
            part, rest = slice(low, low + step), slice(low, n)
            m = len(self._normal[part])
            over_part = (self._normal[part] @ self._corners[rest].reshape(-1, 3).T).reshape(m, n - low, 4)
            over_rest = (self._corners[part].reshape(-1, 3) @ self._normal[rest].T).reshape(m, 4, n - low)
            faces = over_part.max(axis=2) > self._own[part, None]
            faces &= over_rest.max(axis=1) > self._own[None, rest]
            faces &= self._space[part, None] == self._space[None, rest]
            yield low, np.triu(faces, k=1)
