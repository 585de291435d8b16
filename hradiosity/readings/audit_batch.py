"""Readings that are traced by unbiased paths together, round after round."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.path_scene import RefereeScene
from hradiosity.readings.paths import ROUND_PATHS, SCRAMBLES, PathTotals, trace_round


class ReadingBatch:
    """Readings that are traced together.

    Parameters
    ----------
    chosen : (n,) int64
        Which of all readings they are.
    position, normal : (n, 3) float64
    n_bands, seed : int
    """

    def __init__(
        self,
        chosen: NDArray[np.int64],
        position: NDArray[np.float64],
        normal: NDArray[np.float64],
        n_bands: int,
        seed: int,
    ) -> None:
        self.chosen = chosen
        self._position, self._normal, self._seed = position, normal, seed
        self._totals = PathTotals(len(chosen), n_bands)

    def trace(self, referee: RefereeScene, n_paths: int) -> None:
        """So many more paths from each reading and scramble."""
        sums = trace_round(
            referee, self._position, self._normal, first_path=self.paths, n_paths=n_paths, seed=self._seed
        )
        self._totals.add(sums, n_paths)

    @property
    def paths(self) -> int:
        """From each reading and scramble."""
        return self._totals.paths

    @property
    def rays(self) -> int:
        """Traced so far."""
        return self._totals.rays

    @property
    def rays_per_path(self) -> float:
        """Rays of one more path from each reading and scramble."""
        return self.rays / self.paths

    @property
    def round_paths(self) -> int:
        """From each reading and scramble in one round, at most."""
        return max(1, ROUND_PATHS // (len(self.chosen) * SCRAMBLES))

    @property
    def per_scramble(self) -> NDArray[np.float64]:
        """(n_scrambles, n, n_bands) float64 [W m⁻² per band]."""
        return self._totals.samples().per_scramble
