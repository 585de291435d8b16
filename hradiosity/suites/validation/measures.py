"""Numbers of ours from solutions: readings, their ratios, means over faces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import illuminance
from hradiosity.solution import Solution
from hradiosity.suites.validation.values import SENSOR, Bench, Job, Measured

Measure = Callable[[Bench], Sequence[Measured]]


def of_readings(job: Job, scale: float = 1.0) -> Measure:
    """Illuminances at the scene's points [lx], times a factor."""

    def measure(bench: Bench) -> list[Measured]:
        return scaled(bench.solve(job), scale)

    return measure


def of_readings_over_last(job: Job, scale: float) -> Measure:
    """Illuminances over that at the last point, times a factor; the last point is none of the case's."""

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return scaled(solution, scale / float(solution.readings[SENSOR].illuminance[-1]))[:-1]

    return measure


def scaled(solution: Solution, scale: float) -> list[Measured]:
    """Illuminances and half widths at the scene's points, times a factor."""
    found = solution.readings[SENSOR]
    pairs = zip(found.illuminance * scale, found.illuminance_half_width * scale)
    return [Measured(float(value), float(width)) for value, width in pairs]


def illuminance_of_elements(solution: Solution, *, direct: bool = False) -> NDArray[np.float64]:
    """(n_rows,) illuminance of the row elements [lx], or the part of it that comes straight from emitters."""
    light = solution.surfaces.direct if direct else solution.surfaces.irradiance
    return illuminance(light, solution.scene.bands)


def flux_on(solution: Solution, material: str, *, direct: bool = False) -> float:
    """Luminous flux that falls on all surfaces of a material [lm]."""
    rows = _rows(solution, material)
    return float(solution.elements.area[rows] @ illuminance_of_elements(solution, direct=direct)[rows])


def mean_on(solution: Solution, material: str, *, direct: bool = False) -> float:
    """Mean illuminance of all surfaces of a material [lx]."""
    return flux_on(solution, material, direct=direct) / float(solution.elements.area[_rows(solution, material)].sum())


def mean_everywhere(solution: Solution, *, direct: bool = False) -> float:
    """Mean illuminance of all surfaces [lx]."""
    lit = illuminance_of_elements(solution, direct=direct)
    return float(np.average(lit, weights=solution.elements.area))


def _rows(solution: Solution, material: str) -> NDArray[np.intp]:
    number = [paint.name for paint in solution.scene.materials].index(material)
    return np.flatnonzero(solution.elements.row_material == number)
