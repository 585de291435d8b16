"""How far a solution is from one, in the same measure for every solver."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_dot, column_ratio
from hradiosity.solvers.result import Columns

LOCAL_SHARE = 0.1
"""Weight of the elements' own relative residuals beside the residual of the whole."""
CHUNK = 64
"""Rows that are summed one after the other; many chunks keep all compute units busy."""
TINY = np.finfo(np.float64).tiny


class Sets:
    """Sums and maxima over sets of connected elements, (n_rows,) numbers from 0.

    Attributes
    ----------
    order : (n_rows,) int64
        Rows, set after set.
    chunk_start : (n_chunks + 1,) int64
        Where chunks of at most `CHUNK` rows of one set begin in that order.
    """

    def __init__(self, component: NDArray[np.int32]) -> None:
        self._component = component
        self.order: NDArray[np.int64] = np.argsort(component, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(component, minlength=1))])
        self._rows = np.split(self.order, starts[1:-1])
        first = np.arange(len(component)) - starts[component[self.order]]
        self.chunk_start: NDArray[np.int64] = np.append(np.flatnonzero(first % CHUNK == 0), len(component))
        self._first_chunk = np.searchsorted(self.chunk_start, starts[:-1])

    def norms(self, x: Columns) -> NDArray[np.float64]:
        """Euclidean norm of each set and column, (n_sets, n_columns)."""
        return np.sqrt(self.dots(x, x))

    def dots(self, x: Columns, y: Columns) -> NDArray[np.float64]:
        """Product of each set and column, (n_sets, n_columns)."""
        if len(self._rows) == 1:
            return column_dot(x, y)[None]
        return np.array([column_dot(x[rows], y[rows]) for rows in self._rows])

    def of_chunks(self, sums: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sums over each set, (n_sets, n_columns), of those over chunks, (n_chunks, n_columns)."""
        totals: NDArray[np.float64] = np.add.reduceat(sums, self._first_chunk, axis=0)
        return totals

    def largest(self, x: Columns) -> Columns:
        """Largest |x| in each row's set, (n_rows, n_columns); (1, n_columns) if all are one set."""
        size = np.array([np.abs(x[rows]).max(axis=0, initial=0.0) for rows in self._rows])
        found: Columns = size if len(size) == 1 else size[self._component]
        return found


class Measure:
    """How far a solution is from one, as the largest over columns of two ratios.

    One is the norm of the residual over that of the right-hand side, in each set of connected elements. It says nothing
    about a dim room behind a gap, whose light is all below the tolerance; so the other is the rms over elements, by
    area, of residual over own light, which may be ten times larger. A thousand elements, evenly picked, stand for all.

    Parameters
    ----------
    sets : Sets
    rhs, emitted : (n_rows, n_columns)
        R½ S R½ b and b = A½ R½ D.
    area : (n_rows,)

    Attributes
    ----------
    every : int
        One of so many elements is picked.
    """

    def __init__(self, sets: Sets, rhs: Columns, emitted: Columns, area: NDArray[np.floating]) -> None:
        self._sets = sets
        self._size = sets.norms(rhs)
        self.every = max(1, len(area) // 1024)
        self._emitted = emitted[:: self.every]
        picked_area = area[:: self.every].astype(np.float64)
        self._share = picked_area / max(float(picked_area.sum()), TINY)

    def __call__(self, residual: Columns, solution: Columns) -> float:
        """Of a residual of (I − R½ S R½) w = R½ S R½ b and its solution w = A½ R½ (E − D)."""
        return self.of_picked(
            np.sqrt(self._sets.dots(residual, residual)), residual[:: self.every], solution[:: self.every]
        )

    def of_picked(self, norms: NDArray[np.float64], residual: Columns, solution: Columns) -> float:
        """The same from the residual's norms in each set, and every so many rows of both."""
        size = np.abs(residual)
        level = np.abs(solution) + self._emitted + size
        own = np.divide(size, level, out=np.zeros_like(size), where=level > 0.0)
        local = np.sqrt(np.einsum("r,rc,rc->c", self._share, own, own))
        everywhere = column_ratio(norms, self._size)
        return max(float(everywhere.max(initial=0.0)), LOCAL_SHARE * float(local.max(initial=0.0)))
