"""Products of (rows, columns) arrays, a number for each column, summed in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def column_dot(x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float64]:
    """Product of each column, summed in float64."""
    total: NDArray[np.float64] = np.add.reduce(x * y, axis=0, dtype=np.float64)
    return total


def column_ratio(above: NDArray[np.float64], below: NDArray[np.float64]) -> NDArray[np.float32]:
    """Quotient of each column; 0 where the divisor is not positive."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0).astype(np.float32)
