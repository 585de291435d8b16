"""Action spectra of a scene file: what else light is weighted by at each reading."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hradiosity.errors import SceneError
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_light import ActionTable
from hradiosity.io.spectra import read_spectrum_csv
from hradiosity.metrics.truncation import WORTH_TELLING, outside_share
from hradiosity.model.scene import Action
from hradiosity.model.spectrum import Bands


def read_actions(tables: Mapping[str, ActionTable], bands: Bands, report: Report) -> tuple[Action, ...]:
    """All action spectra; what the bands leave out of one is reported as a warning."""
    actions = []
    for name, table in tables.items():
        location: Location = ("actions", name)
        if not (name.isascii() and name.isidentifier()):
            report.fault(location, f"{name!r} can't name a column", "letters, digits and _, no digit first")
        path = report.find_file(table.file, location)
        if path is None:
            continue
        try:
            spectrum = read_spectrum_csv(path, table.column, "power")
        except SceneError as error:
            report.adopt(error, location)
            continue
        if len(spectrum.line_power) or len(spectrum.wavelength) < 2:
            report.fault(location, "has lines, or no table", "weights by wavelength")
            continue
        if not np.any(spectrum.value > 0.0):
            report.fault(location, "all weights are 0", "weights by wavelength, some of them above 0")
            continue
        outside = outside_share(spectrum, bands)
        if outside >= WORTH_TELLING:
            extent = f"{bands.lower[0]:g} to {bands.upper[-1]:g} nm"
            report.warn(
                location,
                f"{100.0 * outside:.3g} % of its weight, for equal-energy light, lies outside the bands ({extent}): "
                f"{name}_w_m2 lacks what light there would bring",
            )
        actions.append(Action(name, spectrum))
    return tuple(actions)
