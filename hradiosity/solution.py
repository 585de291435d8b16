"""Results: inert host arrays and what they belong to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.space.hierarchy import Elements


@dataclass(frozen=True)
class Readings:
    """Light at the points of one sensor, with 95 % intervals.

    position, normal : (n, 3) float64 [m], [1]
    irradiance, half_width : (n, n_bands) float64 [W m⁻² per band]
    illuminance, illuminance_half_width : (n,) float64 [lx]
    mean_illuminance, mean_illuminance_half_width : of the sensor as a whole [lx]; the interval is that of the mean,
        and not the mean of the intervals
    enclosed : (n,) float64, share of the view that ends inside a solid or on sides no light reaches
    """

    sensor: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    half_width: NDArray[np.float64]
    illuminance: NDArray[np.float64]
    illuminance_half_width: NDArray[np.float64]
    mean_illuminance: float
    mean_illuminance_half_width: float
    enclosed: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.position)

    @property
    def uniformity(self) -> float:
        """U₀, lowest over mean illuminance; 0 where there is no light."""
        return float(self.illuminance.min() / self.mean_illuminance) if self.mean_illuminance > 0.0 else 0.0

    @property
    def accuracy(self) -> NDArray[np.float64]:
        """(n,) half width over illuminance, or over 5 % of the sensor's mean for darker readings."""
        floor = 0.05 * self.mean_illuminance
        base = np.maximum(self.illuminance, floor)
        return np.divide(self.illuminance_half_width, base, out=np.zeros_like(base), where=base > 0.0)


@dataclass(frozen=True)
class Surfaces:
    """The light on the row elements.

    irradiance : (n_rows, n_bands) float64 [W m⁻² per band], mean over replicates
    direct : (n_rows, n_bands) float64, the part that comes straight from emitters
    space : (n_rows,) int32, connected space that each element looks into
    exposed : (n_rows,) float64, share of the element that is not covered by a solid
    """

    irradiance: NDArray[np.float64]
    direct: NDArray[np.float64]
    space: NDArray[np.int32]
    exposed: NDArray[np.float64]


@dataclass(frozen=True)
class Solution:
    """All that a run found out.

    readings : by sensor name
    record : what ``run.json`` holds beside the plan: options, seconds a stage, rays, iterations, defects, warnings
    replicates : replicates that the numbers are means of
    complete : False when the run was interrupted
    """

    scene: Scene
    plan: Plan
    elements: Elements
    surfaces: Surfaces
    readings: Mapping[str, Readings]
    replicates: int
    complete: bool
    record: Mapping[str, Any] = field(default_factory=dict)

    @property
    def exitance(self) -> NDArray[np.float64]:
        """(n_rows, n_bands) reflected exitance ρE of the row elements [W m⁻² per band]."""
        black = np.zeros((1, len(self.scene.bands)))
        reflectance = np.concatenate([self.scene.reflectance, black])
        return reflectance[self.elements.row_material] * self.surfaces.irradiance
