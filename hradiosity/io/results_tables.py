"""``readings.csv``, ``spectra.csv`` and ``spectra_half_width.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.spectrum import Bands
from hradiosity.solution import Readings

READING_COLUMNS = (
    *("sensor", "index", "x", "y", "z", "nx", "ny", "nz"),
    *("illuminance_lx", "illuminance_half_width_lx"),
    *("cie_x", "cie_y", "cie_x_half_width", "cie_y_half_width"),
)
"""Of ``readings.csv``: metres, unit vectors, lux, CIE 1931 chromaticity; half widths are those of 95 % intervals."""


def readings_table(readings: Mapping[str, Readings]) -> bytes:
    """``readings.csv``: one row a reading."""
    return _table(
        READING_COLUMNS,
        (
            (
                name,
                np.column_stack(
                    [
                        *(found.position, found.normal),
                        *(found.illuminance, found.illuminance_half_width),
                        *(found.chromaticity, found.chromaticity_half_width),
                    ]
                ),
            )
            for name, found in readings.items()
        ),
    )


def spectra_table(readings: Mapping[str, Readings], bands: Bands, *, half_width: bool = False) -> bytes:
    """``spectra.csv``, or ``spectra_half_width.csv``: spectral irradiance [W m⁻² nm⁻¹], one column a band.

    The header of a band is its centre [nm].
    """
    columns = ("sensor", "index", *(f"{centre:.10g}" for centre in bands.centre))
    return _table(
        columns,
        (
            (name, (found.half_width if half_width else found.irradiance) / bands.width)
            for name, found in readings.items()
        ),
    )


def _table(columns: Sequence[str], parts: Iterable[tuple[str, NDArray[np.float64]]]) -> bytes:
    """CSV text, UTF-8: name of the sensor, index in it, numbers; adding 0 turns −0 into 0."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for name, numbers in parts:
        for index, row in enumerate((numbers + 0.0).tolist()):
            writer.writerow([name, index, *(f"{value:.9g}" for value in row)])
    return text.getvalue().encode()
