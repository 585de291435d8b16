"""Results: inert host arrays and what they belong to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.estimate import Estimate
from hradiosity.model.looking import looking_sensor
from hradiosity.model.scene import Scene, Sensor
from hradiosity.plan import Plan
from hradiosity.space.hierarchy import Elements

LIGHT_NUMBERS = (
    *("irradiance", "illuminance", "chromaticity"),
    *("mean_illuminance", "lowest_illuminance", "highest_illuminance", "uniformity", "diversity"),
)
"""Numbers that all readings have."""
RELATIVE_NUMBERS = ("relative_illuminance", "relative_mean_illuminance")
"""Numbers that only differences have."""


class _AtPoints:
    """What readings and differences of readings share."""

    position: NDArray[np.float64]
    numbers: Mapping[str, Estimate]

    def __len__(self) -> int:
        return len(self.position)

    @property
    def illuminance(self) -> NDArray[np.float64]:
        """(n,) [lx]."""
        return self.numbers["illuminance"].value

    @property
    def illuminance_half_width(self) -> NDArray[np.float64]:
        """(n,) of `illuminance`."""
        return self.numbers["illuminance"].half_width


@dataclass(frozen=True)
class ReflectedLux:
    """Illuminance at points but for what comes straight from emitters that shadow rays go to.

    lux : (n,) float64 [lx]
    noise : (n,) float64, standard error by the paths from each point alone
    half_width : (n,) float64, of the 95 % interval
    """

    lux: NDArray[np.float64]
    noise: NDArray[np.float64]
    half_width: NDArray[np.float64]

    def widened(self, factor: float) -> ReflectedLux:
        """The same with all half widths multiplied."""
        return replace(self, half_width=factor * self.half_width)


class Reflector(Protocol):
    """What reads reflected light with the kept light of a solution's replicates."""

    def __call__(
        self, position: NDArray[np.float64], normal: NDArray[np.float64], n_paths: int, seed: int
    ) -> ReflectedLux:
        """Light at points (n, 3) [m] with unit normals, by so many paths from each; hemicubes have none."""


@dataclass(frozen=True)
class Readings(_AtPoints):
    """Light at the points of one sensor, with intervals.

    position, normal : (n, 3) float64 [m], [1]
    enclosed : (n,) float64, share of the view that ends inside a solid
    kind : what the readings are, see `hradiosity.model.scene.Sensor.kind`; of "luminance" irradiance is radiance
        [W m⁻² sr⁻¹ per band] and illuminance luminance [cd m⁻²]
    numbers : by name, each with an interval that comes from the same number in each replicate, and not from the
        intervals of what it is made of: ``irradiance`` (n, n_bands) [W m⁻² per band], ``illuminance`` (n,) [lx],
        ``chromaticity`` (n, 2) CIE 1931 x and y, NaN without light; numbers of colour and the eye (n,), see
        `hradiosity.metrics.derived`, NaN where not defined; of the sensor as a whole ``mean_illuminance``,
        ``lowest_illuminance``, ``highest_illuminance`` [lx], ``uniformity``, U₀, lowest over mean, and ``diversity``,
        U_d, lowest over highest illuminance

    Half widths are those of 95 % intervals; `Estimate.half_width_at` has others.
    """

    sensor: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    numbers: Mapping[str, Estimate]
    kind: str = "plane"

    @property
    def irradiance(self) -> NDArray[np.float64]:
        """(n, n_bands) spectra [W m⁻² per band]."""
        return self.numbers["irradiance"].value

    @property
    def half_width(self) -> NDArray[np.float64]:
        """(n, n_bands) of `irradiance`."""
        return self.numbers["irradiance"].half_width

    @property
    def mean_illuminance(self) -> float:
        """Of the sensor as a whole [lx]."""
        return float(self.numbers["mean_illuminance"].value)

    @property
    def mean_illuminance_half_width(self) -> float:
        """Of the mean, which is not the mean of the half widths."""
        return float(self.numbers["mean_illuminance"].half_width)

    @property
    def uniformity(self) -> float:
        """U₀, lowest over mean illuminance; 0 where there is no light."""
        return float(self.numbers["uniformity"].value)

    @property
    def uniformity_half_width(self) -> float:
        """Of `uniformity`."""
        return float(self.numbers["uniformity"].half_width)

    @property
    def chromaticity(self) -> NDArray[np.float64]:
        """(n, 2) CIE 1931 x and y; NaN where there is no light."""
        return self.numbers["chromaticity"].value

    @property
    def chromaticity_half_width(self) -> NDArray[np.float64]:
        """(n, 2) of `chromaticity`."""
        return self.numbers["chromaticity"].half_width

    @property
    def derived(self) -> tuple[str, ...]:
        """Names of the numbers of colour and the eye."""
        return tuple(name for name in self.numbers if name not in LIGHT_NUMBERS)

    @property
    def accuracy(self) -> NDArray[np.float64]:
        """(n,) half width over illuminance, or over 5 % of the sensor's mean for darker readings."""
        base = self.accuracy_base
        return np.divide(self.illuminance_half_width, base, out=np.zeros_like(base), where=base > 0.0)

    @property
    def accuracy_base(self) -> NDArray[np.float64]:
        """(n,) illuminance that accuracy refers to [lx]: the reading's own, or 5 % of the sensor's mean if more."""
        return np.maximum(self.illuminance, 0.05 * self.mean_illuminance)

    def widened(self, factor: float) -> Readings:
        """The same with all half widths multiplied."""
        numbers = {name: replace(found, factor=factor * found.factor) for name, found in self.numbers.items()}
        return replace(self, numbers=numbers)


