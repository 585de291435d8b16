"""What was measured, as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hradiosity.solution import Readings
from hradiosity.suites.cost.errors import Error
from hradiosity.suites.cost.settings import Setting


@dataclass(frozen=True)
class Run:
    """One setting with one seed.

    cpu_seconds : from the ray structure to the last reading, kernels and checks left out
    busy_seconds, wall_seconds : of all of it: CPU and wall
    memory_bytes : added to the process at the peak, or what the plan says of another memory; None if unknown
    stage_seconds : wall seconds of each stage
    work : of each stage, see `hradiosity.suites.cost.work`
    convergence : the solver's, of the last replicate: CPU seconds, products, residual
    """

    setting: Setting
    seed: int
    elements: int
    replicates: int
    cpu_seconds: float
    busy_seconds: float
    wall_seconds: float
    memory_bytes: int | None
    stage_seconds: Mapping[str, float]
    work: Mapping[str, float]
    readings: Mapping[str, Readings]
    convergence: Mapping[str, Any]


@dataclass(frozen=True)
class Skipped:
    """Something that was not run.

    predicted : wall seconds that it would have taken; None when that is not the reason
    """

    name: str
    group: str
    predicted: float | None
    reason: str


@dataclass(frozen=True)
class Price:
    """A setting, all its seeds together.

    cpu_seconds, wall_seconds : mean of a run
    illuminance, spectrum : errors over the readings; over readings and bands
    bias : mean of illuminance / reference − 1
    sampling : standard error of the illuminances by the run's own replicates, relative, root mean square: the part
        of the error that more samples remove
    on_front : no other setting is both cheaper and better in illuminance
    """

    setting: Setting
    elements: int
    seeds: int
    cpu_seconds: float
    wall_seconds: float
    memory_bytes: int | None
    illuminance: Error
    spectrum: Error
    bias: float
    sampling: float
    on_front: bool = False


@dataclass(frozen=True)
class SolverPrice:
    """What a solver took for the light on the surfaces.

    cpu_seconds : of the solution of one replicate
    residual : over the right-hand side
    """

    name: str
    elements: int
    cpu_seconds: float
    products: float
    residual: float


@dataclass(frozen=True)
class EffectPrice:
    """An effect forced against what the plan chose.

    usual_seconds, forced_seconds : CPU seconds
    change : of the illuminances, relative, root mean square
    sampling : change that random sampling alone would make
    """

    name: str
    flags: str
    usual_seconds: float
    forced_seconds: float
    change: float
    sampling: float


@dataclass(frozen=True)
class BandsPrice:
    """The scene in another number of bands of one width, over the same range.

    columns : right-hand sides
    illuminance, mean_illuminance : relative change against the most bands that were run; root mean square over the
        readings, and of the mean of all readings
    chromaticity : largest change of x or y, root mean square over the readings
    cct, ra : change of the colour temperature [K] and of Ra, root mean square over the readings that have one; NaN
        when none has
    melanopic : relative change of the mean melanopic EDI of all readings
    """

    bands: int
    columns: int
    cpu_seconds: float
    illuminance: float
    mean_illuminance: float
    chromaticity: float
    cct: float
    ra: float
    melanopic: float


@dataclass(frozen=True)
class Report:
    """All that is known.

    noise, spectral_noise : standard error of the reference over its value, root mean square
    paths : of the reference, from each reading
    reference_cpu_seconds : it took
    readings : that have light in them
    complete : False when it was interrupted
    """

    scene: str
    device: str
    budget: float
    spent: float
    noise: float
    spectral_noise: float
    paths: int
    reference_cpu_seconds: float
    readings: int
    prices: tuple[Price, ...]
    skipped: tuple[Skipped, ...]
    solvers: tuple[SolverPrice, ...]
    effects: tuple[EffectPrice, ...]
    bands: tuple[BandsPrice, ...]
    complete: bool
