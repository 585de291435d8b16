"""``readings.csv``, ``spectra.csv`` and ``spectra_half_width.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.spectrum import Bands
from hradiosity.solution import Readings

PLACE_COLUMNS = ("sensor", "index", "x", "y", "z", "nx", "ny", "nz")
"""Of ``readings.csv``: metres, unit vectors."""
LIGHT_COLUMNS = (
    *("illuminance_lx", "illuminance_half_width_lx"),
    *("cie_x", "cie_y", "cie_x_half_width", "cie_y_half_width"),
)
"""Lux, CIE 1931 chromaticity; half widths are those of 95 % intervals. Colour and eye numbers follow."""
_UNITS = ("_lx", "_k")


def readings_table(readings: Mapping[str, Readings], *, parts: bool = False) -> bytes:
    """``readings.csv``: one row a reading; a number that is not defined stays blank.

    Parameters
    ----------
    parts : bool
        With what the half width of the illuminance is made of, one column a part.
    """
    some = next(iter(readings.values()), None)
    derived = () if some is None else some.derived
    named = () if some is None or not parts else tuple(some.numbers["illuminance"].parts)
    columns = (
        *PLACE_COLUMNS,
        *LIGHT_COLUMNS,
        *(f"illuminance_half_width_{part}_lx" for part in named),
        *(column for name in derived for column in (name, half_width_column(name))),
    )
    return csv_table(columns, ((name, _reading_rows(found, named)) for name, found in readings.items()))


def half_width_column(name: str) -> str:
    """Column of a number's half width: its name with the unit kept at the end."""
    unit = next((unit for unit in _UNITS if name.endswith(unit)), "")
    return f"{name.removesuffix(unit)}_half_width{unit}"


def _reading_rows(found: Readings, parts: Sequence[str]) -> NDArray[np.float64]:
    """(n, n_columns) numbers of a sensor, from position on."""
    numbers = found.numbers
    return np.column_stack(
        [
            *(found.position, found.normal),
            *(found.illuminance, found.illuminance_half_width),
            *(found.chromaticity, found.chromaticity_half_width),
            *(numbers["illuminance"].parts[part] for part in parts),
            *(column for name in found.derived for column in (numbers[name].value, numbers[name].half_width)),
        ]
    )


def spectra_table(readings: Mapping[str, Readings], bands: Bands, *, half_width: bool = False) -> bytes:
    """``spectra.csv``, or ``spectra_half_width.csv``: spectral irradiance [W m⁻² nm⁻¹], one column a band.

    The header of a band is its centre [nm].
    """
    columns = ("sensor", "index", *(f"{centre:.10g}" for centre in bands.centre))
    return csv_table(
        columns,
        (
            (name, (found.half_width if half_width else found.irradiance) / bands.width)
            for name, found in readings.items()
        ),
    )


def csv_table(columns: Sequence[str], parts: Iterable[tuple[str, NDArray[np.float64]]]) -> bytes:
    """CSV text, UTF-8: name of the sensor, index in it, numbers, blank for NaN; adding 0 turns −0 into 0."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for name, numbers in parts:
        for index, row in enumerate((numbers + 0.0).tolist()):
            writer.writerow([name, index, *("" if value != value else f"{value:.9g}" for value in row)])
    return text.getvalue().encode()
