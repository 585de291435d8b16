"""What straight lines from an eye meet: where luminances are read. In double precision, on the host."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Emitters, Looks, Luminaire, Material, Parts, Scene, Sensor, View

OFF_SURFACE: Final = 1e-3
"""Distance of a reading from the surface that is looked at [m]."""
_AT_ONCE: Final = 1 << 22
"""Pairs of line and patch that are looked at together."""
_GRAZING: Final = 1e-12


@dataclass(frozen=True)
class Met:
    """What n lines meet first.

    patch : (n,) int32, NONE where they meet nothing
    distance : (n,) float64 [m], infinite there
    """

    patch: NDArray[np.int32]
    distance: NDArray[np.float64]


def first_met(patches: Patches, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> Met:
    """First patch that each line meets.

    Parameters
    ----------
    patches : Patches
    origin, direction : (n, 3) float64 [m], unit
    """
    n, m = len(origin), len(patches)
    patch, distance = np.full(n, NONE, np.int32), np.full(n, np.inf)
    lines = max(1, _AT_ONCE // max(m, 1))
    for first in range(0, n if m else 0, lines):
        part = slice(first, first + lines)
        t = _distances(patches, origin[part], direction[part])
        nearest = t.argmin(axis=1)
        distance[part] = t[np.arange(len(t)), nearest]
        patch[part] = np.where(np.isfinite(distance[part]), nearest, NONE)
    return Met(patch, distance)


def _distances(patches: Patches, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, m) distance of each patch along each line, infinite where it misses; by Cramer's rule."""
    across = np.cross(patches.edge_u, patches.edge_v)
    facing = direction @ across.T
    area = np.linalg.norm(across, axis=1)
    meets = np.abs(facing) > _GRAZING * area
    safe = np.where(meets, facing, 1.0)
    t = (np.einsum("md,md->m", patches.origin, across) - origin @ across.T) / safe
    # Coordinates along the edges: p · (v × c) / c², p · (c × u) / c², with p = origin + t direction − corner.
    along_u = np.cross(patches.edge_v, across) / (area**2)[:, None]
    along_v = np.cross(across, patches.edge_u) / (area**2)[:, None]
    u, v = (
        origin @ axis.T - np.einsum("md,md->m", patches.origin, axis) + t * (direction @ axis.T)
        for axis in (along_u, along_v)
    )
    last = np.where(patches.is_triangle, 1.0 - u, 1.0)
    inside = meets & (t > 0.0) & (u >= 0.0) & (v >= 0.0) & (u <= 1.0) & (v <= last)
    return np.where(inside, t, np.inf)


def luminance_sensor(
    name: str,
    eye: NDArray[np.float64],
    direction: NDArray[np.float64],
    count: int,
    towards: NDArray[np.float64],
    scene: Scene,
) -> Sensor:
    """Readings of the mean radiance of what lines from an eye meet.

    Parameters
    ----------
    name : str
    eye : (3,) float64 [m]
    direction : (n · count, 3) float64, unit
        Of the lines; `count` successive ones make a reading.
    count : int
    towards : (n, 3) float64, unit
        Told as the direction of each reading.
    scene : Scene
        Surfaces, paints and lamps; its sensors play no part.
    """
    origin = np.broadcast_to(eye, direction.shape)
    met = first_met(scene.patches, origin, direction)
    hit = met.patch != NONE
    which = np.where(hit, met.patch, 0)
    front = np.einsum("nd,nd->n", scene.patches.normal[which], direction) < 0.0
    facing = np.where(front[:, None], 1.0, -1.0) * scene.patches.normal[which]
    place = origin + np.where(hit, met.distance, 0.0)[:, None] * direction + OFF_SURFACE * facing
    looks = Looks(
        np.where(hit & _reflects(scene.materials, scene.patches, which, front), scene.patches.material[which], NONE),
        np.where(hit, _lamp(scene.luminaires, scene.emitters, len(scene.patches))[which, 1 - front.astype(int)], NONE),
        ~hit & (direction[:, 2] > 0.0),
    )
    # Where nothing is met nothing is read of the plane, which then stands at the eye.
    normal = np.where(hit[:, None], facing, -direction)
    eyes = np.repeat(eye[None], len(towards), axis=0)
    parts = Parts("luminance", count, eyes, towards, looks=looks)
    return Sensor(name, np.where(hit[:, None], place, origin), normal, parts=parts)


def looking_sensor(eye: ArrayLike, directions: ArrayLike, together: bool, scene: Scene) -> Sensor:
    """As `luminance_sensor`, from directions of any length; a reading for each, or one of their mean.

    Raises
    ------
    ValueError
        When shapes do not fit, something is not finite or a direction is 0.
    """
    place, ways = np.asarray(eye, np.float64), np.atleast_2d(np.asarray(directions, np.float64))
    if place.shape != (3,) or ways.shape[1:] != (3,) or not (np.isfinite(place).all() and np.isfinite(ways).all()):
        raise ValueError(f"an eye (3,) and directions (n, 3), all finite, are needed, not {place.shape}, {ways.shape}")
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    if not (length > 0.0).all():
        raise ValueError("a vector of length 0 has no direction")
    ways = ways / length
    count = len(ways) if together else 1
    return luminance_sensor("look", place, ways, count, ways[::count], scene)


def pixel_directions(
    view: View, pixels: tuple[float, float, float, float], columns: int, rows: int
) -> NDArray[np.float64]:
    """(rows · columns, 3) unit directions through the centres of even cells of a rectangle of a view.

    Parameters
    ----------
    view : View
    pixels : left, top, right, bottom
        Edges of the rectangle, from the top left corner of the picture.
    columns, rows : int
    """
    left, top, right, bottom = pixels
    x = left + (np.arange(columns) + 0.5) / columns * (right - left)
    y = top + (np.arange(rows) + 0.5) / rows * (bottom - top)
    half = np.tan(np.radians(0.5 * view.field_of_view))
    across = np.cross(view.direction, view.up)
    across /= np.linalg.norm(across)
    above = np.cross(across, view.direction)
    u = half * (2.0 * x / view.width - 1.0)
    v = half * (view.height - 2.0 * y) / view.width
    rays = view.direction + u[None, :, None] * across + v[:, None, None] * above
    flat = rays.reshape(-1, 3)
    return np.asarray(flat / np.linalg.norm(flat, axis=1, keepdims=True))


def _reflects(
    materials: tuple[Material, ...], patches: Patches, which: NDArray[np.int32], front: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """(n,) whether the side that is looked at reflects at all."""
    both = np.array([material.two_sided for material in materials], bool)
    return np.asarray(front | both[patches.material[which]])


def _lamp(luminaires: tuple[Luminaire, ...], emitters: Emitters, n_patches: int) -> NDArray[np.int32]:
    """(n_patches, 2) luminaire that shines from the front and from the back of each patch, or NONE."""
    lamp = np.full((n_patches, 2), NONE, np.int32)
    area = emitters.patch != NONE
    both = np.array([luminaire.two_sided for luminaire in luminaires], bool)[emitters.luminaire]
    lamp[emitters.patch[area], 0] = emitters.luminaire[area]
    lamp[emitters.patch[area & both], 1] = emitters.luminaire[area & both]
    return lamp
