"""Photometric quantities from spectra in bands: pure functions of arrays."""

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, band_mean


def luminous_weights(bands: Bands) -> NDArray[np.float64]:
    """Luminous efficacy of each band: K_m times the mean of V(λ) over it.

    Exact for light that is uniform inside each band; the error for other light falls with the square of the width.

    Parameters
    ----------
    bands : Bands

    Returns
    -------
    (n_bands,) float64 [lm W⁻¹]
    """
    return MAXIMUM_LUMINOUS_EFFICACY * band_mean(photometry.luminous_efficiency(), bands, "zero").value


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
    return np.einsum("...b,b->...", irradiance, luminous_weights(bands))


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
    return np.einsum("...b,b->...", radiance, luminous_weights(bands))
