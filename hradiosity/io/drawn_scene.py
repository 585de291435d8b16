"""What can be looked at, as inert arrays: the surfaces of a scene or of a result, its light, its sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import View
from hradiosity.model.spectrum import Bands


@dataclass(frozen=True)
class Cells:
    """Flat polygons, all seen from one side.

    corners : (n, 4, 3) float64 [m], counter-clockwise seen from the front; a triangle repeats its last one
    is_triangle : (n,) bool
    element, material, object, patch : (n,) int32
    side : (n,) int32, 0 front or 1 back of the patch
    place : (n, 4, 2) int32, `corners` on the grid of the patch
    grid : (n, 2) int32, size of that grid
    width : (n,) int32, cells along an edge of the element
    luminaire : (n,) int32, that each shines as, −1 for none
    """

    corners: NDArray[np.float64]
    is_triangle: NDArray[np.bool_]
    element: NDArray[np.int32]
    material: NDArray[np.int32]
    object: NDArray[np.int32]
    patch: NDArray[np.int32]
    side: NDArray[np.int32]
    place: NDArray[np.int32]
    grid: NDArray[np.int32]
    width: NDArray[np.int32]
    luminaire: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.corners)

    @cached_property
    def _cross(self) -> NDArray[np.float64]:
        """(n, 3) cross product of the diagonals: twice the area long."""
        a, b, c, d = (self.corners[:, k] for k in range(4))
        return np.asarray(np.cross(c - a, d - b))

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner (3,) of all cells [m]; the unit cube's where there are none."""
        if not len(self):
            return np.zeros(3), np.ones(3)
        return self.corners.min(axis=(0, 1)), self.corners.max(axis=(0, 1))

    @cached_property
    def first_corner(self) -> NDArray[np.float64]:
        """(n, 3) `corners[:, 0]` in a row [m]."""
        return np.ascontiguousarray(self.corners[:, 0])

    @cached_property
    def reach(self) -> NDArray[np.float64]:
        """(n,) of each cell from its first corner [m]."""
        reach: NDArray[np.float64] = np.linalg.norm(self.corners - self.corners[:, :1], axis=2).max(axis=1)
        return reach

    @cached_property
    def area(self) -> NDArray[np.float64]:
        """(n,) [m²]."""
        area: NDArray[np.float64] = 0.5 * np.linalg.norm(self._cross, axis=1)
        return area

    @cached_property
    def normal(self) -> NDArray[np.float64]:
        """(n, 3) unit, towards who sees the cell; 0 for cells without area."""
        length = np.linalg.norm(self._cross, axis=1, keepdims=True)
        normal: NDArray[np.float64] = np.divide(self._cross, length, out=np.zeros_like(self._cross), where=length > 0)
        return normal


@dataclass(frozen=True)
class Words:
    """Names and spectra of what cells point to.

    title : of the scene
    bands : Bands
    reflectance : (n_materials + 1, n_bands), black last
    exitance : (n_luminaires + 1, n_bands) [W m⁻² per band], dark last
    """

    title: str
    bands: Bands
    materials: tuple[str, ...]
    reflectance: NDArray[np.float64]
    objects: tuple[str, ...]
    luminaires: tuple[str, ...]
    exitance: NDArray[np.float64]


@dataclass(frozen=True)
class Lamps:
    """What shines beside cells, and what all lamps send together.

    position : (k, 3) float64 [m], of point sources
    luminaire : (k,) int32
    flux : (n_bands,) [W per band], of all lamps
    sky : (n_bands,) [W m⁻² sr⁻¹ per band], 0 without one
    """

    position: NDArray[np.float64]
    luminaire: NDArray[np.int32]
    flux: NDArray[np.float64]
    sky: NDArray[np.float64]


@dataclass(frozen=True)
class Light:
    """Light on elements.

    irradiance : (n_elements, n_bands) [W m⁻² per band]
    exposed : (n_elements,) share of each element that solids do not cover
    space : (n_elements,) int32, connected space that it looks into
    replicates : that it is the mean of
    """

    irradiance: NDArray[np.floating]
    exposed: NDArray[np.float64]
    space: NDArray[np.int32]
    replicates: int


@dataclass(frozen=True)
class SensorPoints:
    """Where light is read, and what was read.

    sensor : (n,) names
    index : (n,) int64, in its sensor
    position, normal : (n, 3) float64; of a cylinder its axis, of a luminance the line of sight
    looks : (n,) bool, light that is looked at, and not light on something
    numbers : columns of ``readings.csv`` and ``luminances.csv`` by name, (n,) float64, NaN where a reading has no such
        number; empty for a scene
    spectra : () → spectral irradiance [W m⁻² nm⁻¹], or radiance [W m⁻² sr⁻¹ nm⁻¹] of what is looked at, and its half
        width, (n, n_bands) each, NaN where that is not told; None for a scene
    """

    sensor: tuple[str, ...]
    index: NDArray[np.int64]
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    looks: NDArray[np.bool_]
    numbers: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    spectra: Callable[[], tuple[NDArray[np.float64], NDArray[np.float64]]] | None = None

    def __len__(self) -> int:
        return len(self.position)


@dataclass(frozen=True)
class Exposure:
    """What the pictures of a result chose.

    white_luminance : shown as white [cd m⁻²]; None for no choice
    white : name of what is shown as white
    quantity, low, high, logarithmic : of the false colours; `high` is None for no choice
    """

    white_luminance: float | None = None
    white: str = "as-measured"
    quantity: str = "illuminance"
    low: float = 0.0
    high: float | None = None
    logarithmic: bool = False


@dataclass(frozen=True)
class Drawn:
    """All that a window shows; `light` is None as long as nothing is solved."""

    cells: Cells
    words: Words
    lamps: Lamps
    views: tuple[View, ...]
    sensors: SensorPoints
    light: Light | None
    exposure: Exposure = field(default_factory=Exposure)
