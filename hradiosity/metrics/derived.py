"""The numbers of colour and the eye that go beside illuminance and chromaticity, all at once."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import uniform_chromaticity, xyz_weights
from hradiosity.metrics.eye import RECEPTORS, alpha_opic_weights, daylight_efficacies, ratio
from hradiosity.metrics.fidelity import HUES, FidelityIndex
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.metrics.rendering import RenderingIndex
from hradiosity.metrics.temperature import colour_temperature
from hradiosity.model.spectrum import Bands

_EYE: Final = tuple(name.replace("-", "_") for name in RECEPTORS)
USUAL: Final = (
    *(("cct_k", "K"), ("duv", ""), ("ra", "")),
    *((f"{name}_edi_lx", "lx") for name in _EYE),
    *((f"{name}_der", "") for name in _EYE),
)
"""Names and units of the numbers that are always told."""
_TRISTIMULUS: Final = tuple(f"{axis}{observer}_lx" for observer in ("", "10") for axis in "xyz")
_LOCAL: Final = tuple(f"{name}_h{sector}" for name in ("rf", "rcs", "rhs") for sector in range(1, HUES + 1))
FULL: Final = (
    *USUAL,
    *((f"r{number}", "") for number in range(1, 15)),
    *(("rf", ""), ("rg", "")),
    *((name, "%" if name.startswith("rcs") else "") for name in _LOCAL),
    *((name, "lx") for name in _TRISTIMULUS),
    *(("u_prime", ""), ("v_prime", "")),
)
"""With R1 to R14, Rf and Rg, which take some ten times as long, the latter for each of 16 sectors of hues (fidelity,
chroma shift, hue shift), tristimulus values of the 2° and 10° observers, and u′, v′."""


class DerivedNumbers:
    """Derives numbers from spectra in given bands; keeps all weights.

    Parameters
    ----------
    bands : Bands
    full : bool
        All of `FULL` and not only `USUAL`.

    Attributes
    ----------
    names : tuple of (name, unit)
        What a call returns, in order.
    """

    def __init__(self, bands: Bands, *, full: bool = False) -> None:
        self.names: tuple[tuple[str, str], ...] = FULL if full else USUAL
        self._weights = np.concatenate(
            [xyz_weights(bands), luminous_weights(bands)[:, None], alpha_opic_weights(bands) / daylight_efficacies()],
            axis=1,
        )
        self._rendering = RenderingIndex(bands)
        self._fidelity = FidelityIndex(bands) if full else None
        self._ten_degrees = xyz_weights(bands, "1964")

    def __call__(self, power: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Numbers of n lights.

        Parameters
        ----------
        power : (n, n_bands) float64
            Irradiance [W m⁻² per band]; ratios and indices are the same for radiance or any other power.

        Returns
        -------
        dict of (n,) float64
            By name, in the order of `names`. NaN where a number is not defined: without light all but the EDI, which
            are 0; without a colour temperature Ra, R1 to R14, Rf and Rg as well (see `temperature.REASONS`).
        """
        sums = np.einsum("nb,bk->nk", power, self._weights)
        temperature = colour_temperature(sums[:, :3])
        rendering = self._rendering(power, temperature)
        edi = sums[:, 4:]
        found = [temperature.cct, temperature.duv, rendering.ra, *edi.T, *ratio(edi, sums[:, 3]).T]
        if self._fidelity is not None:
            fidelity = self._fidelity(power, temperature)
            found += [*rendering.special.T, fidelity.rf, fidelity.rg, *fidelity.local_fidelity.T]
            found += [*fidelity.chroma_shift.T, *fidelity.hue_shift.T]
            found += [*sums[:, :3].T, *np.einsum("nb,bk->nk", power, self._ten_degrees).T]
            found += [*uniform_chromaticity(sums[:, :3]).T]
        return {name: values for (name, _), values in zip(self.names, found)}


def derived_numbers(power: NDArray[np.float64], bands: Bands, *, full: bool = False) -> dict[str, NDArray[np.float64]]:
    """Numbers of colour and the eye of n lights, see `DerivedNumbers`; weights of the last bands are kept.

    Parameters
    ----------
    power : (n, n_bands) float64
        Irradiance [W m⁻² per band].
    bands : Bands
    full : bool
        With R1 to R14, Rf and Rg.

    Returns
    -------
    dict of (n,) float64
    """
    return _of(bands, full)(power)


@lru_cache(maxsize=8)
def _of(bands: Bands, full: bool) -> DerivedNumbers:
    return DerivedNumbers(bands, full=full)
