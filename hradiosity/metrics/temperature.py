"""Correlated colour temperature and distance from the Planckian locus."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import chromaticity_1960
from hradiosity.metrics.planck import COLDEST, HOTTEST, nearest_on_locus

FARTHEST: Final = 0.05
"""Largest distance from the locus, CIE 1960, at which light has a colour temperature. CIE 15:2018, section 9.5."""
REASONS: Final = (
    "",
    "no light",
    f"more than {FARTHEST:g} from the Planckian locus in u, v",
    f"not between {COLDEST:g} and {HOTTEST:g} K",
)
"""Why there is no temperature, by number; 0 where there is one."""


@dataclass(frozen=True)
class ColourTemperature:
    """Of n lights.

    cct : (n,) float64 [K], correlated colour temperature; NaN where there is none
    duv : (n,) float64, distance from the locus in CIE 1960 u, v, positive above it (greener); also known where the
        light is too far from the locus to have a temperature, NaN without light and beyond the ends of the locus
    reason : (n,) uint8, why there is no temperature, see `REASONS`
    """

    cct: NDArray[np.float64]
    duv: NDArray[np.float64]
    reason: NDArray[np.uint8]


def colour_temperature(tristimulus: NDArray[np.float64]) -> ColourTemperature:
    """Temperature of the black body whose colour is nearest in CIE 1960 u, v.

    This is the minimum itself that the tables with triangles and parabolas of Ohno 2014 (Practical use and calculation
    of CCT and Duv, Leukos 10, 47) approach: within 0.002 % of them above 2000 K, 0.02 % below.

    Parameters
    ----------
    tristimulus : (n, 3) float64
        From the 1931 observer.
    """
    uv = chromaticity_1960(tristimulus)
    lit = np.isfinite(uv).all(axis=1)
    cct, duv = np.full(len(uv), np.nan), np.full(len(uv), np.nan)
    reason = np.where(lit, 0, 1).astype(np.uint8)
    cct[lit], duv[lit] = nearest_on_locus(uv[lit])
    reason[lit & (np.abs(duv) > FARTHEST)] = 2
    beyond = lit & ((cct <= COLDEST) | (cct >= HOTTEST))
    reason[beyond] = 3
    duv[beyond] = np.nan
    cct[reason > 0] = np.nan
    return ColourTemperature(cct, duv, reason)
