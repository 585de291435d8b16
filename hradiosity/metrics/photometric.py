"""Photometric quantities from spectra in bands: pure functions of arrays."""

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics.weights import band_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands


def luminous_weights(bands: Bands) -> NDArray[np.float64]:
    """Luminous efficacy of each band: K_m times V(λ) over it, see `band_weights`.

    Parameters
    ----------
    bands : Bands

    Returns
    -------
    (n_bands,) float64 [lm W⁻¹]
    """
    return MAXIMUM_LUMINOUS_EFFICACY * band_weights(photometry.luminous_efficiency(), bands)


def illuminance(irradiance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """Illuminance from irradiance.

    Parameters
    ----------
    irradiance : (…, n_bands) float64 [W m⁻² per band]
    bands : Bands

    Returns
    -------
    (…) float64 [lx]
    """
    summed: NDArray[np.float64] = np.einsum("...b,b->...", irradiance, luminous_weights(bands))
    return summed


def luminance(radiance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """Luminance from radiance; a Lambertian surface's radiance is its exitance over π sr.

    Parameters
    ----------
    radiance : (…, n_bands) float64 [W m⁻² sr⁻¹ per band]
    bands : Bands

    Returns
    -------
    (…) float64 [cd m⁻²]
    """
    summed: NDArray[np.float64] = np.einsum("...b,b->...", radiance, luminous_weights(bands))
    return summed


def luminous_exitance(exitance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """Luminous exitance from exitance.

    Parameters
    ----------
    exitance : (…, n_bands) float64 [W m⁻² per band]
    bands : Bands

    Returns
    -------
    (…) float64 [lm m⁻²]
    """
    summed: NDArray[np.float64] = np.einsum("...b,b->...", exitance, luminous_weights(bands))
    return summed
