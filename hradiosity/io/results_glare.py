"""``glare.csv`` and ``glare_sources.csv``: UGR at observers, and the luminaires that it counts."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hradiosity.model.scene import Scene
from hradiosity.readings.glare import Glare

COLUMNS = (
    *("sensor", "index", "x", "y", "z", "gaze_x", "gaze_y", "gaze_z"),
    *("ugr", "ugr_half_width", "background_cd_m2", "sources", "blank_because"),
)
SOURCE_COLUMNS = (
    *("sensor", "index", "object", "luminance_cd_m2", "solid_angle_sr", "position_index", "illuminance_lx"),
    *("share_of_sum", "refused_because"),
)


def glare_table(scene: Scene, found: Mapping[str, Glare]) -> bytes:
    """``glare.csv``: a row an observer; UGR stays blank where it is not valid, with the reason."""
    rows: list[list[Any]] = []
    for sensor in scene.sensors:
        if sensor.name not in found:
            continue
        glare = found[sensor.name]
        for i in range(sensor.n_readings):
            numbers = [*sensor.place[i], *sensor.direction[i], glare.ugr[i], glare.half_width[i], glare.background[i]]
            rows.append([sensor.name, i, *map(_text, numbers), len(glare.sources.of(i)), glare.reason[i]])
    return _csv(COLUMNS, rows)


def sources_table(scene: Scene, found: Mapping[str, Glare]) -> bytes:
    """``glare_sources.csv``: a row for each observer and luminaire that it sees."""
    rows: list[list[Any]] = []
    for name, glare in found.items():
        sources = glare.sources
        part = sources.luminance**2 * sources.solid_angle / sources.position_index**2
        for row in range(len(sources.observer)):
            observer = int(sources.observer[row])
            total = float(np.nansum(part[sources.of(observer)]))
            numbers = [
                *(sources.luminance[row], sources.solid_angle[row], sources.position_index[row]),
                *(sources.illuminance[row], part[row] / total if total > 0.0 else np.nan),
            ]
            label = scene.objects[int(sources.object[row])]
            rows.append([name, observer, label, *map(_text, numbers), sources.doubt(row)])
    return _csv(SOURCE_COLUMNS, rows)


def _text(value: float) -> str:
    return f"{value + 0.0:.9g}" if np.isfinite(value) else ""


def _csv(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()
