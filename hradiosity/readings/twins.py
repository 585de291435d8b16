"""How much of the noise of readings comes from the light on the elements, and not from their own rays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

MOST_TWINS: Final = 32
"""Points that are read twice, evenly from first to last."""
LEAST_REPLICATES: Final = 4
"""Before these nothing is said."""


class Twins:
    """Points that each replicate reads twice, with other rays: what both have in common comes from the elements.

    Parameters
    ----------
    n_points : int
        Of all readings.

    Attributes
    ----------
    chosen : (m,) int64, those that are read twice
    """

    def __init__(self, n_points: int) -> None:
        self.chosen = np.unique(np.linspace(0, n_points - 1, min(MOST_TWINS, n_points)).astype(np.int64))
        self._pairs = np.zeros((0, 2, len(self.chosen)))

    def add(self, first: NDArray[np.float64], second: NDArray[np.float64]) -> None:
        """The brightness (m,) of the chosen points in one more replicate, twice."""
        self._pairs = np.concatenate([self._pairs, np.stack([first, second])[None]])

    @property
    def surface_share(self) -> float:
        """Share of the variance between replicates that both of a pair have in common, 0 to 1."""
        if len(self._pairs) < LEAST_REPLICATES:
            return 0.0
        mean = self._pairs.mean(axis=(0, 1))
        deviation = self._pairs - self._pairs.mean(axis=0)
        relative = np.divide(deviation, mean, out=np.zeros_like(deviation), where=mean > 0.0)
        common = float((relative[:, 0] * relative[:, 1]).sum())
        whole = 0.5 * float((relative**2).sum())
        return min(max(common / whole, 0.0), 1.0) if whole > 0.0 else 0.0

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """What `restore` needs."""
        return {"pairs": self._pairs}

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint."""
        self._pairs = np.asarray(kept["pairs"], np.float64)