def interval_shares(readings: Mapping[str, Readings]) -> dict[str, float]:
    """By part of the intervals: median over all lit readings of its half width over the illuminance."""
    known = [found.numbers["illuminance"] for found in readings.values()]
    if not known:
        return {}
    lux = np.concatenate([estimate.value for estimate in known])
    lit = lux > 0.0
    if not lit.any():
        return {}
    names = known[0].parts
    return {
        name: float(np.median(np.concatenate([estimate.parts[name] for estimate in known])[lit] / lux[lit]))
        for name in names
    }


@dataclass(frozen=True)
class Differences(_AtPoints):
    """What a variant of the scene changes at the points of one sensor: variant − scene, with intervals.

    numbers : by name as in `Readings.numbers`, each with an interval that comes from the same difference in each
        replicate, where both have the same random numbers; and ``relative_illuminance`` (n,) and
        ``relative_mean_illuminance``, differences over the scene's illuminances, NaN where the scene has none
    """

    sensor: str
    variant: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    numbers: Mapping[str, Estimate]

    @property
    def derived(self) -> tuple[str, ...]:
        """Names of the numbers of colour and the eye."""
        return tuple(name for name in self.numbers if name not in (*LIGHT_NUMBERS, *RELATIVE_NUMBERS))

    def widened(self, factor: float) -> Differences:
        """The same with all half widths multiplied."""
        numbers = {name: replace(found, factor=factor * found.factor) for name, found in self.numbers.items()}
        return replace(self, numbers=numbers)


@dataclass(frozen=True)
class VariantReadings:
    """What is read of a variant of the scene.

    readings : of the variant itself, by sensor name
    differences : from the scene, by sensor name
    """

    readings: Mapping[str, Readings]
    differences: Mapping[str, Differences]

    def widened(self, factor: float) -> VariantReadings:
        """The same with all half widths multiplied."""
        return VariantReadings(
            {name: found.widened(factor) for name, found in self.readings.items()},
            {name: found.widened(factor) for name, found in self.differences.items()},
        )


@dataclass(frozen=True)
class Surfaces:
    """The light on the row elements.

    irradiance : (n_rows, n_bands) float64 [W m⁻² per band], mean over replicates, each with the share found exposed
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
    reader : reads further points with the kept light of the replicates; None for a solution without a solver
    reflector : the same for the reflected light of many points side by side
    variants : by name, what is read of the scene's variants; all else is of the scene itself
    """

    scene: Scene
    plan: Plan
    elements: Elements
    surfaces: Surfaces
    readings: Mapping[str, Readings]
    replicates: int
    complete: bool
    record: Mapping[str, Any] = field(default_factory=dict)
    reader: Callable[[Sensor], Readings] | None = None
    reflector: Reflector | None = None
    variants: Mapping[str, VariantReadings] = field(default_factory=dict)

    def read(self, points: ArrayLike, normals: ArrayLike) -> Readings:
        """Light at further points.

        Each replicate's light on the surfaces is kept, and short paths from the new points look it up, so that the
        intervals are as honest as those of the sensors. Nothing of the surfaces is computed again.

        Parameters
        ----------
        points : (n, 3) or (3,) float [m]
        normals : (n, 3) or (3,) float
            Of any length but 0; one normal serves all points.

        Raises
        ------
        ValueError
            When shapes do not fit, something is not finite or a normal is 0.
        RuntimeError
            When the solution has no solver behind it.
        """
        position = np.atleast_2d(np.asarray(points, np.float64))
        normal = np.atleast_2d(np.asarray(normals, np.float64))
        for name, value in (("points", position), ("normals", normal)):
            if value.ndim != 2 or value.shape[1] != 3 or not np.isfinite(value).all():
                raise ValueError(f"{name} must be (n, 3) finite numbers, have the shape {value.shape}")
        if len(normal) not in (1, len(position)):
            raise ValueError(f"{len(position)} points and {len(normal)} normals")
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        if not (length > 0.0).all():
            raise ValueError("a normal of length 0 has no direction")
        return self.read_sensor(Sensor("read", position, np.broadcast_to(normal / length, position.shape)))

    def read_sensor(self, sensor: Sensor) -> Readings:
        """Light at any further sensor, see `hradiosity.model.sensor_kinds` for those that are no planes.

        Raises
        ------
        RuntimeError
            When the solution has no solver behind it.
        """
        if self.reader is None:
            raise RuntimeError("this solution was not made by a solver of this process; solve the scene to read it")
        return self.reader(sensor)

    def look(self, eye: ArrayLike, directions: ArrayLike, *, together: bool = False) -> Readings:
        """Radiance and luminance of what is seen from an eye.

        Parameters
        ----------
        eye : (3,) float [m]
        directions : (n, 3) or (3,) float
            Of any length but 0.
        together : bool
            One reading, the mean over all directions.

        Returns
        -------
        Readings
            Of the kind "luminance". Raises as `read` does.
        """
        return self.read_sensor(looking_sensor(eye, directions, together, self.scene))

    @property
    def exitance(self) -> NDArray[np.float64]:
        """(n_rows, n_bands) reflected exitance ρE of the row elements [W m⁻² per band]."""
        black = np.zeros((1, len(self.scene.bands)))
        reflectance = np.concatenate([self.scene.reflectance, black])
        return reflectance[self.elements.row_material] * self.surfaces.irradiance
