"""Lights that several tests look at."""

import numpy as np

from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, band_integral
from hradiosity.suites.validation.data import colour_values

EXPECTED = colour_values()
TOLERANCE = EXPECTED["tolerances"]
USUAL = Bands.uniform()
FINE = Bands.uniform(361, 829, 2)
EVERY_NM = Bands.uniform(380, 780, 1)


def power_of(name, bands=USUAL):
    """(1, n_bands) of an illuminant or, as ``Planck2700``, of a black body."""
    planck = name.startswith("Planck")
    spectrum = photometry.blackbody(float(name[6:])) if planck else photometry.illuminant(name, bands)
    return band_integral(spectrum, bands, "hold").value[None]


def random_mixtures(count, bands=USUAL, seed=3):
    """(count, n_bands) sums of two illuminants with something smooth on top, of any brightness."""
    rng = np.random.default_rng(seed)
    lamps = [name for name in photometry.illuminant_names() if not name.startswith(("HP1", "LED-RGB"))]
    powers = np.concatenate([power_of(name, bands) for name in lamps])
    powers /= powers.sum(axis=1, keepdims=True)
    mixed = np.einsum(
        "np,npb->nb", rng.uniform(0.1, 1.0, (count, 2)), powers[rng.integers(len(lamps), size=(count, 2))]
    )
    wave = np.sin(bands.centre / rng.uniform(30.0, 120.0, (count, 1)) + rng.uniform(0.0, 6.0, (count, 1)))
    return rng.uniform(0.1, 1e4, (count, 1)) * mixed * (1.0 + 0.4 * wave)
