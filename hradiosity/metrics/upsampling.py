"""Plausible reflectance spectra for colours, where nothing was measured."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hradiosity.model.spectrum import Spectrum

Upsampling = Literal["mallett2019", "otsu2018"]


def upsample_rgb(rgb: ArrayLike, method: Upsampling = "mallett2019") -> Spectrum:
    """Reflectance spectrum that has a given colour under D65.

    Parameters
    ----------
    rgb : (3,) float64
        Linear sRGB, each 0 … 1.
    method : "mallett2019" or "otsu2018"
        Mallett and Yuksel 2019, Spectral Primary Decomposition for Rendering with sRGB Reflectance (smooth, reproduces
        every sRGB colour); Otsu, Yamamoto and Hachisuka 2018, Reproducing Spectral Reflectances From Tristimulus
        Colours (closer to measured paints, clipped where it leaves 0 … 1).

    Returns
    -------
    Spectrum
        Reflectance, 0 … 1. One of infinitely many with this colour: not a measurement.

    Raises
    ------
    ValueError
        When ``rgb`` is no such triple, or the method is unknown.
    """
    triple = np.asarray(rgb, dtype=np.float64)
    if triple.shape != (3,) or not ((triple >= 0) & (triple <= 1)).all():
        raise ValueError(f"a colour is three numbers of linear sRGB from 0 to 1, not {rgb!r}")
    if method not in ("mallett2019", "otsu2018"):
        raise ValueError(f"method must be 'mallett2019' or 'otsu2018', not {method!r}")
    import colour  # 3 s: only when a colour has to be guessed

    with colour.utilities.suppress_warnings(colour_runtime_warnings=True):  # it tells of resampling that is meant
        if method == "mallett2019":
            found = colour.recovery.RGB_to_sd_Mallett2019(triple)
        else:
            tristimulus = colour.RGB_to_XYZ(triple, "sRGB", apply_cctf_decoding=False)
            found = colour.recovery.XYZ_to_sd_Otsu2018(tristimulus)
    return Spectrum(np.asarray(found.wavelengths), np.clip(np.asarray(found.values), 0.0, 1.0))
