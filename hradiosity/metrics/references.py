"""What test colours look like under reference illuminants of any colour temperature."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.planck import relative_radiance
from hradiosity.metrics.samples import daylight_components
from hradiosity.model.spectrum import Bands, Spectrum, band_integral

MOST_DAYLIGHT: Final = 25_000.0
"""Daylight is defined up to this temperature [K]; CIE 15:2018."""
_WIDEST: Final = 10.0
"""Widest piece of a band [nm] in which black bodies are integrated by two Gauss points; good to 2e-5 at 1000 K."""
_GAUSS: Final = 0.5 / np.sqrt(3.0)


class References:
    """Weighted sums of the power of black bodies and of daylight, in the bands that the light itself was counted in.

    What the bands cut off or blur is missing in light and reference alike.

    Parameters
    ----------
    bands : Bands
    weights : (n_bands, k) float64
        Of power per band, tristimulus weights for example.
    luminance : int
        Column by which sums are normalised to 1.
    """

    def __init__(self, bands: Bands, weights: NDArray[np.float64], luminance: int) -> None:
        self._luminance = luminance
        wavelength, components = daylight_components()
        power = np.stack([band_integral(Spectrum(wavelength, c), bands, "hold").value for c in components.T])
        self._daylight = np.einsum("cb,bk->ck", power, weights)
        self._weights = weights
        self._node, self._width, self._first = _gauss_nodes(bands)

    def planckian(self, temperature: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, k) sums of black bodies of (n,) temperatures [K]."""
        density = relative_radiance(self._node, temperature)
        power = np.add.reduceat(self._width * density, self._first, axis=1)
        return self._normalised(np.einsum("nb,bk->nk", power, self._weights))

    def daylight(self, temperature: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, k) sums of daylight of (n,) temperatures, 4000 K to 25 000 K; CIE 15:2018, equations 10 to 14.

        The factors of its components aren't rounded, so that sums don't jump.
        """
        kilo = 1e3 / temperature
        warm = 0.244063 + kilo * (0.09911 + kilo * (2.9678 - 4.6070 * kilo))
        cool = 0.237040 + kilo * (0.24748 + kilo * (1.9018 - 2.0064 * kilo))
        x = np.where(temperature <= 7000.0, warm, cool)
        y = -3.0 * x**2 + 2.87 * x - 0.275
        bottom = 0.0241 + 0.2562 * x - 0.7341 * y
        factors = np.stack(
            [
                np.ones_like(x),
                (-1.3515 - 1.7703 * x + 5.9114 * y) / bottom,
                (0.03 - 31.4424 * x + 30.0717 * y) / bottom,
            ],
            axis=1,
        )
        return self._normalised(np.einsum("nc,ck->nk", factors, self._daylight))

    def blend(self, temperature: NDArray[np.float64], coldest: float, hottest: float) -> NDArray[np.float64]:
        """Black bodies up to one temperature, daylight from another one on, a mixture in between.

        Parameters
        ----------
        temperature : (n,) float64 [K]
        coldest, hottest : float [K]
            Of the mixture, by luminance in proportion to the temperature; a step where both are the same, which belongs
            to daylight.

        Returns
        -------
        (n, k) float64
        """
        share = np.where(temperature >= hottest, 1.0, 0.0)
        between = (temperature > coldest) & (temperature < hottest)
        share[between] = (temperature[between] - coldest) / (hottest - coldest)
        sums = np.zeros((len(temperature), self._weights.shape[1]))
        for part, light in ((1.0 - share, self.planckian), (share, self.daylight)):
            used = part > 0.0
            sums[used] += part[used, None] * light(temperature[used])
        return sums

    def _normalised(self, sums: NDArray[np.float64]) -> NDArray[np.float64]:
        scaled: NDArray[np.float64] = sums / sums[:, self._luminance, None]
        return scaled


def _gauss_nodes(bands: Bands) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Wavelengths [nm] at which to take a smooth density, how many nm each stands for, and the first of each band."""
    pieces = np.ceil(bands.width / _WIDEST - 1e-9).astype(np.int64)
    first = np.cumsum(pieces) - pieces
    width = np.repeat(bands.width / pieces, pieces)
    middle = np.repeat(bands.lower, pieces) + (np.arange(len(width)) - np.repeat(first, pieces) + 0.5) * width
    node = np.stack([middle - _GAUSS * width, middle + _GAUSS * width], axis=1).ravel()
    return node, np.repeat(0.5 * width, 2), 2 * first
