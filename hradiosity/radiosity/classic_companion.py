"""The same replicate of the classic mode on patches and elements of twice the size, by the hemicubes that there are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from hradiosity.radiosity.shooting import ShootingRows, over_area
from hradiosity.solvers.southwell import ShootingSystem

WEIGHT: Final = 1.4
"""Times the change by patches of twice the size that stands for what smaller ones would still change: errors fall with
the edge to the power 0.8, about. Chosen on one half of the scenes of `hradiosity.suites.coverage`, where 93 % of the
intervals then hold; 96 % do on the other half."""
BATCH: Final = 256
"""Coarse patches whose parts' rows are joined at a time."""


@dataclass(frozen=True)
class ClassicCompanion:
    """Patches and elements of twice the size.

    patch : (n_patches,) int64, coarser patch of each, see `hradiosity.space.companion.coarser_rows`
    row : (n_rows,) int64, coarser element of each
    """

    patch: NDArray[np.int64]
    row: NDArray[np.int64]

    def system(self, fine: ShootingSystem, rows: ShootingRows) -> ShootingSystem:
        """What the coarser patches shoot: the parts' hemicubes together, with one exitance.

        A few rows that the fine patches did without are drawn.
        """
        n = int(self.patch.max(initial=-1)) + 1
        area = np.bincount(self.patch, fine.area, n).astype(np.float64)
        first = np.zeros(n, np.int64)
        first[self.patch[::-1]] = np.arange(len(self.patch))[::-1]
        reflectance = fine.reflectance[first]
        exchange = self._exchange(rows, n, reflectance.any(axis=1) & (area > 0.0))
        return ShootingSystem(
            area=area,
            reflectance=reflectance,
            direct=means(self.patch, fine.area, fine.direct, n),
            rows=lambda chosen: csr_array(exchange[chosen]),
        )

    def change(
        self, irradiance: NDArray[np.float64], coarse: NDArray[np.float64], area: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(n_rows, n_columns) irradiance of the coarser element that each is part of, less its own, times `WEIGHT`.

        Parameters
        ----------
        irradiance : (n_rows, n_columns) float64
            Of the elements.
        coarse : (n_rows, n_columns) float64
            The same when the coarser patches have shot, before it is averaged over the coarser elements.
        area : (n_rows,) float64
            Exposed area [m²].
        """
        n = int(self.row.max(initial=-1)) + 1
        found = means(self.row, area, coarse, n)[self.row] - irradiance
        return np.where(area[:, None] > 0.0, WEIGHT * found, 0.0)

    def _exchange(self, rows: ShootingRows, n: int, shoots: NDArray[np.bool_]) -> csr_array:
        """(n, n) exchange areas of the coarser patches; empty rows where nothing is reflected."""
        from scipy.sparse import vstack

        joins = csr_array((np.ones(len(self.patch)), (np.arange(len(self.patch)), self.patch)), (len(self.patch), n))
        parts = []
        for start in range(0, n, BATCH):
            stop = min(start + BATCH, n)
            inside = np.flatnonzero((self.patch >= start) & (self.patch < stop) & shoots[self.patch])
            into = self.patch[inside] - start
            sums = csr_array((np.ones(len(inside)), (into, np.arange(len(inside)))), (stop - start, len(inside)))
            parts.append(sums @ rows(inside) @ joins)
        return csr_array(vstack(parts, format="csr") if parts else (n, n))


def means(
    group: NDArray[np.int64], area: NDArray[np.float64], values: NDArray[np.float64], n_groups: int
) -> NDArray[np.float64]:
    """(n_groups, n_columns) means of values (n, n_columns) over the members of each group, by area (n,)."""
    total = np.zeros((n_groups, values.shape[1]))
    np.add.at(total, group, area[:, None] * values)
    return over_area(total, np.bincount(group, area, n_groups).astype(np.float64))
