"""The light of one replicate of the classic mode, as its readings gather it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.hemicube import Hemicube


@dataclass(frozen=True)
class ClassicLight:
    """The light of one replicate, as hemicubes at readings gather it.

    hemicube : draws the row elements
    reflected : (n_rows, n_columns) float64, ρE
    emitted : (n_rows, n_columns) float64, exitance of lamps
    seed : of the replicate
    change : (n_rows, n_columns) float64, what patches and elements of twice the size would add to ρE
    """

    hemicube: Hemicube
    reflected: NDArray[np.float64]
    emitted: NDArray[np.float64]
    seed: int
    change: NDArray[np.float64]

    @property
    def nbytes(self) -> int:
        """Of what each replicate has for itself."""
        return self.reflected.nbytes + self.emitted.nbytes + self.change.nbytes
