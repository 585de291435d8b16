"""Spectra of light sources, brought onto the scene's bands with the luminous flux that belongs to them."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import SceneError
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_light import (
    LightFile,
    LightSpectrum,
    SpectrumBlackbody,
    SpectrumConstant,
    SpectrumIlluminant,
)
from hradiosity.io.spectra import read_spectrum_csv
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Outside, Spectrum, band_integral

_VISIBLE: Final = (360.0, 830.0)
"""Range in which V(λ) is tabulated [nm]."""
_FINE: Final = 2.0
"""Width of the bands that count visible light outside the scene's bands [nm]."""
_HELD: Final = (2.5, 5.0)
"""An end value holds for half a step of its table, but for no less and no more than these [nm]."""


@dataclass(frozen=True)
class Shape:
    """A spectrum of light on the scene's bands.

    power : (n_bands,) float64, power in each band, in the unit of the spectrum times nm
    luminous : what all of the spectrum amounts to in lumens, whether or not the scene's bands hold it
    """

    power: NDArray[np.float64]
    luminous: float


def light_shape(form: LightSpectrum, bands: Bands, location: Location, report: Report) -> Shape:
    """Power in each band; a fault in the report, and equal power, when the spectrum can't be had."""
    found = _spectrum(form, bands, location, report)
    if found is None:
        return _on_bands(Spectrum.constant(1.0), bands, "hold")
    spectrum = _with_half_steps(found)
    outside: Outside = form.outside if isinstance(form, LightFile) else "zero"
    try:
        shape = _on_bands(spectrum, bands, outside)
    except ValueError as error:
        report.fault(location, str(error), "a spectrum that covers all bands, or another `outside`")
        return _on_bands(spectrum, bands, "zero")
    if len(spectrum.wavelength) and band_integral(spectrum, bands, outside).outside_share > 0.0:
        span = f"given from {found.wavelength[0]:g} to {found.wavelength[-1]:g} nm"
        rest = "its end values hold in the bands beyond" if outside == "hold" else "no light in the bands beyond"
        report.inform(location, f"{span}; {rest}")
    _report_lost_lines(spectrum, bands, location, report)
    return shape


def _spectrum(form: LightSpectrum, bands: Bands, location: Location, report: Report) -> Spectrum | None:
    if isinstance(form, LightFile):
        path = report.find_file(form.file, location)
        if path is None:
            return None
        try:
            return read_spectrum_csv(path, form.column, "power")
        except SceneError as error:
            report.adopt(error, location)
            return None
    try:
        if isinstance(form, SpectrumIlluminant):
            return photometry.illuminant(form.illuminant, bands)
        if isinstance(form, SpectrumBlackbody):
            return photometry.blackbody(form.blackbody_K)
    except ValueError as error:
        report.fault(location, str(error), "")
        return None
    if isinstance(form, SpectrumConstant):
        return Spectrum.constant(form.constant)
    wavelength, power = np.array(form.lines).T
    return Spectrum(np.zeros(0), np.zeros(0), wavelength, power)


def _with_half_steps(spectrum: Spectrum) -> Spectrum:
    """The spectrum with its end values held for half a step: a value every 5 nm stands for 5 nm, the last ones too.

    At least 2.5 nm, so that a fine table from 380 to 780 nm fills the first and last of bands that are 5 nm wide.
    """
    if len(spectrum.wavelength) == 0:
        return spectrum
    step = np.clip(0.5 * np.diff(spectrum.wavelength)[[0, -1]], *_HELD)
    step[0] = min(step[0], 0.5 * spectrum.wavelength[0])
    return Spectrum(
        np.concatenate([[spectrum.wavelength[0] - step[0]], spectrum.wavelength, [spectrum.wavelength[-1] + step[1]]]),
        np.concatenate([spectrum.value[:1], spectrum.value, spectrum.value[-1:]]),
        spectrum.line_wavelength,
        spectrum.line_power,
    )


def _on_bands(spectrum: Spectrum, bands: Bands, outside: Outside) -> Shape:
    """Power in the scene's bands, and luminous flux of everything.

    The flux counts each band of the scene with the weight that results have, and what lies between and beyond them
    finely: a lamp's lumens come out in the illuminance, and bands that hold only part of the light don't inflate it.
    """
    power = band_integral(spectrum, bands, outside).value
    luminous = float((power * luminous_weights(bands)).sum())
    rest = _visible_rest(bands)
    if rest is not None:
        beyond: Outside = "hold" if outside == "hold" else "zero"
        luminous += float((band_integral(spectrum, rest, beyond).value * luminous_weights(rest)).sum())
    return Shape(power, luminous)


def _visible_rest(bands: Bands) -> Bands | None:
    """Fine bands that fill the visible range where the scene's bands leave gaps."""
    start = np.maximum(np.concatenate([[_VISIBLE[0]], bands.upper]), _VISIBLE[0])
    end = np.minimum(np.concatenate([bands.lower, [_VISIBLE[1]]]), _VISIBLE[1])
    pairs = [
        np.stack([edges[:-1], edges[1:]], axis=1)
        for low, high in zip(start, end, strict=True)
        if high - low > 1e-6
        for edges in [np.linspace(low, high, int(np.ceil((high - low) / _FINE)) + 1)]
    ]
    return Bands.explicit(np.concatenate(pairs)) if pairs else None


def _report_lost_lines(spectrum: Spectrum, bands: Bands, location: Location, report: Report) -> None:
    wavelength = spectrum.line_wavelength
    lost = wavelength[~((wavelength[:, None] >= bands.lower) & (wavelength[:, None] <= bands.upper)).any(axis=1)]
    if len(lost):
        report.warn(location, f"lines outside the scene's bands give no light: {', '.join(f'{w:g} nm' for w in lost)}")
