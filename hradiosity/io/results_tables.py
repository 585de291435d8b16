"""``readings.csv``, ``spectra.csv`` and ``spectra_half_width.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import xyz
from hradiosity.metrics.temperature import colour_temperature
from hradiosity.model.spectrum import Bands
from hradiosity.solution import Readings

PLACE_COLUMNS = ("sensor", "index", "x", "y", "z", "nx", "ny", "nz")
"""Of ``readings.csv``: metres, unit vectors (of a cylinder its axis)."""
LIGHT_COLUMNS = (
    *("illuminance_lx", "illuminance_half_width_lx"),
    *("cie_x", "cie_y", "cie_x_half_width", "cie_y_half_width"),
)
"""Lux, CIE 1931 chromaticity; half widths are those of 95 % intervals. Colour and eye numbers follow."""
LUMINANCE_COLUMNS = ("luminance_cd_m2", "luminance_half_width_cd_m2", *LIGHT_COLUMNS[2:])
"""Of ``luminances.csv``, in place of `LIGHT_COLUMNS`; x, y, z are the eye, nx, ny, nz the direction of looking."""
LEVELS = (0.5, 0.8)
"""Of further intervals of the illuminance, in ``readings.csv``."""
MAINTAINED_COLUMNS = ("maintained_illuminance_lx", "maintained_illuminance_half_width_lx")
REASON_COLUMN = "cct_reason"
"""Why there is no colour temperature, a number: see `hradiosity.metrics.temperature.REASONS`; 0 where there is one."""
_UNITS = ("_lx", "_k", "_w_m2", "_cd_m2")
_OF_EYES = ("_edi_lx", "_der")


def irradiances(readings: Mapping[str, Readings]) -> dict[str, Readings]:
    """Those that are light on something, and not light that is looked at."""
    return {name: found for name, found in readings.items() if found.kind != "luminance"}


def luminances(readings: Mapping[str, Readings]) -> dict[str, Readings]:
    """The others."""
    return {name: found for name, found in readings.items() if found.kind == "luminance"}


def readings_table(
    readings: Mapping[str, Readings],
    bands: Bands,
    *,
    parts: bool = False,
    maintained: Mapping[str, Readings] | None = None,
) -> bytes:
    """``readings.csv``: one row a reading of irradiance; a number that is not defined stays blank.

    Parameters
    ----------
    parts : bool
        With what the half width of the illuminance is made of, one column a part.
    maintained : mapping, optional
        The same readings with what lamps have left before maintenance.
    """
    readings = irradiances(readings)
    some = next(iter(readings.values()), None)
    derived = () if some is None else some.derived
    named = () if some is None or not parts else tuple(some.numbers["illuminance"].parts)
    columns = (
        *PLACE_COLUMNS,
        *LIGHT_COLUMNS,
        *(f"illuminance_half_width_{100.0 * level:.0f}_percent_lx" for level in LEVELS),
        *(f"illuminance_half_width_{part}_lx" for part in named),
        *_with_half_widths(derived),
        *(MAINTAINED_COLUMNS if maintained else ()),
        REASON_COLUMN,
    )
    kept = maintained or {}
    rows = (
        (name, _reading_rows(found, bands, derived, levels=LEVELS, parts=named, maintained=kept.get(name)))
        for name, found in readings.items()
    )
    return csv_table(columns, rows)


def luminances_table(readings: Mapping[str, Readings], bands: Bands) -> bytes:
    """``luminances.csv``: one row a reading of radiance; what belongs to light at the eye is left out."""
    readings = luminances(readings)
    some = next(iter(readings.values()), None)
    derived = () if some is None else tuple(name for name in some.derived if not name.endswith(_OF_EYES))
    columns = (*PLACE_COLUMNS, *LUMINANCE_COLUMNS, *_with_half_widths(derived), REASON_COLUMN)
    return csv_table(columns, ((name, _reading_rows(found, bands, derived)) for name, found in readings.items()))


def temperature_reasons(found: Readings, bands: Bands) -> NDArray[np.uint8]:
    """(n,) why each reading has no colour temperature, see `hradiosity.metrics.temperature.REASONS`."""
    return colour_temperature(xyz(found.irradiance, bands)).reason


def half_width_column(name: str) -> str:
    """Column of a number's half width: its name with the unit kept at the end."""
    unit = next((unit for unit in _UNITS if name.endswith(unit)), "")
    return f"{name.removesuffix(unit)}_half_width{unit}"


def _with_half_widths(names: Iterable[str]) -> list[str]:
    return [column for name in names for column in (name, half_width_column(name))]


def _reading_rows(
    found: Readings,
    bands: Bands,
    derived: Sequence[str],
    *,
    levels: Sequence[float] = (),
    parts: Sequence[str] = (),
    maintained: Readings | None = None,
) -> NDArray[np.float64]:
    """(n, n_columns) numbers of a sensor, from position on."""
    numbers = found.numbers
    later = () if maintained is None else (maintained.illuminance, maintained.illuminance_half_width)
    return np.column_stack(
        [
            *(found.position, found.normal),
            *(found.illuminance, found.illuminance_half_width),
            *(found.chromaticity, found.chromaticity_half_width),
            *(numbers["illuminance"].half_width_at(level) for level in levels),
            *(numbers["illuminance"].parts[part] for part in parts),
            *(column for name in derived for column in (numbers[name].value, numbers[name].half_width)),
            *later,
            temperature_reasons(found, bands),
        ]
    )


def spectra_table(
    readings: Mapping[str, Readings], bands: Bands, *, half_width: bool = False, looked_at: bool = False
) -> bytes:
    """``spectra.csv``, or ``spectra_half_width.csv``: spectral irradiance [W m⁻² nm⁻¹], one column a band.

    The header of a band is its centre [nm]. With `looked_at`, ``radiances.csv``: spectral radiance
    [W m⁻² sr⁻¹ nm⁻¹] of luminance sensors.
    """
    columns = ("sensor", "index", *(f"{centre:.10g}" for centre in bands.centre))
    some = luminances(readings) if looked_at else irradiances(readings)
    return csv_table(
        columns,
        ((name, (found.half_width if half_width else found.irradiance) / bands.width) for name, found in some.items()),
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
