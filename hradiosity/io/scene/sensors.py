"""Sensors and views of a scene file."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.luminances import read_luminances
from hradiosity.io.scene.pieces import Surfaces
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_sensors import (
    Curved,
    EyeSensor,
    GridSensor,
    LuminanceSensor,
    PointsSensor,
    SensorTable,
    ViewTable,
)
from hradiosity.io.scene.surface_points import is_reasonable, surface_sensor
from hradiosity.io.scene.unit_vectors import UP, unit_vectors
from hradiosity.model.grid_spacing import grid_counts
from hradiosity.model.scene import Scene, Sensor, View
from hradiosity.model.sensor_kinds import FieldOfView, curved_sensor, masked_eyes


def read_sensors(
    tables: Sequence[SensorTable], surfaces: Surfaces | None, scene: Scene, frame: Frame, report: Report
) -> tuple[Sensor, ...]:
    """All sensors in metres, z up; without surfaces (faulty ones) those on surfaces are left out.

    Parameters
    ----------
    scene : Scene
        Without its sensors: what luminance sensors look at.
    """
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
        elif isinstance(table, LuminanceSensor):
            sensor = read_luminances(table, location, scene, frame, report)
        else:
            sensor = surface_sensor(table, location, surfaces, frame, report) if surfaces is not None else None
        if sensor is not None:
            sensors.append(sensor)
    return tuple(sensors)


def _one_for_each(
    vectors: Sequence[Sequence[float]], n: int, location: Location, frame: Frame, report: Report
) -> NDArray[np.float64]:
    """(n, 3) unit vectors from a list that must have n of them."""
    if len(vectors) != n:
        report.fault(location, f"{len(vectors)} directions for {n} positions", "one for each position")
        return np.tile(UP, (n, 1))
    return unit_vectors(frame.directions(vectors), location, report)


def _points_sensor(table: PointsSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    position = frame.points(table.positions)
    n = len(position)
    if table.response != "plane":
        return _curved(table, table.name, position, None, location, frame, report)
    if table.normals is not None:
        return Sensor(table.name, position, _one_for_each(table.normals, n, (*location, "normals"), frame, report))
    normal = unit_vectors(frame.directions(table.normal or (0.0, 0.0, 0.0)), (*location, "normal"), report)
    return Sensor(table.name, position, np.repeat(normal, n, axis=0))


def _curved(
    table: Curved,
    name: str,
    position: NDArray[np.float64],
    grid: tuple[int, int] | None,
    location: Location,
    frame: Frame,
    report: Report,
) -> Sensor:
    """Readings of cylinders, half cylinders or spheres."""
    if table.response == "plane":
        raise ValueError(f"the sensor {name!r} is made of planes")
    axis = UP if table.axis is None else unit_vectors(frame.directions(table.axis), (*location, "axis"), report)[0]
    facing = None
    if table.facing is not None:
        wanted = unit_vectors(frame.directions(table.facing), (*location, "facing"), report)[0]
        across = wanted - (wanted @ axis) * axis
        length = float(np.linalg.norm(across))
        if length <= 1e-9:
            report.fault((*location, "facing"), "is along the axis", "a direction across it")
            return Sensor(name, position, np.tile(axis, (len(position), 1)), grid)
        facing = np.tile(across / length, (len(position), 1))
    return curved_sensor(name, position, table.response, axis=axis, facing=facing, grid=grid)


def _grid_sensor(table: GridSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    corner, edge_u, edge_v = frame.points([table.corner, table.edge_u, table.edge_v])
    across = np.cross(edge_u, edge_v)
    if np.linalg.norm(across) <= 1e-9 * np.linalg.norm(edge_u) * np.linalg.norm(edge_v):
        report.fault(location, "edge_u and edge_v span no area", "two edges that are neither zero nor parallel")
        across = UP
    direction = across if table.normal is None else frame.directions(table.normal)
    normal = unit_vectors(direction, (*location, "normal"), report)
    corner, edge_u, edge_v = _inside_of_border(table, corner, edge_u, edge_v, location, frame, report)
    n_u, n_v = _grid_counts(table, edge_u, edge_v, location, frame, report)
    v, u = np.meshgrid((np.arange(n_v) + 0.5) / n_v, (np.arange(n_u) + 0.5) / n_u, indexing="ij")
    position = corner + u.reshape(-1, 1) * edge_u + v.reshape(-1, 1) * edge_v + frame.length(table.height) * normal
    if table.response != "plane":
        return _curved(table, table.name, position, (n_v, n_u), location, frame, report)
    return Sensor(table.name, position, np.repeat(normal, n_u * n_v, axis=0), (n_v, n_u))


def _inside_of_border(
    table: GridSensor,
    corner: NDArray[np.float64],
    edge_u: NDArray[np.float64],
    edge_v: NDArray[np.float64],
    location: Location,
    frame: Frame,
    report: Report,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Corner and edges of what a strip of even width along all edges leaves of the parallelogram."""
    height = np.linalg.norm(np.cross(edge_u, edge_v))
    lengths = np.array([np.linalg.norm(edge_u), np.linalg.norm(edge_v)])
    # Share of each edge that the strip along the other takes: its width over the distance of opposite edges.
    border = frame.length(table.border)
    share = border * lengths[::-1] / height if height > 0.0 else np.zeros(2)
    if (share >= 0.5).any():
        report.fault((*location, "border"), f"{table.border:g} leaves no area", "less than half of the area's width")
        return corner, edge_u, edge_v
    return corner + share[0] * edge_u + share[1] * edge_v, (1 - 2 * share[0]) * edge_u, (1 - 2 * share[1]) * edge_v


def _grid_counts(
    table: GridSensor,
    edge_u: NDArray[np.float64],
    edge_v: NDArray[np.float64],
    location: Location,
    frame: Frame,
    report: Report,
) -> tuple[int, int]:
    """Cells along both edges."""
    lengths = (float(np.linalg.norm(edge_u)), float(np.linalg.norm(edge_v)))
    if table.counts is not None:
        n_u, n_v = table.counts
    elif min(lengths) <= 0.0:
        return 1, 1
    elif isinstance(table.spacing, str):
        n_u, n_v = grid_counts(*lengths)
    else:
        spacing = frame.length(table.spacing or 1.0)
        n_u, n_v = (int(min(max(np.ceil(length / spacing - 1e-9), 1), 1e9)) for length in lengths)
    return (n_u, n_v) if is_reasonable(n_u * n_v, location, report) else (1, 1)


def _eye_sensor(table: EyeSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    eyes = replace(_eyes(table, location, frame, report), glare=table.glare)
    if table.glare and table.field is not None:
        report.fault((*location, "glare"), "with a `field`", "UGR is for light from all of the hemisphere ahead")
    if table.field is None:
        return eyes
    limits = table.field
    return masked_eyes(eyes, FieldOfView(limits.up, limits.down, limits.left, limits.right), UP)


def _eyes(table: EyeSensor, location: Location, frame: Frame, report: Report) -> Sensor:
    position = frame.points(table.positions) + frame.length(table.eye_height) * UP
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
        up = UP if abs(direction[2]) < 1.0 - 1e-9 else np.array([0.0, 1.0, 0.0])
    else:
        up = unit_vectors(frame.directions(table.up), (*location, "up"), report)[0]
        if np.linalg.norm(np.cross(up, direction)) <= 1e-9:
            report.fault((*location, "up"), "is along the line of sight", "another direction, or none")
    width, height = table.size
    return View(table.name, position, direction, up, table.field_of_view_deg, width, height)
