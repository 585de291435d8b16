"""Products of (rows, columns) arrays, a number for each column, summed in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


def column_dot(x: NDArray[np.floating[Any]], y: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Product of each column, summed in float64."""
    total: NDArray[np.float64] = np.add.reduce(x * y, axis=0, dtype=np.float64)
    return total


def column_ratio(
    above: NDArray[np.float64], below: NDArray[np.float64], dtype: DTypeLike = np.float32
) -> NDArray[np.floating[Any]]:
    """Quotient of each column; 0 where the divisor is not positive."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0).astype(dtype)
