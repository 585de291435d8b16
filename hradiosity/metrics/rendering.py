"""Colour rendering indices of CIE 13.3-1995."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics.colorimetric import chromaticity_1960, xyz_weights
from hradiosity.metrics.references import MOST_DAYLIGHT, References
from hradiosity.metrics.samples import rendering_samples
from hradiosity.metrics.temperature import ColourTemperature, colour_temperature
from hradiosity.metrics.weights import sample_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands

GENERAL: Final = 8
"""Test colours whose mean is Ra."""
SWITCH: Final = 5000.0
"""Colour temperature [K] from which on the reference is daylight."""


@dataclass(frozen=True)
class ColourRendering:
    """Of n lights; NaN where light has no colour temperature, or one above 25 000 K.

    ra : (n,) float64, general index, mean of the first eight special ones
    special : (n, 14) float64, R1 … R14
    """

    ra: NDArray[np.float64]
    special: NDArray[np.float64]


class RenderingIndex:
    """CIE 13.3-1995 for light in given bands.

    Light counts as white only within 5.4e-3 of the reference in u, v; beyond that, the standard says, indices become
    less accurate. They are given all the same, as other programs do; look at Duv beside them.

    Parameters
    ----------
    bands : Bands
    """

    def __init__(self, bands: Bands) -> None:
        self._white = xyz_weights(bands)
        wavelength, reflectance = rendering_samples()
        colours = sample_weights(wavelength, reflectance, photometry.observer("1931"), bands)
        self._colours = MAXIMUM_LUMINOUS_EFFICACY * colours.reshape(len(bands), -1)
        both = np.concatenate([self._white, self._colours], axis=1)
        self._references = References(bands, both, luminance=1)

    def __call__(self, power: NDArray[np.float64], temperature: ColourTemperature | None = None) -> ColourRendering:
        """Indices of lights.

        Parameters
        ----------
        power : (n, n_bands) float64
            Irradiance, radiance or any other power per band.
        temperature : ColourTemperature, optional
            Of the same lights, where it is known already.
        """
        white = np.einsum("nb,bc->nc", power, self._white)
        cct = (colour_temperature(white) if temperature is None else temperature).cct
        special = np.full((len(power), self._colours.shape[1] // 3), np.nan)
        known = cct <= MOST_DAYLIGHT
        if known.any():
            seen = np.einsum("nb,bk->nk", power[known], self._colours)
            special[known] = _special_indices(
                np.concatenate([white[known], seen], axis=1), self._references.blend(cct[known], SWITCH, SWITCH)
            )
        return ColourRendering(special[:, :GENERAL].mean(axis=1), special)


def _special_indices(light: NDArray[np.float64], reference: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, m) indices from (n, 3 + 3 m) tristimulus values of white and test colours; CIE 13.3, section 5."""
    light, reference = (part.reshape(len(part), -1, 3) for part in (light, reference))
    uv, uv_reference = chromaticity_1960(light), chromaticity_1960(reference)
    white, white_reference = uv[:, :1], uv_reference[:, :1]
    adapted = _adapted(uv[:, 1:], white, white_reference)
    found = _uniform_space(light, adapted, white_reference)
    wanted = _uniform_space(reference, uv_reference[:, 1:], white_reference)
    indices: NDArray[np.float64] = 100.0 - 4.6 * np.sqrt(((found - wanted) ** 2).sum(axis=2))
    return indices


def _adapted(
    uv: NDArray[np.float64], white: NDArray[np.float64], reference: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Chromaticities as seen by an eye that is used to the reference; CIE 13.3, section 5.7 (von Kries)."""
    c, d = _cone_ratios(uv)
    (c_white, d_white), (c_reference, d_reference) = _cone_ratios(white), _cone_ratios(reference)
    c, d = c * c_reference / c_white, d * d_reference / d_white
    bottom = 16.518 + 1.481 * c - d
    return np.stack([(10.872 + 0.404 * c - 4.0 * d) / bottom, 5.52 / bottom], axis=-1)


def _cone_ratios(uv: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The functions c and d of CIE 13.3, section 5.7."""
    u, v = uv[..., 0], uv[..., 1]
    return (4.0 - u - 10.0 * v) / v, (1.708 * v + 0.404 - 1.481 * u) / v


def _uniform_space(
    tristimulus: NDArray[np.float64], uv: NDArray[np.float64], white: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, m, 3) U*, V*, W* of CIE 1964; white, the first of the tristimulus values, has a luminance of 100."""
    lightness = 25.0 * np.cbrt(100.0 * tristimulus[:, 1:, 1] / tristimulus[:, :1, 1]) - 17.0
    return np.concatenate([13.0 * lightness[..., None] * (uv - white), lightness[..., None]], axis=2)
