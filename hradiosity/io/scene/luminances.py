"""Luminance sensors of a scene file."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report, did_you_mean
from hradiosity.io.scene.schema_sensors import LuminanceSensor
from hradiosity.io.scene.unit_vectors import unit_vectors
from hradiosity.model.looking import luminance_sensor, pixel_directions
from hradiosity.model.scene import Scene, Sensor, View

USUAL_RAYS: Final = (8, 8)
MOST_LINES: Final = 65_536
"""Most rays of one sensor."""


def read_luminances(
    table: LuminanceSensor, location: Location, scene: Scene, frame: Frame, report: Report
) -> Sensor | None:
    """The sensor; None, and a fault, where there is something wrong with it, or with the surfaces that it looks at."""
    if table.view is not None:
        return _of_view(table, location, scene, report)
    eye = frame.points(table.eye or (0.0, 0.0, 0.0))
    if table.targets is not None:
        directions = unit_vectors(frame.points(table.targets) - eye, (*location, "targets"), report)
    else:
        directions = unit_vectors(frame.directions(table.directions or []), (*location, "directions"), report)
    return _sensor(table.name, eye, directions, 1, directions, scene, report)


def _of_view(table: LuminanceSensor, location: Location, scene: Scene, report: Report) -> Sensor | None:
    view = next((view for view in scene.views if view.name == table.view), None)
    if view is None:
        names = [view.name for view in scene.views]
        report.fault((*location, "view"), f"no view {table.view!r}", did_you_mean(str(table.view), names))
        return None
    columns, rows = table.rays or USUAL_RAYS
    if columns * rows > MOST_LINES:
        report.fault((*location, "rays"), f"{columns * rows} rays", f"{MOST_LINES} at most")
        return None
    pixels = table.pixels or (0.0, 0.0, float(view.width), float(view.height))
    if not _is_rectangle(pixels, view):
        report.fault(
            (*location, "pixels"),
            f"{list(pixels)} is no rectangle of the picture",
            f"left < right ≤ {view.width} and top < bottom ≤ {view.height}",
        )
        return None
    directions = pixel_directions(view, pixels, columns, rows)
    middle = pixel_directions(view, pixels, 1, 1)
    return _sensor(table.name, view.position, directions, columns * rows, middle, scene, report)


def _is_rectangle(pixels: tuple[float, float, float, float], view: View) -> bool:
    left, top, right, bottom = pixels
    return left < right <= view.width and top < bottom <= view.height


def _sensor(
    name: str,
    eye: NDArray[np.float64],
    directions: NDArray[np.float64],
    count: int,
    towards: NDArray[np.float64],
    scene: Scene,
    report: Report,
) -> Sensor | None:
    """Only in a scene without faults are there surfaces to look at."""
    return None if report.faults else luminance_sensor(name, eye, directions, count, towards, scene)
