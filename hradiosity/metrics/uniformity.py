"""How even the light of an area is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class EvenLight:
    """Of the illuminances of an area; both ratios are 0 where there is no light.

    mean, lowest, highest : [lx]
    uniformity : U₀, lowest over mean (EN 12665)
    diversity : U_d, lowest over highest (EN 12665)
    """

    mean: float
    lowest: float
    highest: float
    uniformity: float
    diversity: float


def even_light(illuminance: NDArray[np.float64]) -> EvenLight:
    """Mean, extremes and their ratios.

    Parameters
    ----------
    illuminance : (n,) float64 [lx]
        n ≥ 1.
    """
    lowest, highest = float(illuminance.min()), float(illuminance.max())
    mean = float(np.clip(illuminance.mean(), lowest, highest))  # rounded, a sum of equal values may lie beside them
    return EvenLight(
        mean,
        lowest,
        highest,
        lowest / mean if mean > 0.0 else 0.0,
        lowest / highest if highest > 0.0 else 0.0,
    )
