"""``sensitivity.csv``: how much readings change with what the scene states."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from hradiosity.io.output_folder import write_file
from hradiosity.radiosity.sensitivity import Sensitivities

SENSITIVITY_FILE = "sensitivity.csv"
SENSITIVITY_COLUMNS = ("sensor", "index", "kind", "name", "sensitivity", "sensitivity_half_width")
"""Relative change of the illuminance over that of the parameter."""


def write_sensitivity(folder: Path, found: Sensitivities) -> None:
    """Write the table; raises `OutputError` when that can't be done."""
    write_file(folder / SENSITIVITY_FILE, sensitivity_table(found))


def sensitivity_table(found: Sensitivities) -> bytes:
    """One row a reading and parameter; blank for readings without light."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(SENSITIVITY_COLUMNS)
    for sensor, parameters in found.items():
        n_readings = max((len(s.value) for s in parameters.values()), default=0)
        for index in range(n_readings):
            for parameter, sensitivity in parameters.items():
                numbers = (float(sensitivity.value[index]), float(sensitivity.half_width[index]))
                cells = ("" if np.isnan(number) else f"{number + 0.0:.9g}" for number in numbers)
                writer.writerow([sensor, index, parameter.kind, parameter.name, *cells])
    return text.getvalue().encode()


def sensitivity_record(found: Sensitivities) -> dict[str, Any]:
    """For ``run.json``: sensitivities of each sensor's mean illuminance."""
    return {
        sensor: [
            {"kind": p.kind, "name": p.name, "mean": s.mean, "mean_half_width": s.mean_half_width}
            for p, s in parameters.items()
        ]
        for sensor, parameters in found.items()
    }
