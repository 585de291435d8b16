"""Sensors and views of a scene file."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.pieces import Surfaces
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_sensors import EyeSensor, GridSensor, PointsSensor, SensorTable, ViewTable
from hradiosity.io.scene.surface_points import is_reasonable, surface_sensor
from hradiosity.model.scene import Sensor, View

_UP: Final = np.array([0.0, 0.0, 1.0])


def read_sensors(
    tables: Sequence[SensorTable], surfaces: Surfaces | None, frame: Frame, report: Report
) -> tuple[Sensor, ...]:
    """All sensors in metres, z up; without surfaces (faulty ones) those on surfaces are left out."""
    sensors = []
    seen: set[str] = set()
    for i, table in enumerate(tables):
        location: Location = ("sensor", i)
        if table.name in seen:
            report.fault((*location, "name"), f"a second sensor named {table.name!r}", "a name of its own")
        seen.add(table.name)
        sensor: Sensor | None
        if isinstance(table, PointsSensor):
            sensor = _points_sensor(table, location, frame, report)
        elif isinstance(table, GridSensor):
            sensor = _grid_sensor(table, location, frame, report)
        elif isinstance(table, EyeSensor):
            sensor = _eye_sensor(table, location, frame, report)
        else:
            sensor = surface_sensor(table, location, surfaces, frame, report) if surfaces is not None else None
        if sensor is not None:
            sensors.append(sensor)
    return tuple(sensors)


def unit_vectors(vectors: ArrayLike, location: Location, report: Report) -> NDArray[np.float64]:
    """(n, 3) vectors at length 1; one without direction is reported and points up."""
    array = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    length = np.linalg.norm(array, axis=1, keepdims=True)
    for number in np.flatnonzero(length[:, 0] == 0.0):
        which = f"vector {number} " if len(array) > 1 else ""
        report.fault(location, f"{which}[0, 0, 0] has no direction", "a vector with a length")
    return np.where(length > 0.0, array / np.where(length > 0.0, length, 1.0), _UP)


def _one_for_each(
    vectors: Sequence[Sequence[float]], n: int, location: Location, frame: Frame, report: Report
) -> NDArray[np.float64]:
    """(n, 3) unit vectors from a list that must have n of them."""
    if len(vectors) != n:
        report.fault(location, f"{len(vectors)} directions for {n} positions", "one for each position")
        return np.tile(_UP, (n, 1))
    return unit_vectors(frame.directions(vectors), location, report)


def _points_sensor(table: PointsSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    position = frame.points(table.positions)
    n = len(position)
    if table.normals is not None:
        return Sensor(table.name, position, _one_for_each(table.normals, n, (*location, "normals"), frame, report))
    normal = unit_vectors(frame.directions(table.normal or (0.0, 0.0, 0.0)), (*location, "normal"), report)
    return Sensor(table.name, position, np.repeat(normal, n, axis=0))


def _grid_sensor(table: GridSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    corner, edge_u, edge_v = frame.points([table.corner, table.edge_u, table.edge_v])
    across = np.cross(edge_u, edge_v)
    if np.linalg.norm(across) <= 1e-9 * np.linalg.norm(edge_u) * np.linalg.norm(edge_v):
        report.fault(location, "edge_u and edge_v span no area", "two edges that are neither zero nor parallel")
        across = _UP
    direction = across if table.normal is None else frame.directions(table.normal)
    normal = unit_vectors(direction, (*location, "normal"), report)
    n_u, n_v = table.counts if is_reasonable(table.counts[0] * table.counts[1], location, report) else (1, 1)
    v, u = np.meshgrid((np.arange(n_v) + 0.5) / n_v, (np.arange(n_u) + 0.5) / n_u, indexing="ij")
    position = corner + u.reshape(-1, 1) * edge_u + v.reshape(-1, 1) * edge_v + frame.length(table.height) * normal
    return Sensor(table.name, position, np.repeat(normal, n_u * n_v, axis=0), (n_v, n_u))


def _eye_sensor(table: EyeSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    position = frame.points(table.positions) + frame.length(table.eye_height) * _UP
    n = len(position)
    if table.gazes is not None:
        return Sensor(table.name, position, _one_for_each(table.gazes, n, (*location, "gazes"), frame, report))
    if table.target is not None:
        gaze = unit_vectors(frame.points(table.target) - position, (*location, "target"), report)
        return Sensor(table.name, position, gaze)
    gaze = unit_vectors(frame.directions(table.gaze or (0.0, 0.0, 0.0)), (*location, "gaze"), report)
    return Sensor(table.name, position, np.repeat(gaze, n, axis=0))


def read_views(tables: Sequence[ViewTable], frame: Frame, report: Report) -> tuple[View, ...]:
    """All cameras in metres, z up."""
    seen: set[str] = set()
    views = []
    for i, table in enumerate(tables):
        location: Location = ("view", i)
        if table.name in seen:
            report.fault((*location, "name"), f"a second view named {table.name!r}", "a name of its own")
        seen.add(table.name)
        views.append(_view(table, location, frame, report))
    return tuple(views)


def _view(table: ViewTable, location: Location, frame: Frame, report: Report) -> View:
    position = frame.points(table.position)
    if table.target is not None:
        direction = unit_vectors(frame.points(table.target) - position, (*location, "target"), report)[0]
    else:
        wanted = frame.directions(table.direction or (0.0, 0.0, 0.0))
        direction = unit_vectors(wanted, (*location, "direction"), report)[0]
    if table.up is None:
        # Straight up or down has no upright picture: then +y is up, as on a plan.
        up = _UP if abs(direction[2]) < 1.0 - 1e-9 else np.array([0.0, 1.0, 0.0])
    else:
        up = unit_vectors(frame.directions(table.up), (*location, "up"), report)[0]
        if np.linalg.norm(np.cross(up, direction)) <= 1e-9:
            report.fault((*location, "up"), "is along the line of sight", "another direction, or none")
    width, height = table.size
    return View(table.name, position, direction, up, table.field_of_view_deg, width, height)
