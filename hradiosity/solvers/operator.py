"""The exchange between row elements as a linear operator on all columns at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from hradiosity.device import Device
from hradiosity.transport.exchange import Exchange


class ExchangeOperator:
    """S = A^-1/2 K A^-1/2, symmetric, with values in [−1, 1]; applied to (n_rows, 8 n) float32 arrays, n groups of
    eight columns.

    Elements whose exposed area is 0 take no part.

    Parameters
    ----------
    device : Device
    exchange : Exchange

    Attributes
    ----------
    component : (n_rows,) int32
        Number of the set of connected elements that each belongs to; elements without any link are in set 0.
    """

    def __init__(self, device: Device, exchange: Exchange) -> None:
        area = exchange.element_area
        self.root_area: NDArray[np.float32] = np.sqrt(area).astype(np.float32)
        self.inverse_root_area: NDArray[np.float32] = np.divide(
            1.0, np.sqrt(area), out=np.zeros_like(area), where=area > 0
        ).astype(np.float32)
        receiver = np.repeat(np.arange(len(area)), np.diff(exchange.start).astype(np.int64))
        value = exchange.area * self.inverse_root_area[receiver] * self.inverse_root_area[exchange.source]
        self._host = csr_array(
            (value, exchange.source.astype(np.int64), exchange.start.astype(np.int64)), shape=(len(area), len(area))
        )
        linked = np.diff(exchange.start) > 0
        label = connected_components(self._host, directed=False)[1]
        self.component: NDArray[np.int32] = np.zeros(len(area), np.int32)
        self.component[linked] = np.unique(label[linked], return_inverse=True)[1]
        self._device = device
        self._start = device.upload(exchange.start)
        self._source = device.upload(exchange.source)
        self._value = device.upload(value, np.float32)
        self.n_rows = len(area)
        self.products = 0

    def apply(self, columns: NDArray[np.float32]) -> NDArray[np.float32]:
        """S times the columns, (n_rows, 8 n) float32."""
        product = self._device.empty(columns.shape, np.float32)
        self._device.kernel("columns", "apply_links", HR_GROUPS=columns.shape[1] // 8)(
            self.n_rows,
            link_start=self._start,
            link_source=self._source,
            link_value=self._value,
            columns=self._device.upload(columns, np.float32),
            product=product,
        )
        self.products += 1
        fetched: NDArray[np.float32] = self._device.fetch(product)
        return fetched

    def apply_vector(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """S times one vector (n_rows,) in float64, on the host."""
        product: NDArray[np.float64] = self._host @ vector
        return product
