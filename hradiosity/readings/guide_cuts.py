"""Parts of hemispheres that are cut into blocks, and some of these again; values on them and next to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import ACROSS, SIDE


@dataclass(frozen=True)
class Blocks:
    """Some parts of the square cut into side × side, which are cut into across × across themselves.

    point : (n_blocks,) int64, whose hemisphere each is of
    number : (n_blocks,) int64, which part it is, by rows; ascending for each point, and points too
    """

    side: int
    across: int
    point: NDArray[np.int64]
    number: NDArray[np.int64]

    @classmethod
    def whole(cls, n: int) -> Blocks:
        """The whole square of each of n hemispheres."""
        return cls(1, SIDE, np.arange(n), np.zeros(n, np.int64))

    @classmethod
    def of_keys(cls, side: int, keys: NDArray[np.int64]) -> Blocks:
        """Parts by the numbers that `at` looks for, ascending."""
        return cls(side, ACROSS, *np.divmod(keys, side * side))

    @property
    def finest(self) -> int:
        """Parts along each edge of the square that is cut as fine as the blocks are."""
        return self.side * self.across

    @property
    def y(self) -> NDArray[np.int64]:
        """Row that each is in."""
        return self.number // self.side

    @property
    def x(self) -> NDArray[np.int64]:
        """Column that each is in."""
        return self.number % self.side

    def at(self, point: NDArray[np.int64], y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.int64]:
        """Block that a part is, or −1."""
        keys = self.point * self.side**2 + self.number
        if not len(keys):
            return np.full(point.shape, -1, np.int64)
        wanted = point * self.side**2 + y * self.side + x
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[place] == wanted, place, -1)

    def around(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Point, y and x of the parts of each block and of those next to it, (n_blocks, across + 2, across + 2) each.

        They are counted in the square that is cut as fine; at its rim the last ones stand for what is beyond.
        """
        step = np.arange(-1, self.across + 1)
        y, x = (np.clip(some[:, None] * self.across + step, 0, self.finest - 1) for some in (self.y, self.x))
        point, rows, columns = np.broadcast_arrays(self.point[:, None, None], y[:, :, None], x[:, None, :])
        return point, rows, columns


class Cuts:
    """Which parts of n hemispheres are cut, and which of these again; values of all parts are one array.

    Parameters
    ----------
    blocks : list of Blocks
        The whole squares, then finer and finer parts of them; each level is cut out of the one before.
    """

    def __init__(self, blocks: list[Blocks]) -> None:
        self.blocks = blocks
        sizes = [len(level.point) * level.across**2 for level in blocks]
        self._first = np.concatenate([[0], np.cumsum(sizes)])
        self.near = [
            self._place(number, *np.array(level.around()).reshape(3, -1)).reshape(
                -1, level.across + 2, level.across + 2
            )
            for number, level in enumerate(blocks)
        ]
        """(n_blocks, across + 2, across + 2) for each level: where the values of its parts and their neighbours are."""

    def of_level(self, values: NDArray[np.float64], level: int) -> NDArray[np.float64]:
        """(n_blocks, across, across), a view of the values of a level's parts."""
        across = self.blocks[level].across
        return values[self._first[level] : self._first[level + 1]].reshape(-1, across, across)

    def average(self, values: NDArray[np.float64]) -> None:
        """Put the mean of its parts in place of the value of what is cut, finest first."""
        for level in range(len(self.blocks) - 1, 0, -1):
            some = self.blocks[level]
            place = self._place(level - 1, some.point, some.y, some.x)
            values[place] = self.of_level(values, level).mean(axis=(1, 2))

    def _place(
        self, level: int, point: NDArray[np.int64], y: NDArray[np.int64], x: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Where the values of parts are that are cut as fine as a level's, or of what they belong to."""
        some = self.blocks[level]
        across = some.across
        if level == 0:
            return (point * across + y) * across + x
        block = some.at(point, y // across, x // across)
        inside = self._first[level] + (np.maximum(block, 0) * across + y % across) * across + x % across
        place: NDArray[np.int64] = inside
        outside = block < 0
        place[outside] = self._place(level - 1, point[outside], y[outside] // across, x[outside] // across)
        return place


def blurred(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, k, k) averages with the neighbours by 1, 2, 1 along either edge, of (n, k + 2, k + 2)."""
    rows = values[:, :-2] + 2.0 * values[:, 1:-1] + values[:, 2:]
    both: NDArray[np.float64] = (rows[:, :, :-2] + 2.0 * rows[:, :, 1:-1] + rows[:, :, 2:]) / 16.0
    return both


def spread(high: NDArray[np.float64], low: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, k, k) largest of `high` less the least of `low` among each and its neighbours, of (n, k + 2, k + 2) each."""
    most = np.maximum(np.maximum(high[:, :-2], high[:, 1:-1]), high[:, 2:])
    least = np.minimum(np.minimum(low[:, :-2], low[:, 1:-1]), low[:, 2:])
    most = np.maximum(np.maximum(most[:, :, :-2], most[:, :, 1:-1]), most[:, :, 2:])
    least = np.minimum(np.minimum(least[:, :, :-2], least[:, :, 1:-1]), least[:, :, 2:])
    return most - least
