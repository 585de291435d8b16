"""Test colours of colour rendering and the components of daylight, as tables inside the package.

``tables.npz`` is made by ``examples/make_sample_data.py`` from colour-science.
"""

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Table = tuple[NDArray[np.float64], NDArray[np.float64]]


@cache
def _tables() -> dict[str, NDArray[np.float64]]:
    """All tables by name; read once."""
    with np.load(Path(__file__).with_name("tables.npz")) as stored:
        return {name: np.asarray(stored[name], np.float64) for name in stored.files}


def rendering_samples() -> Table:
    """The 14 test colours of CIE 13.3-1995: eight moderate ones, four saturated ones, skin and leaf.

    Returns
    -------
    wavelength : (95,) float64 [nm], 360–830 in 5 nm
    reflectance : (95, 14) float64
    """
    return _tables()["cie13.3/wavelength"], _tables()["cie13.3/reflectance"]


def fidelity_samples() -> Table:
    """The 99 colour evaluation samples of CIE 224:2017 and ANSI/IES TM-30.

    Returns
    -------
    wavelength : (401,) float64 [nm], 380–780 in 1 nm
    reflectance : (401, 99) float64
    """
    return _tables()["cie224/wavelength"], _tables()["cie224/reflectance"]


def daylight_components() -> Table:
    """Mean and two characteristic vectors of daylight, S₀, S₁, S₂ of CIE 15:2018; linear in between.

    Returns
    -------
    wavelength : (107,) float64 [nm], 300–830 in 5 nm
    power : (107, 3) float64, relative power per nm
    """
    return _tables()["daylight/wavelength"], _tables()["daylight/power"]
