"""``variants/NAME/``: what is read of a scene's variants, and how it differs from the scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import OutputError
from hradiosity.io.output_folder import reason, write_file
from hradiosity.io.results_tables import (
    PLACE_COLUMNS,
    csv_table,
    half_width_column,
    irradiances,
    luminances,
    luminances_table,
    readings_table,
    spectra_table,
)
from hradiosity.io.run_record import sensor_record
from hradiosity.solution import Differences, Solution

VARIANTS_FOLDER = "variants"
_UNITS = ("_lx", "_k", "_w_m2")


def write_variants(folder: Path, solution: Solution, *, parts: bool = False) -> None:
    """Write a folder for each variant into that of a result; nothing for a scene without variants.

    Parameters
    ----------
    parts : bool
        With what the half widths of the illuminances are made of.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    for name, variant in solution.variants.items():
        own = folder / VARIANTS_FOLDER / name
        try:
            own.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{own} can't be made: {reason(error)}") from error
        bands = solution.scene.bands
        write_file(own / "readings.csv", readings_table(variant.readings, bands, parts=parts))
        write_file(own / "spectra.csv", spectra_table(variant.readings, bands))
        if luminances(variant.readings):
            write_file(own / "luminances.csv", luminances_table(variant.readings, bands))
        told = {sensor: variant.differences[sensor] for sensor in irradiances(variant.readings)}
        write_file(own / "differences.csv", differences_table(told))


def differences_table(differences: Mapping[str, Differences]) -> bytes:
    """``differences.csv``: variant − scene, one row a reading; a difference that is not defined stays blank."""
    some = next(iter(differences.values()), None)
    names = (
        "illuminance_difference_lx",
        "relative_illuminance_difference",
        *("cie_x_difference", "cie_y_difference"),
        *(() if some is None else map(_difference_column, some.derived)),
    )
    columns = (*PLACE_COLUMNS, *(column for name in names for column in (name, half_width_column(name))))
    return csv_table(columns, ((name, _rows(found)) for name, found in differences.items()))


def variants_record(solution: Solution) -> dict[str, Any]:
    """For ``run.json``: by variant and sensor, the variant's numbers as a whole and their differences."""
    return {
        name: {
            sensor: sensor_record(found) | {"difference": _sensor_differences(variant.differences[sensor])}
            for sensor, found in variant.readings.items()
        }
        for name, variant in solution.variants.items()
    }


def _sensor_differences(found: Differences) -> dict[str, float]:
    columns = {
        "mean_illuminance_lx": "mean_illuminance",
        "relative_mean_illuminance": "relative_mean_illuminance",
        "uniformity": "uniformity",
        "diversity": "diversity",
    }
    numbers = {column: found.numbers[name] for column, name in columns.items()}
    return {
        key: float(value)
        for column, number in numbers.items()
        for key, value in ((column, number.value), (half_width_column(column), number.half_width))
    }


def _difference_column(name: str) -> str:
    """A number's name with the unit kept at the end."""
    unit = next((unit for unit in _UNITS if name.endswith(unit)), "")
    return f"{name.removesuffix(unit)}_difference{unit}"


def _rows(found: Differences) -> NDArray[np.float64]:
    """(n, n_columns) numbers of a sensor, from position on."""
    numbers = found.numbers
    chromaticity = numbers["chromaticity"]
    pairs = [
        *((number.value, number.half_width) for number in (numbers["illuminance"], numbers["relative_illuminance"])),
        *((chromaticity.value[:, axis], chromaticity.half_width[:, axis]) for axis in range(2)),
        *((numbers[name].value, numbers[name].half_width) for name in found.derived),
    ]
    return np.column_stack([found.position, found.normal, *(column for pair in pairs for column in pair)])
