"""How much of the noise of readings comes from the light on the elements, and not from their own rays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

MOST_TWINS: Final = 32
"""Points that are read twice in the first place, evenly from first to last."""
LEAST_REPLICATES: Final = 4
"""Before these nothing is said."""
LEAST_POINTS: Final = 8
"""Fewer are not taken to stand for all."""
POINT_DOUBT: Final = 1.5
"""Standard errors that the noise of a single point exceeds by which it is proved: there may be hundreds of points."""


def twin_points(n_points: int) -> NDArray[np.int64]:
    """(m,) points, of all, that are read twice."""
    return np.unique(np.linspace(0, n_points - 1, min(MOST_TWINS, n_points)).astype(np.int64))


@dataclass(frozen=True)
class CommonNoise:
    """Noise between replicates that two readings of a point, by the same light on the elements, have in common.

    variance : of one replicate, over the square of the mean; an estimate, and below 0 by chance where there is little
    uncertainty : standard error of that; infinite where nothing is known
    """

    variance: float = 0.0
    uncertainty: float = float("inf")

    @classmethod
    def of(cls, first: NDArray[np.float64], second: NDArray[np.float64]) -> CommonNoise:
        """From the brightness (n_replicates, n_points) of points that were read twice, with other rays each time."""
        variance, uncertainty = common_variance(first, second)
        known = np.isfinite(uncertainty)
        count = int(np.count_nonzero(known))
        if count < LEAST_POINTS:
            return cls()
        return cls(float(variance[known].mean()), float(np.sqrt((uncertainty[known] ** 2).sum())) / count)

    def surer(self, other: CommonNoise) -> CommonNoise:
        """The one that is known better."""
        return self if self.uncertainty < other.uncertainty else other

    @property
    def proved(self) -> float:
        """Variance that chance does not explain."""
        return max(self.variance - self.uncertainty, 0.0) if np.isfinite(self.uncertainty) else 0.0


def common_variance(
    first: NDArray[np.float64], second: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Covariance of the readings of each point, over the square of its mean.

    Parameters
    ----------
    first, second : (n_replicates, n_points) float64
        Brightness.

    Returns
    -------
    variance : (n_points,) float64
    uncertainty : (n_points,) float64
        Standard error of that if little were in common; infinite where too little is known.
    """
    count, n_points = first.shape
    variance, uncertainty = np.zeros(n_points), np.full(n_points, np.inf)
    mean = 0.5 * (first + second).mean(axis=0) if count else np.zeros(n_points)
    lit = mean > 0.0
    if count >= LEAST_REPLICATES and lit.any():
        a, b = ((some - some.mean(axis=0))[:, lit] / mean[lit] for some in (first, second))
        variance[lit] = (a * b).sum(axis=0) / (count - 1)
        uncertainty[lit] = np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0) / (count - 1)) / (count - 1)
    return variance, uncertainty


def proved_variance(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_points,) variance in common that chance does not explain, for single points; parameters as before."""
    variance, uncertainty = common_variance(first, second)
    known = np.isfinite(uncertainty)
    return np.maximum(np.where(known, variance - POINT_DOUBT * np.where(known, uncertainty, 0.0), 0.0), 0.0)
