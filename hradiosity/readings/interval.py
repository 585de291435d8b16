"""Mean and spread of replicates that come one by one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


class RunningMean:
    """Mean of arrays that come one by one.

    Parameters
    ----------
    shape : tuple of int
        Of each array.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.count = 0
        self.mean: NDArray[np.float64] = np.zeros(shape)

    def add(self, sample: NDArray[np.floating]) -> None:
        """Take one more replicate into account."""
        self.count += 1
        self.mean = self.mean + (sample - self.mean) / self.count

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """Everything that `restore` needs; later samples do not change the arrays."""
        return {"count": np.array(float(self.count)), "mean": self.mean}

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it belongs to arrays of another shape.
        """
        if kept["mean"].shape != self.mean.shape:
            raise ValueError(f"mean must have shape {self.mean.shape}, has {kept['mean'].shape}")
        self.count = int(kept["count"])
        self.mean = np.asarray(kept["mean"], np.float64)


class RunningMoments(RunningMean):
    """Mean and variance of arrays that come one by one (Welford 1962); parameters as of `RunningMean`."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        super().__init__(shape)
        self._sum_of_squares: NDArray[np.float64] = np.zeros(shape)

    def add(self, sample: NDArray[np.floating]) -> None:
        """Take one more replicate into account."""
        change = sample - self.mean
        super().add(sample)
        self._sum_of_squares = self._sum_of_squares + change * (sample - self.mean)

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """Everything that `restore` needs; later samples do not change the arrays."""
        return super().checkpoint() | {"squares": self._sum_of_squares}

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it belongs to arrays of another shape.
        """
        if kept["squares"].shape != self.mean.shape:
            raise ValueError(f"squares must have shape {self.mean.shape}, has {kept['squares'].shape}")
        super().restore(kept)
        self._sum_of_squares = np.asarray(kept["squares"], np.float64)

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """Of the mean, s/√R; infinite with fewer than two replicates."""
        if self.count < 2:
            return np.full_like(self.mean, np.inf)
        error: NDArray[np.float64] = np.sqrt(self._sum_of_squares / (self.count - 1) / self.count)
        return error


def part_of(kept: Mapping[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    """Entries of a checkpoint with names ``prefix/name``, by name."""
    return {key[len(prefix) + 1 :]: array for key, array in kept.items() if key.startswith(f"{prefix}/")}
