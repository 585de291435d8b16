"""How much each band counts when light is weighted by an action spectrum."""

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.spectrum import Bands, Spectrum, band_mean


def band_weights(action: Spectrum, bands: Bands) -> NDArray[np.float64]:
    """Weights of power per band, so that ``power @ weights`` is the integral of power density times action spectrum.

    Inside a band the density is taken as linear: its mean from the band itself, its slope from the two neighbours when
    they touch it (as second-order finite volume schemes do). The sum is exact for uniform and for linear densities on
    even bands, and its error falls with the fourth power of the width for smooth ones; with the mean of the action
    spectrum alone it would be the second power, which is 0.4 % of the illuminance of a blue LED in 5 nm bands.

    Parameters
    ----------
    action : Spectrum
        Zero where it isn't tabulated.
    bands : Bands

    Returns
    -------
    (n_bands,) float64
        In the unit of the action spectrum, none negative.
    """
    centre, width = bands.centre, bands.width
    low = band_mean(action, Bands(bands.lower, centre), "zero").value
    high = band_mean(action, Bands(centre, bands.upper), "zero").value
    weights = 0.5 * (low + high)
    touches = bands.upper[:-1] == bands.lower[1:]
    inner = np.flatnonzero(touches[:-1] & touches[1:]) + 1
    moment = width[inner] ** 2 * (high[inner] - low[inner]) / 6  # of the action spectrum about the band's centre
    per_density = moment / (centre[inner + 1] - centre[inner - 1])
    np.add.at(weights, inner + 1, per_density / width[inner + 1])
    np.add.at(weights, inner - 1, -per_density / width[inner - 1])
    return np.maximum(weights, 0.0)
