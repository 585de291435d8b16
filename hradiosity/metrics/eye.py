"""What the five receptors of the eye receive (CIE S 026:2018), and light weighted by any other action spectrum."""

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics.photometric import illuminance
from hradiosity.metrics.weights import band_weights, tabulated_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Spectrum

RECEPTORS: Final = ("melanopic", "rhodopic", "s-cone-opic", "m-cone-opic", "l-cone-opic")
"""Columns of everything here: melanopsin (ipRGC), rods, and the three cones."""


@cache
def daylight_efficacies() -> NDArray[np.float64]:
    """α-opic efficacy of luminous radiation of D65, K_α,v^D65: α-opic irradiance over illuminance.

    CIE S 026:2018, table 1 to four digits: 1.3262, 1.4497, 0.8173, 1.4558 and 1.6289 mW lm⁻¹.

    Returns
    -------
    (5,) float64 [W lm⁻¹]
        In the order of `RECEPTORS`.
    """
    wavelength, action = _actions()
    daylight = photometry.illuminant("D65")
    power = np.interp(wavelength, daylight.wavelength, daylight.value)
    luminous = MAXIMUM_LUMINOUS_EFFICACY * (photometry.luminous_efficiency().value * power).sum()
    efficacies: NDArray[np.float64] = np.einsum("w,wk->k", power, action) / luminous
    return efficacies


def alpha_opic_weights(bands: Bands) -> NDArray[np.float64]:
    """Weights that turn power per band into α-opic power: the action spectra over each band.

    Parameters
    ----------
    bands : Bands

    Returns
    -------
    (n_bands, 5) float64
        In the order of `RECEPTORS`.
    """
    return tabulated_weights(*_actions(), bands)


def alpha_opic_irradiance(irradiance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """Irradiance weighted by the action spectrum of each receptor, E_α.

    Parameters
    ----------
    irradiance : (n, n_bands) float64 [W m⁻² per band]
    bands : Bands

    Returns
    -------
    (n, 5) float64 [W m⁻²]
        In the order of `RECEPTORS`.
    """
    weighted: NDArray[np.float64] = np.einsum("nb,bk->nk", irradiance, alpha_opic_weights(bands))
    return weighted


def equivalent_daylight_illuminance(irradiance: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """α-opic equivalent daylight (D65) illuminance, EDI: illuminance of daylight that does the same to a receptor.

    Parameters
    ----------
    irradiance : (n, n_bands) float64 [W m⁻² per band]
    bands : Bands

    Returns
    -------
    (n, 5) float64 [lx]
        In the order of `RECEPTORS`.
    """
    return alpha_opic_irradiance(irradiance, bands) / daylight_efficacies()


def daylight_efficacy_ratio(power: NDArray[np.float64], bands: Bands) -> NDArray[np.float64]:
    """α-opic daylight (D65) efficacy ratio, DER: EDI over illuminance; 1 for daylight.

    Parameters
    ----------
    power : (n, n_bands) float64
        Irradiance, radiance or any other power per band.
    bands : Bands

    Returns
    -------
    (n, 5) float64
        In the order of `RECEPTORS`; NaN where there is no luminous power.
    """
    return ratio(equivalent_daylight_illuminance(power, bands), illuminance(power, bands))


def ratio(edi: NDArray[np.float64], luminous: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 5) EDI over (n,) illuminance; NaN where there is none."""
    out = np.full_like(edi, np.nan)
    np.divide(edi, luminous[:, None], out=out, where=luminous[:, None] > 0.0)
    return out


def action_irradiance(irradiance: NDArray[np.float64], bands: Bands, action: Spectrum) -> NDArray[np.float64]:
    """Irradiance weighted by any action spectrum: plants, hazards, a curve of your own.

    Parameters
    ----------
    irradiance : (n, n_bands) float64 [W m⁻² per band]
    bands : Bands
    action : Spectrum
        Zero where it isn't tabulated; `hradiosity.io.spectra.read_spectrum_csv` reads one.

    Returns
    -------
    (n,) float64
        [W m⁻²] times the unit of the action spectrum.

    Raises
    ------
    ValueError
        For an action spectrum with lines.
    """
    weighted: NDArray[np.float64] = np.einsum("nb,b->n", irradiance, band_weights(action, bands))
    return weighted


def _actions() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(m,) wavelengths and (m, 5) action spectra in the order of `RECEPTORS`."""
    wavelength, action = photometry.alpha_opic()
    return wavelength, action[:, [photometry.ALPHA_OPIC_NAMES.index(name) for name in RECEPTORS]]
