"""Materials of a scene file: reflectance in each band."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import SceneError
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_light import (
    MaterialTable,
    Reflectance,
    ReflectanceColour,
    ReflectanceFile,
    ReflectanceLibrary,
    ReflectanceSteps,
)
from hradiosity.io.spectra import read_spectrum_csv
from hradiosity.metrics.upsampling import upsample_rgb
from hradiosity.model import photometry
from hradiosity.model.scene import Material
from hradiosity.model.spectrum import Bands, Spectrum, band_mean

_HELD_SILENTLY: Final = 5.0
"""Bands may reach this far beyond a table without a note [nm]: a table from 380 to 780 nm suits bands around these."""


def read_materials(
    tables: Mapping[str, MaterialTable], names: Names, bands: Bands, report: Report
) -> tuple[Material, ...]:
    """Materials in the order of their names; one that is faulty (and reported) is black, so that reading can go on.

    Those that are guessed from textures come last.
    """
    named = (
        _material(name, tables[name], bands, report) if name in tables else Material(name, np.zeros(len(bands)))
        for name in names.materials
    )
    guessed = (
        Material(name, _tabulated(colour, bands, ("mesh",), report), measured=False)
        for name, colour in names.guessed.items()
    )
    return (*named, *guessed)


def _material(name: str, table: MaterialTable, bands: Bands, report: Report) -> Material:
    found = read_reflectance(table.reflectance, bands, ("materials", name, "reflectance"), report)
    if found is None:
        return Material(name, np.zeros(len(bands)))
    return Material(name, found, table.sides == "both", is_measured(table.reflectance))


def is_measured(form: Reflectance) -> bool:
    """Whether a reflectance is more than a guess from a colour."""
    return not isinstance(form, ReflectanceColour)


def read_reflectance(form: Reflectance, bands: Bands, location: Location, report: Report) -> NDArray[np.float64] | None:
    """(n_bands,) reflectance; None where it is faulty, which is reported."""
    if isinstance(form, float):
        reflectance = np.full(len(bands), form)
    elif isinstance(form, ReflectanceSteps):
        reflectance = _steps_mean(form.steps, bands, location, report)
    else:
        reflectance = _tabulated(form, bands, location, report)
    if not is_measured(form):
        report.warn(location, "guessed from a colour, not measured: spectra and colours of the light are guesses too")
    return reflectance if _is_plausible(reflectance, bands, location, report) else None


def _tabulated(
    form: ReflectanceFile | ReflectanceLibrary | ReflectanceColour, bands: Bands, location: Location, report: Report
) -> NDArray[np.float64]:
    """Reflectance from a table of wavelengths; zeros and a fault if there is none."""
    spectrum = _spectrum(form, location, report)
    if spectrum is None:
        return np.zeros(len(bands))
    try:
        binned = band_mean(spectrum, bands, form.outside if isinstance(form, ReflectanceFile) else "hold")
    except ValueError as error:
        report.fault(location, str(error), "a spectrum that covers all bands, or outside = 'hold'")
        return np.zeros(len(bands))
    low, high = spectrum.wavelength[0], spectrum.wavelength[-1]
    if bands.lower[0] < low - _HELD_SILENTLY or bands.upper[-1] > high + _HELD_SILENTLY:
        report.inform(location, f"given from {low:g} to {high:g} nm; its end values hold in the bands beyond")
    return binned.value


def _spectrum(
    form: ReflectanceFile | ReflectanceLibrary | ReflectanceColour, location: Location, report: Report
) -> Spectrum | None:
    if isinstance(form, ReflectanceFile):
        path = report.find_file(form.file, location)
        if path is None:
            return None
        try:
            return read_spectrum_csv(path, form.column, "reflectance")
        except SceneError as error:
            report.adopt(error, location)
            return None
    try:
        if isinstance(form, ReflectanceLibrary):
            return photometry.reflectance(form.library)
        return upsample_rgb(form.rgb, form.upsample)
    except ValueError as error:
        report.fault(location, str(error), "")
        return None


def _steps_mean(
    steps: list[tuple[float, float, float]], bands: Bands, location: Location, report: Report
) -> NDArray[np.float64]:
    """Mean over each band of a function that is constant between edges; the first and last value hold beyond."""
    low, high, value = np.array(steps).T
    if not ((high > low).all() and np.array_equal(low[1:], high[:-1])):
        report.fault((*location, "steps"), str(steps), "[from, to, value] rows that ascend, without gap or overlap")
        return np.zeros(len(bands))
    low[0], high[-1] = min(low[0], bands.lower[0]), max(high[-1], bands.upper[-1])
    overlap = np.minimum(bands.upper[:, None], high) - np.maximum(bands.lower[:, None], low)
    mean: NDArray[np.float64] = np.einsum("bs,s->b", np.maximum(overlap, 0.0), value) / bands.width
    # The quotient may round past the values that it is a mean of, and a reflectance past 1 would be refused.
    return np.clip(mean, value.min(), value.max())


def _is_plausible(reflectance: NDArray[np.float64], bands: Bands, location: Location, report: Report) -> bool:
    """Whether all values lie in 0 … 1; if not, the worst one is reported."""
    wrong = (reflectance < 0.0) | (reflectance > 1.0)
    if not wrong.any():
        return True
    worst = int(np.argmax(np.where(wrong, np.abs(reflectance - 0.5), -1.0)))
    where = "" if np.ptp(reflectance) == 0.0 else f" at {bands.centre[worst]:g} nm"
    percent = 1.0 < reflectance.max() <= 100.0 and reflectance.min() >= 0.0
    hint = f"; it looks like percent: write {reflectance[worst] / 100:g}" if percent else ""
    report.fault(location, f"reflectance {reflectance[worst]:g}{where}", f"0 to 1{hint}")
    return False
