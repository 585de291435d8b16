"""Errors of maps with leaves cut where the light asks for it, and with leaves of one size."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.show.light import picture_scene
from hradiosity.show.surface_map import FINEST, SurfaceMap, map_goal, read_map
from hradiosity.solution import Solution
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.suites.maps.points import MapTruth
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.refine import RefinementOptions, ShadowLight, refine_shadows

DIRECT_RAYS = 4096
"""Shadow rays from each point to all emitters together, for the direct light that maps are compared with."""
LEAST_DIRECT_RAYS = 256
_LIFT = 2.0**-20
"""Height of points above their side, relative to the scene's half extent."""


@dataclass(frozen=True)
class MapOutcome:
    """What one way to cut leaves gave; errors are root mean squares over the mean illuminance.

    kind : "adaptive", "uniform", or "elements" for the row elements themselves, one value each
    wanted : error of the direct light that was asked for; NaN for others
    leaves, vertices : that were cut, and read
    direct : of the direct light
    total, flat : of all light, interpolated and with one value a leaf, the noise of the reference taken out; NaN where
        the vertices were too many to be read
    half_width : root mean square of those of the vertices, over the mean
    cut_seconds, read_seconds : CPU time
    """

    kind: str
    wanted: float
    leaves: int
    vertices: int
    direct: float
    total: float
    flat: float
    half_width: float
    cut_seconds: float
    read_seconds: float


@dataclass(frozen=True)
class MapBench:
    """A solution, and the truth at points of some of its sides.

    direct : (n,) float64 [lx], direct light at the points
    """

    solution: Solution
    on_device: DeviceScene
    sides: NDArray[np.int64]
    truth: MapTruth
    direct: NDArray[np.float64]

    @classmethod
    def of(
        cls, solution: Solution, on_device: DeviceScene, sides: NDArray[np.int64], truth: MapTruth, seed: int = 1
    ) -> MapBench:
        """Find the direct light at the points, with many rays of their own."""
        points = truth.points
        position = points.position + _LIFT * on_device.scale * points.normal
        rays = max(DIRECT_RAYS // max(on_device.n_emitters, 1), LEAST_DIRECT_RAYS)
        found = direct_at_points(on_device, position, points.normal, rays, seed)
        lumens = _lumens(solution)
        scene = sampled_scene(solution.scene, solution.plan.weak_emitters)
        lux = np.einsum("xe,e->x", found.astype(np.float64), lumens[scene.emitters.luminaire])
        return cls(solution, on_device, sides, truth, lux)

    def adaptive(self, errors: Sequence[float], most_read: int) -> Iterator[MapOutcome]:
        """Maps with these errors of the direct light."""
        for error in errors:
            options = RefinementOptions(base_level=0, max_level=10, error=error)
            yield self._outcome("adaptive", error, options, most_read)

    def uniform(self, levels: int, most_read: int, light_samples: int) -> Iterator[MapOutcome]:
        """Maps with all leaves of one level, from 0 on."""
        for level in range(levels):
            options = RefinementOptions(base_level=level, max_level=level, light_samples=light_samples)
            yield self._outcome("uniform", float("nan"), options, most_read)

    def elements(self, seconds: float) -> MapOutcome:
        """The row elements on these sides, one value each; `seconds` is what they took."""
        picture = picture_scene(self.solution)
        cells = np.isin(picture.frames.side, self.sides)
        surfaces, weights = self.solution.surfaces, luminous_weights(self.solution.scene.bands)
        row = self.solution.elements.cell_row[self._cells()]
        total = np.einsum("nb,b->n", surfaces.irradiance[row], weights)
        direct = np.einsum("nb,b->n", surfaces.direct[row], weights)
        error = self._error(total)
        n_rows = len(np.unique(self.solution.elements.cell_row[cells]))
        nan = float("nan")
        return MapOutcome("elements", nan, n_rows, 0, self._direct_error(direct), error, error, nan, seconds, 0.0)

    def _cells(self) -> NDArray[np.int64]:
        points = self.truth.points
        triangles = self.solution.scene.patches.is_triangle
        return np.maximum(locate_cells(self.solution.elements, triangles, points.side, points.u, points.v)[0], 0)

    def _cut(self, options: RefinementOptions) -> tuple[ShadowLight, float]:
        """Leaves, and the CPU seconds that they took."""
        start = time.process_time()
        solution = self.solution
        goal = map_goal(picture_scene(solution), solution, self.sides, FINEST * self.on_device.scale)
        scene = sampled_scene(solution.scene, solution.plan.weak_emitters)
        return refine_shadows(self.on_device, scene, goal, options), time.process_time() - start

    def _outcome(self, kind: str, wanted: float, options: RefinementOptions, most_read: int) -> MapOutcome:
        shadow, cut_seconds = self._cut(options)
        points, mean = self.truth.points, float(self.truth.lux.mean())
        lux = np.einsum("vl,l->v", shadow.per_luminaire.astype(np.float64), _lumens(self.solution))
        direct = SurfaceMap(self.solution, shadow, lux, np.zeros_like(lux)).at(points.side, points.u, points.v)
        total = flat = half_width = read_seconds = float("nan")
        if len(lux) <= most_read:
            start = time.process_time()
            found = read_map(self.solution, shadow)
            read_seconds = time.process_time() - start
            total = self._error(found.at(points.side, points.u, points.v))
            flat = self._error(found.at(points.side, points.u, points.v, flat=True))
            half_width = float(np.sqrt((found.half_width**2).mean())) / mean
        leaves = int(shadow.leaves.is_leaf.sum())
        error = self._direct_error(direct)
        return MapOutcome(kind, wanted, leaves, len(lux), error, total, flat, half_width, cut_seconds, read_seconds)

    def _direct_error(self, lux: NDArray[np.float64]) -> float:
        return float(np.sqrt(((lux - self.direct) ** 2).mean()) / self.truth.lux.mean())

    def _error(self, lux: NDArray[np.float64]) -> float:
        """Root mean square over the mean, without the noise of the reference."""
        truth = self.truth
        square = ((lux - truth.lux) ** 2).mean() - (truth.noise**2).mean()
        return float(np.sqrt(max(square, 0.0)) / truth.lux.mean())


def _lumens(solution: Solution) -> NDArray[np.float64]:
    """(n_luminaires,) luminous exitance or intensity."""
    weights = luminous_weights(solution.scene.bands)
    lamps = solution.scene.luminaires
    return np.array([np.einsum("b,b->", lamp.emission, weights) for lamp in lamps])


def elements_ratio(few: Sequence[MapOutcome], many: Sequence[MapOutcome], error: float, part: str) -> float:
    """Leaves of `many` over those of `few` at one error, between measured points on logarithmic axes.

    NaN where one of them did not reach the error, or was below it from the start.
    """
    counts = []
    for outcomes in (few, many):
        known = sorted((getattr(o, part), o.leaves) for o in outcomes if getattr(o, part) > 0.0)
        x, y = np.log([e for e, _ in known]), np.log([n for _, n in known])
        inside = len(x) > 0 and x[0] <= np.log(error) <= x[-1]
        counts.append(float(np.exp(np.interp(np.log(error), x, y))) if inside else float("nan"))
    return counts[1] / counts[0]
