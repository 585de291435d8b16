"""Vectors of the conjugate gradients, one a column, and what is done with them: on the device, or in double precision.

What is done in place saves more than half of the time: these arrays are large, and hardly anything is computed on them.
"""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.solvers.column_algebra import column_dot
from hradiosity.solvers.measure import Sets
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns

V = TypeVar("V")
Factors = NDArray[np.floating[Any]]
"""(8 n_groups,) a number a column."""


class Vectors(Protocol, Generic[V]):
    """The algebra of A = I − R½ S R½ on vectors of a kind V, each (n_rows, 8 n_groups)."""

    def put(self, columns: Columns) -> V:
        """A vector of its own with these values."""

    def get(self, vector: V) -> Columns:
        """Its values."""

    def pick(self, vector: V, every: int) -> Columns:
        """The values of every so many rows."""

    def assign(self, to: V, vector: V) -> None:
        """Make one vector equal to another."""

    def image(self, to: V, vector: V) -> None:
        """Make the first A times the second."""

    def products(self, x: V, y: V) -> NDArray[np.float64]:
        """(n_sets, 8 n_groups) products over each set of connected elements, summed in double precision."""

    def add(self, to: V, factors: Factors, vector: V) -> None:
        """Add a multiple, a factor a column."""

    def turn(self, direction: V, factors: Factors, residual: V) -> None:
        """Make the direction the residual plus a multiple of itself."""


class HostVectors:
    """Vectors in the operator's precision, in arrays.

    Parameters
    ----------
    operator : ExchangeOperator
    root : (n_rows, 8 n_groups), R½
    sets : Sets
    """

    def __init__(self, operator: ExchangeOperator, root: Columns, sets: Sets) -> None:
        self._operator, self._root, self._sets = operator, root, sets

    def put(self, columns: Columns) -> Columns:
        """See `Vectors`."""
        return columns.astype(self._operator.dtype)

    def get(self, vector: Columns) -> Columns:
        """See `Vectors`."""
        return vector.copy()

    def pick(self, vector: Columns, every: int) -> Columns:
        """See `Vectors`."""
        return vector[::every]

    def assign(self, to: Columns, vector: Columns) -> None:
        """See `Vectors`."""
        to[:] = vector

    def image(self, to: Columns, vector: Columns) -> None:
        """See `Vectors`."""
        to[:] = vector - self._root * self._operator.apply(self._root * vector)

    def products(self, x: Columns, y: Columns) -> NDArray[np.float64]:
        """See `Vectors`."""
        return self._sets.dots(x, y)

    def add(self, to: Columns, factors: Factors, vector: Columns) -> None:
        """See `Vectors`."""
        to += factors.astype(self._operator.dtype) * vector

    def turn(self, direction: Columns, factors: Factors, residual: Columns) -> None:
        """See `Vectors`."""
        direction *= factors.astype(self._operator.dtype)
        direction += residual


class ChunkProducts:
    """Products of columns on the device over sets of connected elements, summed in double precision.

    Parameters
    ----------
    device : Device
    sets : Sets
    n_columns : int
        A multiple of eight.
    """

    def __init__(self, device: Device, sets: Sets, n_columns: int) -> None:
        self._device, self._sets, self._groups = device, sets, n_columns // 8
        self._n_chunks = len(sets.chunk_start) - 1
        self._chunks = {
            "order": device.upload(sets.order, np.uint32),
            "chunk_start": device.upload(sets.chunk_start, np.uint32),
        }
        self._sums = device.empty((self._n_chunks, n_columns), np.float64)

    def __call__(self, x: DeviceArray, y: DeviceArray) -> NDArray[np.float64]:
        """(n_sets, n_columns) of two (n_rows, n_columns) float32 arrays."""
        self._device.kernel("column_vectors", "multiply_chunks")(
            self._n_chunks * self._groups, x=x, y=y, **self._chunks, sums=self._sums, n_groups=self._groups
        )
        return self._sets.of_chunks(self._device.fetch(self._sums))


def squares(device: Device, columns: Columns) -> NDArray[np.float64]:
    """(n_columns,) sums of the squares of each column of (n_rows, n_columns), summed in double precision."""
    if not len(columns) or not device.info.has_double:
        return column_dot(columns, columns)
    on_device = device.upload(columns, np.float32)
    whole = Sets(np.zeros(len(columns), np.int32))
    total: NDArray[np.float64] = ChunkProducts(device, whole, columns.shape[1])(on_device, on_device)[0]
    return total


class DeviceVectors:
    """Vectors in single precision that stay on the device.

    Parameters
    ----------
    operator : ExchangeOperator
        In single precision.
    root : (n_rows, 8 n_groups) float32, R½
    sets : Sets
    """

    def __init__(self, operator: ExchangeOperator, root: Columns, sets: Sets) -> None:
        self._operator, self._device = operator, operator.device
        self._shape = root.shape
        self._groups = root.shape[1] // 8
        self._size = root.shape[0] * self._groups
        self._root = self._device.upload(root, np.float32)
        self._scaled = self._device.empty(root.shape, np.float32)
        self._products = ChunkProducts(self._device, sets, root.shape[1])

    def put(self, columns: Columns) -> DeviceArray:
        """See `Vectors`."""
        return self._device.upload(columns, np.float32)

    def get(self, vector: DeviceArray) -> Columns:
        """See `Vectors`."""
        fetched: Columns = self._device.fetch(vector).reshape(self._shape)
        return fetched

    def pick(self, vector: DeviceArray, every: int) -> Columns:
        """See `Vectors`."""
        n_picked = -(-self._shape[0] // every)
        picked = self._device.empty((n_picked, self._shape[1]), np.float32)
        self._device.kernel("column_vectors", "pick_rows")(
            n_picked * self._groups, x=vector, picked=picked, every=every, n_groups=self._groups
        )
        fetched: Columns = self._device.fetch(picked)
        return fetched

    def assign(self, to: DeviceArray, vector: DeviceArray) -> None:
        """See `Vectors`."""
        self._device.copy(to, vector)

    def image(self, to: DeviceArray, vector: DeviceArray) -> None:
        """See `Vectors`."""
        parts = {"root": self._root, "x": vector}
        self._device.kernel("column_vectors", "scale_columns")(self._size, **parts, scaled=self._scaled)
        self._operator.multiply(self._scaled, to)
        self._device.kernel("column_vectors", "finish_image")(self._size, **parts, image=to)

    def products(self, x: DeviceArray, y: DeviceArray) -> NDArray[np.float64]:
        """See `Vectors`."""
        return self._products(x, y)

    def add(self, to: DeviceArray, factors: Factors, vector: DeviceArray) -> None:
        """See `Vectors`."""
        self._device.kernel("column_vectors", "add_columns")(
            self._size, y=to, x=vector, factor=self._device.upload(factors, np.float32), n_groups=self._groups
        )

    def turn(self, direction: DeviceArray, factors: Factors, residual: DeviceArray) -> None:
        """See `Vectors`."""
        self._device.kernel("column_vectors", "turn_columns")(
            self._size,
            direction=direction,
            residual=residual,
            factor=self._device.upload(factors, np.float32),
            n_groups=self._groups,
        )


def vectors_for(operator: ExchangeOperator, root: Columns, sets: Sets) -> Vectors[Any]:
    """Vectors on the device in single precision; arrays in double, and where the device can't sum in double."""
    if operator.dtype is np.float64 or not len(root) or not operator.device.info.has_double:
        return HostVectors(operator, root, sets)
    return DeviceVectors(operator, root, sets)
