"""The same replicate on elements of twice the size, or with half of its rays: what settings still change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.radiosity.row_light import RowLight, light_of_glow
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.transport.exchange import Exchange, RowHits


class Companion:
    """Coarser rows, each made of some fine ones, with the exposed areas of one replicate.

    Parameters
    ----------
    parent : (n_rows,) int64
        Coarser row of each row, see `hradiosity.space.companion.coarser_rows`.
    element_area : (n_rows,) float64
        Exposed area of each row [m²].
    """

    def __init__(self, parent: NDArray[np.int64], element_area: NDArray[np.float64]) -> None:
        from scipy.sparse import csr_array

        n_rows, n_coarse = len(parent), int(parent.max(initial=-1)) + 1
        self._parent = parent
        self._area = element_area
        self._coarse_area = np.bincount(parent, element_area, n_coarse).astype(np.float64)
        self._first = np.zeros(n_coarse, np.int64)
        self._first[parent[::-1]] = np.arange(n_rows)[::-1]
        self._joins = csr_array((np.ones(n_rows), (parent, np.arange(n_rows))), shape=(n_coarse, n_rows))

    def light(
        self,
        device: Device,
        exchange: Exchange,
        solver: RowLight,
        reflectance: NDArray[np.float32],
        direct: NDArray[np.float32],
        row_glow: NDArray[np.float32],
        irradiance: NDArray[np.float32],
        deflation: NDArray[np.float64] | None,
    ) -> NDArray[np.float32]:
        """(n_rows, 8 n_groups) irradiance of the coarser row that each row is part of.

        Parameters
        ----------
        exchange : Exchange
            Between the fine rows, closed; the sums of its entries close as well.
        reflectance, direct, row_glow : (n_rows, 8 n_groups) float32
            The same paint throughout each coarser row.
        irradiance : (n_rows, 8 n_groups) float32
            Of the fine rows, from where the iteration starts.
        deflation : (n_rows, k) float64, optional
        """
        operator = ExchangeOperator(device, self._exchange(exchange))
        coarse_direct = self._mean(direct)
        glow = light_of_glow(operator, row_glow[self._first])
        lit = coarse_direct + glow
        if solver.plan.interreflection:
            lit = solver.solve(
                operator,
                reflectance[self._first],
                lit,
                self._mean(irradiance) - lit,
                None if deflation is None else self._vectors(deflation),
            )[0]
        return np.asarray(lit[self._parent])

    def _exchange(self, fine: Exchange) -> Exchange:
        from scipy.sparse import csr_array

        n_rows = len(self._parent)
        links = csr_array((fine.area, fine.source.astype(np.int64), fine.start.astype(np.int64)), (n_rows, n_rows))
        joined = csr_array(self._joins @ links @ self._joins.T)
        joined.sort_indices()
        return replace(
            fine,
            outside=self._joins @ fine.outside,
            sky=self._joins @ fine.sky,
            element_area=self._coarse_area,
            start=joined.indptr.astype(np.uint32),
            source=joined.indices.astype(np.uint32),
            area=joined.data,
        )

    def _mean(self, columns: NDArray[np.float32]) -> NDArray[np.float32]:
        """Means over the parts of each coarser row, by exposed area."""
        weight = np.divide(
            self._area,
            self._coarse_area[self._parent],
            out=np.zeros_like(self._area),
            where=self._coarse_area[self._parent] > 0.0,
        )
        mean: NDArray[np.float32] = (self._joins @ (weight[:, None] * columns)).astype(np.float32)
        return mean

    def _vectors(self, deflation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Orthonormal vectors of the coarser rows, from those of the fine ones; both are scaled by root areas."""
        if deflation.shape[1] == 0:
            return np.zeros((len(self._coarse_area), 0))
        root = np.sqrt(self._coarse_area)[:, None]
        summed = self._joins @ (np.sqrt(self._area)[:, None] * deflation)
        vectors: NDArray[np.float64] = np.linalg.qr(np.divide(summed, root, out=np.zeros_like(summed), where=root > 0))[
            0
        ]
        return vectors


def half_of(hits: RowHits) -> RowHits:
    """The first half of each row's rays: Sobol points, and thus as even as all of them."""
    half = hits.row.shape[1] // 2
    density = None if hits.density is None else hits.density[:, :half]
    return RowHits(hits.row[:, :half], hits.side[:, :half], hits.on_device, density)
