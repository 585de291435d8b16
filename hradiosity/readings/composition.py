"""From the light on traced planes to the readings that are made of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.lamps import lamp_exitances
from hradiosity.model.scene import Looks, Material, Scene, Sensor
from hradiosity.model.sensor_kinds import stacked_responses

_Number = TypeVar("_Number", np.float64, np.int64)
MOST_EFFORT = 4.0
"""Samples of a reading that is made of many planes, over those of a plane."""


@dataclass(frozen=True)
class _Looking:
    """Radiance of the places that some planes stand in front of, from their irradiance.

    planes : slice of all planes
    gain, own : (n, n_bands) float64, reflectance over π and the count of planes; own radiance over that count
    """

    planes: slice
    gain: NDArray[np.float64]
    own: NDArray[np.float64]


class Composition:
    """How the readings of some sensors are made of planes.

    Parameters
    ----------
    sensors : sequence of Sensor
    scene : Scene, optional
        Whose paints and lamps luminance sensors look at.

    Attributes
    ----------
    position, normal : (n_planes, 3) float64
    response : (n_planes, 12) float32, see `hradiosity.model.sensor_kinds`, or None
    count : (n_readings,) int64, planes of each reading

    Raises
    ------
    ValueError
        For luminance sensors without a scene.
    """

    def __init__(self, sensors: Sequence[Sensor], scene: Scene | None = None) -> None:
        self.position = np.concatenate([np.zeros((0, 3)), *(s.position for s in sensors)])
        self.normal = np.concatenate([np.zeros((0, 3)), *(s.normal for s in sensors)])
        self.response = stacked_responses(sensors)
        each = [1 if s.parts is None else s.parts.count for s in sensors]
        self.count = np.repeat(np.array(each, np.int64), [s.n_readings for s in sensors])
        self._first = np.cumsum(self.count) - self.count
        self._looking = _looking(sensors, scene)

    @property
    def is_plain(self) -> bool:
        """Whether each plane is a reading."""
        return not self._looking and bool((self.count == 1).all())

    def readings(self, planes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_readings, n_bands) irradiance, or radiance, from (n_planes, n_bands) irradiance [W m⁻² per band]."""
        return self._summed(planes, own=True)

    def changes(self, planes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_readings, n_bands) change by a change of the light on the planes."""
        return self._summed(planes, own=False)

    def mean(self, planes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_readings,) mean over the planes of each reading."""
        return planes if self.is_plain else np.add.reduceat(planes, self._first) / self.count

    def total(self, planes: NDArray[np.int64]) -> NDArray[np.int64]:
        """(n_readings,) sum over the planes of each reading."""
        return planes if self.is_plain else np.add.reduceat(planes, self._first)

    def spread(self, readings: NDArray[_Number]) -> NDArray[_Number]:
        """(n_planes,) what each plane's reading has; nothing for nothing."""
        return np.repeat(readings, self.count) if len(readings) else readings

    @property
    def share(self) -> NDArray[np.float64]:
        """(n_planes,) of the samples that a reading of one plane gets, so that no reading gets many times those."""
        return np.repeat(np.minimum(1.0, MOST_EFFORT / np.maximum(self.count, 1)), self.count)

    def _summed(self, planes: NDArray[np.float64], *, own: bool) -> NDArray[np.float64]:
        if self.is_plain:
            return planes
        if self._looking:
            planes = planes.copy()
        for some in self._looking:
            planes[some.planes] *= some.gain
            if own:
                planes[some.planes] += some.own
        summed: NDArray[np.float64] = np.add.reduceat(planes, self._first, axis=0)
        return summed


def _looking(sensors: Sequence[Sensor], scene: Scene | None) -> list[_Looking]:
    found, first = [], 0
    for sensor in sensors:
        planes = slice(first, first + len(sensor.position))
        first = planes.stop
        if sensor.parts is None or sensor.parts.looks is None:
            continue
        if scene is None:
            raise ValueError(f"the luminance sensor {sensor.name!r} needs the scene that it looks at")
        found.append(_radiances(planes, sensor.parts.looks, sensor.parts.count, scene))
    return found


def _radiances(planes: slice, looks: Looks, count: int, scene: Scene) -> _Looking:
    bands = len(scene.bands)
    black = np.zeros((1, bands))  # the last row, which NONE, −1, takes
    paint = np.concatenate([_rows(scene.materials, bands), black])[looks.material]
    light = np.concatenate([lamp_exitances(scene), black])[looks.luminaire]
    own = light / np.pi
    if scene.sky is not None:
        own = np.where(looks.sky[:, None], scene.sky.radiance, own)
    return _Looking(planes, paint / (np.pi * count), own / count)


def _rows(materials: Sequence[Material], bands: int) -> NDArray[np.float64]:
    return np.array([material.reflectance for material in materials]).reshape(len(materials), bands)
