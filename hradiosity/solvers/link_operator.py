"""Links at several levels as a linear operator: pull up, exchange at each level, push down."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns
from hradiosity.transport.link_exchange import LinkExchange

MULTILEVEL_SOLVERS = ("cg", "jacobi")
"""Solvers that need nothing but products; others need rows between single elements."""


class LinkOperator(ExchangeOperator):
    """S = A^-1/2 K A^-1/2 of links at several levels (Hanrahan, Salzman & Aupperle 1991), applied in linear time.

    Symmetric, since pushing is the transpose of pulling. Attributes and methods as those of `ExchangeOperator`; `rows`
    and `dense` multiply the levels out.

    Parameters
    ----------
    device : Device
    exchange : LinkExchange
    dtype : float32 or float64
        Precision of all columns; float64 on the host.
    """

    def __init__(self, device: Device, exchange: LinkExchange, dtype: type[np.floating[Any]] = np.float32) -> None:
        nodes, area = exchange.nodes, exchange.element_area
        self._exchange = exchange
        self.device, self.dtype, self.n_rows, self.products = device, dtype, len(area), 0
        root = np.sqrt(area)
        self._inverse_root = np.divide(1.0, root, out=np.zeros_like(area), where=area > 0.0)
        self.root_area = root.astype(dtype)
        self.inverse_root_area = self._inverse_root.astype(dtype)
        self.component = _components(exchange)
        self.linked = area > 0.0
        self._levels = [(int(a), int(b)) for a, b in zip(nodes.level_start[1:-1], nodes.level_start[2:])]
        self._n_nodes = len(nodes)
        own = np.divide(exchange.own, area, out=np.zeros_like(area), where=area > 0.0)
        self._weight = device.upload(exchange.scale * root, np.float32)
        self._own = device.upload(own, np.float32)
        self._parent = device.upload(nodes.parent & 0xFFFFFFFF, np.uint32)
        self._children = {
            "child_start": device.upload(nodes.child_start, np.uint32),
            "child": device.upload(nodes.child, np.uint32),
        }
        self.links = {
            "link_start": device.upload(exchange.start),
            "link_source": device.upload(exchange.source),
            "link_value": device.upload(exchange.value, np.float32),
        }

    def apply(self, columns: Columns) -> Columns:
        """S times the columns, (n_rows, 8 n)."""
        if self.dtype is np.float64:
            self.products += 1
            return self.apply_vector(np.asarray(columns, np.float64))
        return super().apply(columns)

    def _multiply(self, columns: DeviceArray, product: DeviceArray) -> None:
        device, groups = self.device, columns.shape[1] // 8
        pulled, gathered = (device.empty((self._n_nodes, 8 * groups), np.float32) for _ in range(2))
        device.kernel("levels", "pull_rows", HR_GROUPS=groups)(
            self.n_rows * groups, weight=self._weight, columns=columns, pulled=pulled
        )
        for first, last in self._levels:
            device.kernel("levels", "pull_nodes", HR_GROUPS=groups)(
                (last - first) * groups, **self._children, pulled=pulled, first_node=first
            )
        device.kernel("columns", "apply_links", HR_GROUPS=groups)(
            self._n_nodes, **self.links, columns=pulled, product=gathered
        )
        device.kernel("levels", "push_rows", HR_GROUPS=groups)(
            self.n_rows * groups,
            parent=self._parent,
            weight=self._weight,
            own=self._own,
            columns=columns,
            gathered=gathered,
            product=product,
        )

    def rows(self, numbers: NDArray[np.int64]) -> csr_array:
        """Some rows of S, (k, n_rows) float64."""
        return csr_array(csr_array(self.dense())[numbers])

    def dense(self) -> NDArray[np.float64]:
        """S, (n_rows, n_rows) float64."""
        flat = self._exchange.flattened()
        n = self.n_rows
        matrix = csr_array((flat.area, flat.source.astype(np.int64), flat.start.astype(np.int64)), shape=(n, n))
        scaled: NDArray[np.float64] = self._inverse_root[:, None] * matrix.toarray() * self._inverse_root
        return scaled

    def apply_vector(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """S times one vector (n_rows,), or several (n_rows, k), in float64, on the host."""
        exitance = (self._inverse_root * vector.T).T
        product: NDArray[np.float64] = (self._inverse_root * self._exchange.received(exitance).T).T
        return product


def _components(exchange: LinkExchange) -> NDArray[np.int32]:
    """Sets of row elements that links connect; (n_rows,) numbers, 0 for those without any."""
    n_nodes, n_rows = len(exchange.nodes), exchange.nodes.n_rows
    links = exchange.links.tocoo()
    below = exchange.gathering.tocoo()
    carries = (np.diff(exchange.start) > 0)[below.row] & (exchange.element_area > 0.0)[below.col]
    # Row elements come after the nodes: the one that is a leaf's own node is joined to it as to those above it.
    row = np.concatenate([links.row, below.row[carries]])
    column = np.concatenate([links.col, n_nodes + below.col[carries]])
    graph = csr_array((np.ones(len(row)), (row, column)), shape=(n_nodes + n_rows,) * 2)
    label = connected_components(graph, directed=False)[1][n_nodes:]
    linked = exchange.received(np.ones(n_rows)) > 0.0
    component = np.zeros(n_rows, np.int32)
    component[linked] = np.unique(label[linked], return_inverse=True)[1]
    return component
