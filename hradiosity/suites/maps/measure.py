"""Errors of maps with leaves cut where the light asks for it, and with leaves of one size."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Scene
from hradiosity.show.light import picture_scene
from hradiosity.show.map_reflected import ReflectedVertices, paths_for
from hradiosity.show.surface_map import FINEST, NOISE_SHARE, SurfaceMap, joined, map_goal, map_surfaces
from hradiosity.solution import Solution
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.leaves import Leaves, plant_leaves, split_leaves
from hradiosity.suites.maps.points import MapTruth
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.leaf_light import VertexLight
from hradiosity.transport.refine import RefinementOptions

DIRECT_RAYS = 4096
"""Shadow rays from each point to all emitters together, for the direct light that maps are compared with."""
LEAST_DIRECT_RAYS = 256
_LIFT = 2.0**-20
"""Height of points above their side, relative to the scene's half extent."""


@dataclass(frozen=True)
class MapOutcome:
    """What one way to cut leaves gave; errors are root mean squares over the mean illuminance.

    kind : "adaptive", "uniform", or "elements" for the row elements themselves, one value each
    wanted : error that was asked for; NaN for others
    leaves : that were cut
    read : points at which reflected light was read
    direct, reflected : of the direct and the reflected light
    total, flat : of all light, interpolated and with one value a leaf; like `reflected` without the reference's noise
    half_width : root mean square of those of the vertices, over the mean
    seconds : CPU time
    """

    kind: str
    wanted: float
    leaves: int
    read: int
    direct: float
    reflected: float
    total: float
    flat: float
    half_width: float
    seconds: float


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

    def adaptive(self, errors: Sequence[float]) -> Iterator[MapOutcome]:
        """Maps of these errors."""
        for error in errors:
            start = time.process_time()
            found = map_surfaces(self.solution, self.on_device, self.sides, error)
            yield self._outcome("adaptive", error, found, time.process_time() - start)

    def uniform(self, levels: int, most_read: int, error: float) -> Iterator[MapOutcome]:
        """Maps with all leaves of one level, from 0 on, with the noise that an error asks for.

        Reflected light is read at all of their vertices, or at those of the finest leaves of one level that have no
        more than `most_read`, with as many paths at all.
        """
        goal = map_goal(picture_scene(self.solution), self.solution, self.sides, FINEST * self.on_device.scale)
        n_paths = paths_for(self.on_device, self.solution, goal, NOISE_SHARE * error)
        reflected = None
        for level in range(levels):
            start = time.process_time()
            options = RefinementOptions(base_level=level, max_level=level, error=error)
            direct = VertexLight(self.on_device, self._sampled, goal, options)
            leaves = cut_evenly(plant_leaves(goal.frames, np.isfinite(goal.size), level), level)
            direct.evaluate(leaves, np.flatnonzero(leaves.is_leaf))
            if reflected is None or len(direct.position) <= most_read:
                vertices = ReflectedVertices(self.on_device, self.solution, goal, n_paths)
                vertices.evaluate(leaves, np.flatnonzero(leaves.is_leaf))
                reflected = vertices.finish(leaves)
            found = joined(self.solution, direct, leaves, reflected)
            yield self._outcome("uniform", float("nan"), found, time.process_time() - start)

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
        reflected = self._error(total - direct + self.direct)
        return MapOutcome("elements", nan, n_rows, 0, self._direct_error(direct), reflected, error, error, nan, seconds)

    def _cells(self) -> NDArray[np.int64]:
        points = self.truth.points
        triangles = self.solution.scene.patches.is_triangle
        return np.maximum(locate_cells(self.solution.elements, triangles, points.side, points.u, points.v)[0], 0)

    @property
    def _sampled(self) -> Scene:
        return sampled_scene(self.solution.scene, self.solution.plan.weak_emitters)

    def _outcome(self, kind: str, wanted: float, found: SurfaceMap, seconds: float) -> MapOutcome:
        points, mean, shadow = self.truth.points, float(self.truth.lux.mean()), found.shadow
        lux = np.einsum("vl,l->v", shadow.per_luminaire.astype(np.float64), _lumens(self.solution))
        direct = replace(found, lux=lux).at(points.side, points.u, points.v)
        total = found.at(points.side, points.u, points.v)
        return MapOutcome(
            kind=kind,
            wanted=wanted,
            leaves=found.n_leaves,
            read=0 if found.reflected is None else found.reflected.n_read,
            direct=self._direct_error(direct),
            reflected=self._error(total - direct + self.direct),
            total=self._error(total),
            flat=self._error(found.at(points.side, points.u, points.v, flat=True)),
            half_width=float(np.sqrt((found.half_width**2).mean())) / mean,
            seconds=seconds,
        )

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


def cut_evenly(leaves: Leaves, level: int) -> Leaves:
    """All leaves split down to a level."""
    while (coarse := np.flatnonzero(leaves.is_leaf & (leaves.level < level))).size:
        leaves = split_leaves(leaves, coarse)
    return leaves


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
