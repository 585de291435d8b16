"""Readings that are no planes: what planes they are made of, and how the directions in front of each weigh.

A reading with the response w(ω), E = ∫ L w dω, is the sum over planes with normals n_j of ∫ L g max(n_j · ω, 0) dω with
g = w / Σ_j max(n_j · ω, 0): exact for any light, and g is nearly even where the planes are well chosen, so that each is
traced like any other plane. `cl/include/hr_response.h` computes g.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Parts, Sensor

Response = Literal["cylindrical", "semi-cylindrical", "spherical"]
RESPONSE_ENTRIES: Final = 12
"""Numbers that the kernels take for each plane: u (3), a (3), kind, limits of the field of view (4), unused."""
_PLANE: Final = 0.0
_KIND: Final = {"spherical": 1.0, "cylindrical": 2.0, "semi-cylindrical": 3.0}
_ROOT_3: Final = float(np.sqrt(3.0))
_PLANES: Final = {
    "spherical": np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / _ROOT_3,
    "cylindrical": np.array([[1, 0, 0], [-0.5, 0.5 * _ROOT_3, 0], [-0.5, -0.5 * _ROOT_3, 0]]),
    "semi-cylindrical": np.array([[1.0, 0, 0], [0, 1, 0], [0, -1, 0]]),
}
"""Normals along u, a × u and a: a tetrahedron's, three about the axis, one ahead and two to the sides."""


@dataclass(frozen=True)
class FieldOfView:
    """How far an eye sees: half axes of the ellipse in each quarter, as angles from the line of sight [degrees].

    The field is drawn in the plane in which the distance from the middle is the angle from the line of sight.
    """

    up: float = 90.0
    down: float = 90.0
    left: float = 90.0
    right: float = 90.0


def curved_sensor(
    name: str,
    place: NDArray[np.float64],
    response: Response,
    *,
    axis: NDArray[np.float64],
    facing: NDArray[np.float64] | None = None,
    grid: tuple[int, int] | None = None,
) -> Sensor:
    """Readings of mean illuminances over the surface of something small.

    Parameters
    ----------
    name : str
    place : (n, 3) float64 [m]
    response : str
        "cylindrical": over a cylinder without its ends, (1/π) ∫ L sin ε dω, ε from the axis (EN 12464-1:2021, E_z).
        "semi-cylindrical": over the half that faces `facing`, (1/π) ∫ L sin ε (1 + cos α) dω, α about the axis
        (EN 13201-3). "spherical": over a sphere, ¼ ∫ L dω, a quarter of the scalar illuminance.
    axis : (3,) float64, unit
        Of the cylinders; any for spheres.
    facing : (n, 3) float64, unit, perpendicular to the axis
        Of half cylinders.
    grid : (rows, columns), optional
    """
    n = len(place)
    ahead = np.broadcast_to(_across(axis), (n, 3)) if facing is None else facing
    frame = np.stack([ahead, np.cross(axis, ahead), np.broadcast_to(axis, (n, 3))], axis=1)
    normal = np.einsum("kf,nfd->nkd", _PLANES[response], frame)
    count = normal.shape[1]
    table = _table(ahead, axis, _KIND[response])
    told = facing if facing is not None else np.broadcast_to(axis, (n, 3)).copy()
    parts = Parts(response, count, place, told, np.repeat(table, count, axis=0))
    return Sensor(name, np.repeat(place, count, axis=0), normal.reshape(-1, 3), grid, parts)


def masked_eyes(sensor: Sensor, field: FieldOfView, up: NDArray[np.float64]) -> Sensor:
    """Eyes that do not see what lies outside their field of view.

    Parameters
    ----------
    sensor : Sensor
        Planes whose normals are the lines of sight.
    field : FieldOfView
    up : (3,) float64, unit
        What the heads call up; where that is along the line of sight, any other direction.
    """
    gaze = sensor.normal
    across = up - np.einsum("nd,d->n", gaze, up)[:, None] * gaze
    length = np.linalg.norm(across, axis=1, keepdims=True)
    other = np.stack([_across(direction) for direction in gaze])
    above = np.where(length > 1e-9, across / np.maximum(length, 1e-9), other)
    limits = np.radians([field.up, field.down, field.left, field.right])
    parts = Parts("field of view", 1, sensor.position, gaze, _table(gaze, above, _PLANE, limits))
    return replace(sensor, parts=parts)


def stacked_responses(sensors: Sequence[Sensor]) -> NDArray[np.float32] | None:
    """(n_planes, RESPONSE_ENTRIES) tables of all planes of some sensors; None where all directions count alike."""
    tables = [None if sensor.parts is None else sensor.parts.response for sensor in sensors]
    if all(table is None for table in tables):
        return None
    even = [np.zeros((len(sensor.position), RESPONSE_ENTRIES), np.float32) for sensor in sensors]
    return np.concatenate([zero if table is None else table for zero, table in zip(even, tables)])


def _table(
    ahead: NDArray[np.float64],
    axis: NDArray[np.float64],
    kind: float,
    limits: NDArray[np.float64] | None = None,
) -> NDArray[np.float32]:
    """(n, RESPONSE_ENTRIES) of n readings."""
    table = np.zeros((len(ahead), RESPONSE_ENTRIES), np.float32)
    table[:, :3], table[:, 3:6], table[:, 6] = ahead, axis, kind
    if limits is not None:
        table[:, 7:11] = limits
    return table


def _across(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) a unit vector perpendicular to another."""
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    return np.asarray(across / np.linalg.norm(across))
