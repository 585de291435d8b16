"""Rooms whose exchange the solvers are measured on: a furnished one, and two joined by a door."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Emitters, Material, Scene
from hradiosity.model.spectrum import Bands
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.exchange import Exchange, build_exchange, trace_rows

RAYS = 512
"""Exchange rays from each element."""
_HEIGHT = 2.8


@dataclass(frozen=True)
class SolverRoom:
    """An exchange and the light that falls on it.

    name : of the room
    exchange : Exchange
    direct : (n_rows,) float64, irradiance by one element of the ceiling with exitance 1
    """

    name: str
    exchange: Exchange
    direct: NDArray[np.float64]


def furnished(device: Device, size: float = 0.42) -> SolverRoom:
    """5 m × 4 m × 2.8 m with a table top and a cupboard."""
    boxes = [((1.6, 1.4, 1.0), (1.4, 0.8, 0.04)), ((3.4, 1.2, 0.8), (0.5, 0.5, 1.0))]
    return _room(device, "furnished room", (5.0, 4.0, _HEIGHT), boxes, size)


def two_rooms(device: Device, size: float = 0.72) -> SolverRoom:
    """Two rooms of 4 m × 4 m × 2.8 m with a door of 0.9 m × 2.1 m in the wall between them."""
    wall = [((4.0, 0.0, 0.0), (0.1, 1.5, _HEIGHT)), ((4.0, 2.4, 0.0), (0.1, 1.6, _HEIGHT))]
    lintel = ((4.0, 1.5, 2.1), (0.1, 0.9, _HEIGHT - 2.1))
    return _room(device, "two rooms", (8.1, 4.0, _HEIGHT), [*wall, lintel], size)


def _room(
    device: Device,
    name: str,
    size: tuple[float, float, float],
    boxes: list[tuple[tuple[float, float, float], tuple[float, float, float]]],
    element_size: float,
) -> SolverRoom:
    """The exchange between the elements of a room with boxes in it."""
    parts = [
        _faces((0.0, 0.0, 0.0), size, inward=True),
        *(_faces(corner, edges, inward=False) for corner, edges in boxes),
    ]
    rows = np.concatenate(parts)
    n = len(rows)
    zeros = np.zeros(n, np.int32)
    solid = np.repeat(np.arange(len(parts)) - 1, 6).astype(np.int32)
    patches = Patches(
        rows[:, 0], rows[:, 1], rows[:, 2], np.zeros(n, bool), zeros, zeros, zeros, np.where(solid < 0, NONE, solid)
    )
    nobody = Emitters(np.zeros(0, np.int32), np.zeros((0, 3)), np.zeros(0, np.int32))
    grey = (Material("grey", np.full(1, 0.5), True),)
    bands = Bands.explicit(np.array([500.0, 600.0]))
    scene = Scene(name, Path(name), bands, patches, grey, (), nobody, (), (), ("room",), None)
    bvh = build_bvh(device, patches)
    space = np.column_stack([zeros, zeros - 1])
    elements = build_elements(patches, space, np.array([True]), element_size)
    on_device = upload_scene(device, scene, bvh, occlusion=True)
    hits = trace_rows(on_device, upload_elements(device, elements), RAYS, 1)
    exchange = build_exchange(hits, elements)
    return SolverRoom(
        name, exchange, _lamp_light(exchange, elements.cell_side[elements.row_cell[elements.row_start[:-1]]])
    )


def _lamp_light(exchange: Exchange, side: NDArray[np.integer]) -> NDArray[np.float64]:
    """Irradiance by the middle element of the room's ceiling."""
    on_ceiling = np.flatnonzero(side == 2 * 5)
    lamp = on_ceiling[len(on_ceiling) // 2]
    links = slice(int(exchange.start[lamp]), int(exchange.start[lamp + 1]))
    light = np.zeros(len(exchange.element_area))
    light[exchange.source[links]] = exchange.area[links]
    return np.divide(light, exchange.element_area, out=light, where=exchange.element_area > 0.0)


def _faces(
    corner: tuple[float, float, float], size: tuple[float, float, float], *, inward: bool
) -> NDArray[np.float64]:
    """(6, 3, 3) origin and edges of the faces of a box, ceiling last."""
    x, y, z = np.diag(size)
    low = np.asarray(corner)
    outward = [(low, z, y), (low + x, y, z), (low, x, z), (low + y, z, x), (low, y, x), (low + z, x, y)]
    return np.array([(origin, v, u) if inward else (origin, u, v) for origin, u, v in outward])
