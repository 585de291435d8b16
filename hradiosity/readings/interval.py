"""Intervals from replicates: running mean and variance, Student's t."""

from __future__ import annotations

from collections.abc import Mapping

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

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """Everything that `restore` needs; later samples do not change the arrays."""
        return {"count": np.array(float(self.count)), "mean": self.mean, "squares": self._sum_of_squares}

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it belongs to arrays of another shape.
        """
        for name in ("mean", "squares"):
            if kept[name].shape != self.mean.shape:
                raise ValueError(f"{name} must have shape {self.mean.shape}, has {kept[name].shape}")
        self.count = int(kept["count"])
        self.mean = np.asarray(kept["mean"], np.float64)
        self._sum_of_squares = np.asarray(kept["squares"], np.float64)

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
