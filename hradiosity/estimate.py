"""A number with its interval, and the parts that the interval is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

SAMPLING: Final = "sampling"
"""The part that comes from the spread of the replicates; others do not grow with the level of the interval."""
MESH: Final = "mesh"
"""What smaller elements would change, by the change from elements of twice the size."""
EXCHANGE: Final = "exchange"
"""What more rays from each element would change, by the change from half of them."""
UNSEEN: Final = "unseen"
"""Light that a dark reading may have though none of its rays found any."""


@dataclass(frozen=True)
class Estimate:
    """A number or an array of them, each with an interval of its own.

    value : float64 of any shape
    standard_error : float64 of that shape, of the mean over replicates; infinite with fewer than two of them
    degrees_of_freedom : of the standard error, replicates − 1
    others : by part, float64 of that shape: bounds of what replicates have in common, which hold at every level
    factor : of the whole half width, from an audit

    Intervals are pointwise: of a hundred with the level of 95 %, about five miss the true value.
    """

    value: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    degrees_of_freedom: int
    others: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    factor: float = 1.0

    def half_width_at(self, level: float) -> NDArray[np.float64]:
        """Half width of the two-sided interval: its parts in quadrature, times the factor."""
        squares = self._sampling(level) ** 2
        for part in self.others.values():
            squares = squares + part**2
        width: NDArray[np.float64] = self.factor * np.sqrt(squares)
        return width

    @property
    def half_width(self) -> NDArray[np.float64]:
        """Of the 95 % interval."""
        return self.half_width_at(0.95)

    @property
    def parts(self) -> dict[str, NDArray[np.float64]]:
        """What the half width of the 95 % interval is made of, by name; before the factor."""
        return {SAMPLING: self._sampling(0.95), **self.others}

    def __getitem__(self, index: int | slice) -> Estimate:
        """Some of the numbers."""
        return replace(
            self,
            value=np.asarray(self.value[index]),
            standard_error=np.asarray(self.standard_error[index]),
            others={name: np.asarray(part[index]) for name, part in self.others.items()},
        )

    def _sampling(self, level: float) -> NDArray[np.float64]:
        if self.degrees_of_freedom < 1:
            return np.full_like(self.standard_error, np.inf)
        return student_quantile(level, self.degrees_of_freedom) * self.standard_error


def student_quantile(level: float, degrees_of_freedom: int) -> float:
    """Two-sided quantile of Student's t: P(|T| ≤ q) = level."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees_of_freedom, 0.5 * (1.0 + level)))
