"""Colour from spectra in bands: pure functions of arrays."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics.weights import band_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Spectrum

SRGB_PRIMARIES: Final = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])
"""Chromaticities x, y of red, green, blue. IEC 61966-2-1."""

SRGB_WHITE: Final = np.array([0.3127, 0.3290])
"""Chromaticity x, y of white, D65. IEC 61966-2-1."""

ROUNDING: Final = 1e-9
"""How far below 0 or above 1 a linear value may lie by rounding alone."""


def xyz_weights(bands: Bands, observer: str = "1931") -> NDArray[np.float64]:
    """Weights that turn power per band into tristimulus values: K_m times x̄, ȳ, z̄ over each band.

    Parameters
    ----------
    bands : Bands
    observer : "1931" or "1964"

    Returns
    -------
    (n_bands, 3) float64 [lm W⁻¹]
        With the 1931 observer, Y is in lm for W, lx for W m⁻², cd m⁻² for W m⁻² sr⁻¹.

    Raises
    ------
    ValueError
        For another observer.
    """
    wavelength, functions = photometry.observer(observer)
    columns = [band_weights(Spectrum(wavelength, function), bands) for function in functions.T]
    return MAXIMUM_LUMINOUS_EFFICACY * np.stack(columns, axis=1)


def xyz(power: NDArray[np.float64], bands: Bands, observer: str = "1931") -> NDArray[np.float64]:
    """Tristimulus values.

    Parameters
    ----------
    power : (…, n_bands) float64
        Irradiance, radiance or any other power per band.
    bands : Bands
    observer : "1931" or "1964"

    Returns
    -------
    (…, 3) float64
        X, Y, Z in the photometric unit that belongs to ``power``.
    """
    summed: NDArray[np.float64] = np.einsum("...b,bc->...c", power, xyz_weights(bands, observer))
    return summed


def chromaticity(tristimulus: NDArray[np.float64]) -> NDArray[np.float64]:
    """Chromaticity coordinates x, y.

    Parameters
    ----------
    tristimulus : (…, 3) float64

    Returns
    -------
    (…, 2) float64
        NaN where there is no light.
    """
    total = tristimulus.sum(axis=-1, keepdims=True)
    xy = np.full_like(tristimulus[..., :2], np.nan)
    np.divide(tristimulus[..., :2], total, out=xy, where=total > 0)
    return xy


def uniform_chromaticity(tristimulus: NDArray[np.float64]) -> NDArray[np.float64]:
    """Chromaticity coordinates u′, v′ of the CIE 1976 uniform chromaticity scale, CIE 15:2018.

    Parameters
    ----------
    tristimulus : (…, 3) float64

    Returns
    -------
    (…, 2) float64
        NaN where there is no light.
    """
    x, y, z = np.moveaxis(tristimulus, -1, 0)
    total = (x + 15.0 * y + 3.0 * z)[..., None]
    uv = np.full_like(tristimulus[..., :2], np.nan)
    np.divide(np.stack([4.0 * x, 9.0 * y], axis=-1), total, out=uv, where=total > 0)
    return uv


def chromaticity_1960(tristimulus: NDArray[np.float64]) -> NDArray[np.float64]:
    """Chromaticity coordinates u = u′, v = ⅔ v′ of CIE 1960, in which colour temperatures are defined.

    Parameters
    ----------
    tristimulus : (…, 3) float64

    Returns
    -------
    (…, 2) float64
        NaN where there is no light.
    """
    uv: NDArray[np.float64] = uniform_chromaticity(tristimulus) * np.array([1.0, 2.0 / 3.0])
    return uv


def linear_rgb_matrix(primaries: NDArray[np.float64], white: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, 3) matrix that takes X, Y, Z to linear R, G, B, and white of luminance 1 to (1, 1, 1).

    Source: SMPTE RP 177-1993, derivation of the normalised primary matrix.

    Parameters
    ----------
    primaries : (3, 2) float64
        Chromaticities x, y of red, green and blue.
    white : (2,) float64
        Chromaticity of white.
    """
    x, y = np.vstack([primaries, white]).T
    per_luminance = np.stack([x / y, np.ones(4), (1 - x - y) / y])
    luminances = np.linalg.solve(per_luminance[:, :3], per_luminance[:, 3])
    return np.linalg.inv(per_luminance[:, :3] * luminances)


def xyz_to_linear_srgb(tristimulus: NDArray[np.float64], white_luminance: float) -> NDArray[np.float64]:
    """Linear sRGB, without adaptation to the scene's white.

    Parameters
    ----------
    tristimulus : (…, 3) float64
        From the 1931 observer.
    white_luminance : float
        Y that the display shows as its white.

    Returns
    -------
    (…, 3) float64
        0 … 1 for what the display can show; not clipped.

    Raises
    ------
    ValueError
        Unless ``white_luminance`` is positive and finite.
    """
    if not (np.isfinite(white_luminance) and white_luminance > 0):
        raise ValueError(f"the luminance of white must be positive, is {white_luminance}")
    linear: NDArray[np.float64] = np.einsum(
        "...c,rc->...r", tristimulus / white_luminance, linear_rgb_matrix(SRGB_PRIMARIES, SRGB_WHITE)
    )
    return linear


def linear_srgb_to_xyz(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tristimulus values (…, 3) of linear sRGB (…, 3); Y of white is 1."""
    matrix = np.linalg.inv(linear_rgb_matrix(SRGB_PRIMARIES, SRGB_WHITE))
    tristimulus: NDArray[np.float64] = np.einsum("...c,rc->...r", linear, matrix)
    return tristimulus


def encode_srgb(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a picture file, 0 … 1, from linear sRGB; clips what the display can't show. IEC 61966-2-1.

    Parameters
    ----------
    linear : (…, 3) float64

    Returns
    -------
    (…, 3) float64
    """
    clipped = np.clip(linear, 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def out_of_gamut(linear: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where the colour is too saturated for the display at any brightness: a channel below 0.

    Parameters
    ----------
    linear : (…, 3) float64

    Returns
    -------
    (…) bool
    """
    scale = np.maximum(np.abs(linear).max(axis=-1), 1.0)
    return np.asarray(linear.min(axis=-1) < -ROUNDING * scale)


def overexposed(linear: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where the light is too bright for the display: a channel above 1.

    Parameters
    ----------
    linear : (…, 3) float64

    Returns
    -------
    (…) bool
    """
    return np.asarray(linear.max(axis=-1) > 1.0 + ROUNDING)
