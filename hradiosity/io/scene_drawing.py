"""A scene that is not solved yet, as what a window shows."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells, Drawn, Lamps, SensorPoints, Words
from hradiosity.io.results_drawing import seen_places
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.lamps import lamp_exitances, lamp_flux, side_luminaires
from hradiosity.model.scene import Scene, Sensor
from hradiosity.space.cell_lookup import CELL_CORNERS
from hradiosity.space.cells import place_corners

MOST_DIRECTIONS: Final = 64
"""Directions of patches for which it is found out whether anything lies behind; backs of all others are shown."""
_SAME_FACING: Final = 2.0**-20
"""Of unit normals."""
_LEVEL: Final = 1e-6
"""How far behind a patch something must lie to count, over the size of the scene."""


def draw_scene(scene: Scene) -> Drawn:
    """Each patch as one cell; two where its back may be seen.

    Backs are left out where matter is behind, and where nothing of the scene is: rooms can be looked into from outside.
    """
    side = np.concatenate([2 * np.arange(len(scene.patches)), 2 * np.flatnonzero(_seen_backs(scene.patches)) + 1])
    return Drawn(
        cells=_cells(scene, side.astype(np.int64)),
        words=scene_words(scene),
        lamps=_lamps(scene),
        views=scene.views,
        sensors=sensor_points(scene.sensors),
        light=None,
    )


def scene_words(scene: Scene) -> Words:
    """Names and spectra of a scene."""
    black = np.zeros((1, len(scene.bands)))
    return Words(
        title=scene.name,
        bands=scene.bands,
        materials=tuple(material.name for material in scene.materials),
        reflectance=np.concatenate([scene.reflectance, black]),
        objects=scene.objects,
        luminaires=tuple(lamp.name for lamp in scene.luminaires),
        exitance=np.concatenate([lamp_exitances(scene), black]),
    )


def sensor_points(sensors: tuple[Sensor, ...]) -> SensorPoints:
    """All readings of all sensors, those of luminances last, as in a result."""
    sensors = tuple(sorted(sensors, key=lambda sensor: sensor.kind == "luminance"))
    none = np.zeros((0, 3))
    return SensorPoints(
        sensor=tuple(sensor.name for sensor in sensors for _ in sensor.place),
        index=np.concatenate([np.zeros(0, np.int64), *(np.arange(sensor.n_readings) for sensor in sensors)]),
        position=np.concatenate([none, *(sensor.place for sensor in sensors)]),
        normal=np.concatenate([none, *(sensor.direction for sensor in sensors)]),
        looks=np.array([sensor.kind == "luminance" for sensor in sensors for _ in sensor.place], np.bool_),
    )


def _lamps(scene: Scene) -> Lamps:
    at_points = scene.emitters.patch == NONE
    sky = np.zeros(len(scene.bands)) if scene.sky is None else scene.sky.radiance
    return Lamps(
        scene.emitters.position[at_points], scene.emitters.luminaire[at_points].astype(np.int32), lamp_flux(scene), sky
    )


def _cells(scene: Scene, side: NDArray[np.int64]) -> Cells:
    patches, patch = scene.patches, side // 2
    triangle = patches.is_triangle[patch]
    place = CELL_CORNERS[triangle.astype(np.int64)]
    two_sided = np.array([material.two_sided for material in scene.materials], np.bool_)
    own = patches.material[patch]
    black = (side % 2 == 1) & ~two_sided[own]
    return Cells(
        corners=place_corners(patches, side, triangle, place.astype(np.float64)),
        is_triangle=triangle,
        element=np.arange(len(side), dtype=np.int32),
        material=np.where(black, len(scene.materials), own).astype(np.int32),
        object=patches.object[patch],
        patch=patch.astype(np.int32),
        side=(side % 2).astype(np.int32),
        place=seen_places(place, side, triangle).astype(np.int32),
        grid=np.ones((len(side), 2), np.int32),
        width=np.ones(len(side), np.int32),
        luminaire=side_luminaires(scene)[side],
    )


def _seen_backs(patches: Patches) -> NDArray[np.bool_]:
    """(n_patches,) bool: no matter behind, and something of the scene lies there."""
    seen: NDArray[np.bool_] = patches.solid == NONE
    if not seen.any():
        return seen
    normal, corners = patches.normal, patches.corners().reshape(-1, 3)
    low, high = patches.bounds()
    size = float(np.linalg.norm(high - low))
    steps = np.rint(normal / _SAME_FACING).astype(np.int64) @ np.array([1, 1 << 21, 1 << 42])
    _, first, number = np.unique(steps, return_index=True, return_inverse=True)
    often = np.argsort(-np.bincount(number[seen], minlength=len(first)), kind="stable")[:MOST_DIRECTIONS]
    farthest = np.full(len(first), -np.inf)
    x, y, z = np.ascontiguousarray(corners.T)
    for direction in often:
        a, b, c = normal[first[direction]]
        farthest[direction] = float((a * x + b * y + c * z).min())
    own = np.einsum("nk,nk->n", patches.origin, normal)
    behind: NDArray[np.bool_] = seen & (farthest[number] < own - _LEVEL * size)
    return behind
