"""The classic mode: hemicubes, progressive shooting, subdivision, and hemicubes at the readings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import MESH
from hradiosity.model.scene import Scene, Sensor
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.planning_memory import KEPT_LIGHT_BYTES
from hradiosity.radiosity.classic_light import ClassicLight
from hradiosity.radiosity.classic_surfaces import ClassicSurfaces
from hradiosity.radiosity.round import TOO_FEW
from hradiosity.radiosity.seeds import replicate_seed
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.readings.moments import ReadingMoments, ReplicateReadings
from hradiosity.solution import Readings, ReflectedLux
from hradiosity.transport.direct import direct_at_points

READING_BATCH = 1024
"""Readings whose rows of form factors are held at a time."""


class ClassicSolver(RadiositySolver):
    """A run like that of `RadiositySolver`, by hemicubes (Cohen & Greenberg 1985) and shooting (Cohen et al. 1988).

    Replicates differ in the points that patches shoot from and in the turn of each hemicube. A reading is a hemicube
    over what the surfaces reflect; light straight from lamps comes from their form factors and shadow rays, since a
    lamp covers few pixels. The classic way, lamps as items of the hemicube, is there for comparison.

    Parameters
    ----------
    scene : Scene
    options : Options
    device : Device
    calibration : ClassicCalibration, optional
    lamps_in_view : bool
        Take the light of area lamps at readings from the pixels that show them.
    """

    surface_solver = ClassicSurfaces
    reads_again = False

    def __init__(
        self,
        scene: Scene,
        options: Options,
        device: Device,
        calibration: Calibration | ClassicCalibration | None = None,
        *,
        lamps_in_view: bool = False,
    ) -> None:
        super().__init__(scene, options, device, calibration)
        self._lamps_in_view = lamps_in_view
        self._lights: list[ClassicLight] = []

    def read(self, sensor: Sensor) -> Readings:
        """Light at a further sensor, from the kept light of this process's replicates; see `Solution.read_sensor`.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        ValueError
            For a sensor whose directions count unlike.
        """
        if sensor.parts is not None and sensor.parts.response is not None:
            raise ValueError(f"the classic mode reads planes, and {sensor.name!r} is {sensor.kind}")
        if not self.keeps_light:
            raise RuntimeError(TOO_FEW)
        full = self.options.full_metrics
        moments = ReadingMoments((sensor,), self.scene.bands, full=full, scene=self.scene)
        for light in self._lights:
            self._gather(moments, light)
        return moments.readings(self._prepare().shared_errors())[sensor.name]

    @property
    def keeps_light(self) -> bool:
        """Whether there is light to read further points from."""
        return len(self._lights) >= 2

    def read_reflected(
        self, position: NDArray[np.float64], normal: NDArray[np.float64], n_paths: int, seed: int
    ) -> ReflectedLux:
        """Reflected light at points by hemicubes over them, which have no number of paths and no further seed.

        Raises
        ------
        RuntimeError
            Before two replicates are kept.
        """
        if not self.keeps_light:
            raise RuntimeError(TOO_FEW)
        moments = ReadingMoments((Sensor("map", position, normal),), self.scene.bands, scene=self.scene)
        for light in self._lights:
            self._gather(moments, light, direct=False)
        found = moments.readings(self._prepare().shared_errors(), illuminance_only=True)["map"].numbers["illuminance"]
        return ReflectedLux(found.value, found.standard_error, found.half_width)

    def _begin(self, size: Options) -> None:
        """Start anew with replicates of another size."""
        self._lights = []
        super()._begin(size)

    def _elements_by_size(self) -> int:
        """Patches of the wanted edge that the lit surfaces hold, without what small ones add."""
        surfaces = self._prepare()
        return max(1, round(float(surfaces.elements.area.sum()) / surfaces.plan.element_size**2))

    def _replicate(self, surfaces: SurfaceSolver) -> None:
        """One independent estimate of everything, added to the running moments."""
        if not isinstance(surfaces, ClassicSurfaces):
            raise TypeError(f"the classic mode needs ClassicSurfaces, not {type(surfaces).__name__}")
        seed = replicate_seed(self.options.seed, self.replicates)
        light = surfaces.solve(seed)
        with self.record.timed("readings"):
            self._gather(self._reader.moments, light)
        surfaces.count_hemicubes(light.hemicube)
        if len(self._lights) < 2 or (len(self._lights) + 1) * light.nbytes <= KEPT_LIGHT_BYTES:
            self._lights.append(light)

    def _gather(self, moments: ReadingMoments, light: ClassicLight, *, direct: bool = True) -> None:
        """One replicate of readings, or of their reflected light."""
        position, normal = moments.position, moments.normal
        irradiance = np.zeros((len(position), self.plan.columns.n_columns))
        if direct:
            irradiance += self._direct(position, normal, light.seed)
        lost, change = np.zeros(len(position)), np.zeros_like(irradiance)
        exitance = light.reflected + light.emitted if self._lamps_in_view and direct else light.reflected
        rng = np.random.Generator(np.random.Philox(key=light.seed ^ 0x5BD1E995))
        angle = rng.random(len(position)) * 2.0 * np.pi
        sky = self.plan.columns.sky.astype(np.float64)
        for first in range(0, len(position), READING_BATCH):
            part = slice(first, first + READING_BATCH)
            views = light.hemicube.views(position[part], normal[part], angle[part])
            irradiance[part] += views.factor @ exitance + views.sky[:, None] * sky
            change[part] = views.factor @ light.change
            lost[part] = views.covered + views.unlit
        to_bands = self.plan.columns.to_bands
        moments.add(ReplicateReadings(to_bands(irradiance), lost, to_bands(change), MESH))

    def _direct(self, position: NDArray[np.float64], normal: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        """(n, n_columns) irradiance straight from the lamps; from point sources alone if area lamps are in view."""
        surfaces = self._prepare()
        factor = direct_at_points(
            surfaces.on_device, position, normal, self.plan.light_samples, seed ^ 0x3C6EF372
        ).astype(np.float64)
        self.record.rays += factor.size * self.plan.light_samples
        if self._lamps_in_view:
            factor[:, self.scene.emitters.patch >= 0] = 0.0
        emission = surfaces.light.emission[:, : self.plan.columns.n_columns].astype(np.float64)
        direct: NDArray[np.float64] = np.einsum("xe,ec->xc", factor, emission)
        return direct
