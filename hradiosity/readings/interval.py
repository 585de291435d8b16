"""Intervals from replicates: running mean and variance, Student's t."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class RunningMoments:
    """Mean and variance of arrays that come one by one (Welford 1962).

    Parameters
    ----------
    shape : tuple of int
        Of each array.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.count = 0
        self.mean: NDArray[np.float64] = np.zeros(shape)
        self._sum_of_squares: NDArray[np.float64] = np.zeros(shape)

    def add(self, sample: NDArray[np.floating]) -> None:
        """Take one more replicate into account."""
        self.count += 1
        change = sample - self.mean
        self.mean = self.mean + change / self.count
        self._sum_of_squares = self._sum_of_squares + change * (sample - self.mean)

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """Of the mean, s/√R; infinite with fewer than two replicates."""
        if self.count < 2:
            return np.full_like(self.mean, np.inf)
        error: NDArray[np.float64] = np.sqrt(self._sum_of_squares / (self.count - 1) / self.count)
        return error

    def half_width(self, level: float = 0.95) -> NDArray[np.float64]:
        """Half width of the two-sided interval at `level`, t(R − 1) s/√R."""
        if self.count < 2:
            return np.full_like(self.mean, np.inf)
        return student_quantile(level, self.count - 1) * self.standard_error


def student_quantile(level: float, degrees_of_freedom: int) -> float:
    """Two-sided quantile of Student's t: P(|T| ≤ q) = level."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees_of_freedom, 0.5 * (1.0 + level)))
