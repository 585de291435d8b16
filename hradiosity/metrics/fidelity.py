"""Colour fidelity and gamut of ANSI/IES TM-30-20; the fidelity index is that of CIE 224:2017."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics.appearance import uniform_appearance
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.metrics.references import MOST_DAYLIGHT, References
from hradiosity.metrics.samples import fidelity_samples
from hradiosity.metrics.temperature import ColourTemperature, colour_temperature
from hradiosity.metrics.weights import sample_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands

HUES: Final = 16
"""Sectors of the hue circle, from a′ on, counter-clockwise."""
COLDEST, HOTTEST = 4000.0, 5000.0
"""Colour temperatures [K] between which the reference is mixed of black body and daylight."""
_SCALE: Final = 6.73
_AT_ONCE: Final = 256
"""Lights at once: their colours fit into the cache of a core."""


@dataclass(frozen=True)
class ColourFidelity:
    """Of n lights; NaN where light has no colour temperature, or one above 25 000 K.

    rf : (n,) float64, fidelity index Rf
    rg : (n,) float64, gamut index Rg; also NaN where the reference is so warm (below 1150 K) that no sample's hue
        falls into a sector
    local_fidelity : (n, 16) float64, Rf,h of each sector of hues
    chroma_shift : (n, 16) float64 [%], Rcs,h; positive where colours look more saturated than under the reference
    hue_shift : (n, 16) float64, Rhs,h, relative to the chroma
    """

    rf: NDArray[np.float64]
    rg: NDArray[np.float64]
    local_fidelity: NDArray[np.float64]
    chroma_shift: NDArray[np.float64]
    hue_shift: NDArray[np.float64]


class FidelityIndex:
    """TM-30 for light in given bands.

    Parameters
    ----------
    bands : Bands
    """

    def __init__(self, bands: Bands) -> None:
        self._temperature = xyz_weights(bands)
        colours = sample_weights(*fidelity_samples(), photometry.observer("1964"), bands)
        colours = colours.transpose(0, 2, 1).reshape(len(bands), -1)
        white = xyz_weights(bands, "1964")
        self._seen = np.concatenate([white, MAXIMUM_LUMINOUS_EFFICACY * colours], axis=1)
        self._references = References(bands, self._seen, luminance=1)

    def __call__(self, power: NDArray[np.float64], temperature: ColourTemperature | None = None) -> ColourFidelity:
        """Indices of lights.

        Parameters
        ----------
        power : (n, n_bands) float64
            Irradiance, radiance or any other power per band.
        temperature : ColourTemperature, optional
            Of the same lights, where it is known already.
        """
        if temperature is None:
            temperature = colour_temperature(np.einsum("nb,bc->nc", power, self._temperature))
        found = np.full((len(power), 2 + 3 * HUES), np.nan)
        known = np.flatnonzero(temperature.cct <= MOST_DAYLIGHT)
        for start in range(0, len(known), _AT_ONCE):
            part = known[start : start + _AT_ONCE]
            seen = np.einsum("nb,bk->nk", power[part], self._seen)
            reference = self._references.blend(temperature.cct[part], COLDEST, HOTTEST)
            found[part] = _indices(_appearance(seen), _appearance(reference))
        local = found[:, 2:].reshape(-1, 3, HUES)
        return ColourFidelity(found[:, 0], found[:, 1], local[:, 0], local[:, 1], local[:, 2])


def _appearance(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, m) J′, a′, b′ from (n, 3 + 3 m) sums: X, Y, Z of white, X of all colours, Y of all, Z of all."""
    return uniform_appearance(sums[:, 3:].reshape(len(sums), 3, -1), sums[:, :3])


def _index(difference: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fidelity from a colour difference, never below 0; CIE 224:2017, equations 9 and 10."""
    return 10.0 * np.log1p(np.exp((100.0 - _SCALE * difference) / 10.0))


def _indices(light: NDArray[np.float64], reference: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2 + 3 · 16) Rf, Rg and the three local values, from (n, 3, m) colours under light and reference."""
    difference = np.sqrt(((light - reference) ** 2).sum(axis=1))
    angle = np.arctan2(reference[:, 2], reference[:, 1]) % (2.0 * np.pi)
    sector = np.minimum((angle * (HUES / (2.0 * np.pi))).astype(np.int64), HUES - 1)
    values = (light[:, 1], light[:, 2], reference[:, 1], reference[:, 2], difference)
    a, b, a_reference, b_reference, local = _sector_means(values, sector)
    middle = (np.arange(HUES) + 0.5) * (2.0 * np.pi / HUES)
    chroma = np.hypot(a_reference, b_reference)
    shift_a, shift_b = (a - a_reference) / chroma, (b - b_reference) / chroma
    chroma_shift = 100.0 * (shift_a * np.cos(middle) + shift_b * np.sin(middle))
    hue_shift = shift_b * np.cos(middle) - shift_a * np.sin(middle)
    gamut = 100.0 * _polygon_area(a, b) / _polygon_area(a_reference, b_reference)
    whole = np.stack([_index(difference.mean(axis=1)), gamut], axis=1)
    return np.concatenate([whole, _index(local), chroma_shift, hue_shift], axis=1)


def _sector_means(values: Sequence[NDArray[np.float64]], sector: NDArray[np.int64]) -> list[NDArray[np.float64]]:
    """(n, 16) means of each of the (n, m) values over the samples of each sector; NaN where a sector has none."""
    n = len(sector)
    place = (np.arange(n)[:, None] * HUES + sector).ravel()
    count = np.bincount(place, minlength=n * HUES)
    means = []
    for value in values:
        total = np.bincount(place, weights=value.ravel(), minlength=n * HUES)
        mean = np.full(n * HUES, np.nan)
        np.divide(total, count, out=mean, where=count > 0)
        means.append(mean.reshape(n, HUES))
    return means


def _polygon_area(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) areas of polygons with (n, m) corners."""
    area: NDArray[np.float64] = 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return area
