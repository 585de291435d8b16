"""The exchange between row elements as a linear operator on all columns at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.solvers.result import Columns
from hradiosity.transport.exchange import Exchange

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class ExchangeOperator:
    """S = A^-1/2 K A^-1/2, symmetric, with values in [−1, 1]; applied to (n_rows, 8 n) arrays, n groups of eight
    columns.

    Elements whose exposed area is 0 take no part.

    Parameters
    ----------
    device : Device
    exchange : Exchange
    dtype : float32 or float64
        Precision of all columns. In float64 products are made on the host; that is for referees and measurements.

    Attributes
    ----------
    linked : (n_rows,) bool
        Whether an element exchanges light with any.
    component : (n_rows,) int32
        Number of the set of connected elements that each belongs to; elements without any link are in set 0.
    """

    def __init__(self, device: Device, exchange: Exchange, dtype: type[np.floating[Any]] = np.float32) -> None:
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import connected_components

        area = exchange.element_area
        self.dtype = dtype
        self.root_area: Columns = np.sqrt(area).astype(dtype)
        self.inverse_root_area: Columns = np.divide(1.0, np.sqrt(area), out=np.zeros_like(area), where=area > 0).astype(
            dtype
        )
        receiver = np.repeat(np.arange(len(area)), np.diff(exchange.start).astype(np.int64))
        value = exchange.area * self.inverse_root_area[receiver] * self.inverse_root_area[exchange.source]
        self._host = csr_array(
            (value, exchange.source.astype(np.int64), exchange.start.astype(np.int64)), shape=(len(area), len(area))
        )
        self.linked: NDArray[np.bool_] = np.diff(exchange.start) > 0
        label = connected_components(self._host, directed=False)[1]
        self.component: NDArray[np.int32] = np.zeros(len(area), np.int32)
        self.component[self.linked] = np.unique(label[self.linked], return_inverse=True)[1]
        self.device = device
        self.links: dict[str, DeviceArray] = {
            "link_start": device.upload(exchange.start),
            "link_source": device.upload(exchange.source),
            "link_value": device.upload(value, dtype),
        }
        self.n_rows = len(area)
        self.products = 0

    def apply(self, columns: Columns) -> Columns:
        """S times the columns, (n_rows, 8 n)."""
        self.products += 1
        if self.dtype is np.float64:
            on_host: Columns = self._host @ np.asarray(columns, np.float64)
            return on_host
        product = self.device.empty(columns.shape, np.float32)
        self._multiply(self.device.upload(columns, np.float32), product)
        fetched: Columns = self.device.fetch(product)
        return fetched

    def multiply(self, columns: DeviceArray, product: DeviceArray) -> None:
        """S times the columns, (n_rows, 8 n) float32, both on the device."""
        self.products += 1
        self._multiply(columns, product)

    def _multiply(self, columns: DeviceArray, product: DeviceArray) -> None:
        self.device.kernel("columns", "apply_links", HR_GROUPS=columns.shape[1] // 8)(
            self.n_rows, **self.links, columns=columns, product=product
        )

    def rows(self, numbers: NDArray[np.int64]) -> csr_array:
        """Some rows of S, (k, n_rows) float64."""
        from scipy.sparse import csr_array

        return csr_array(self._host[numbers])

    def dense(self) -> NDArray[np.float64]:
        """S, (n_rows, n_rows) float64."""
        matrix: NDArray[np.float64] = self._host.toarray()
        return matrix

    def apply_vector(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """S times one vector (n_rows,) in float64, on the host."""
        product: NDArray[np.float64] = self._host @ vector
        return product
