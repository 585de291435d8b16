"""What a setting will take, from what another one took: each stage's seconds grow with its work."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hradiosity.options import Options
from hradiosity.plan import Plan
from hradiosity.planning import paths_of_reading

_LOOKUP_SHARE = {1: 0.4, 2: 0.67, 3: 1.0}
"""Of a path, by the hit at which it ends."""
LEAST_GROWTH: Final = 0.7
"""Two runs tell how a stage grows if the work of one is below this share of the other's."""
LEAST_SLOPE: Final = 0.3
"""Of proportion: short stages are timed badly where the machine has other work."""


def work_of(
    elements: float,
    options: Options,
    *,
    n_readings: int,
    n_emitters: int,
    columns: int,
) -> dict[str, float]:
    """Work of each stage of the mode of rays, in rays (and columns of the solver).

    Parameters
    ----------
    elements : float
    options : Options
    n_readings, n_emitters, columns : int
        Of the scene.
    """
    rays = elements * max(options.rays_per_element, 16 * options.replicates)
    paths = 3.0 * _LOOKUP_SHARE[options.lookup] * paths_of_reading(options, n_readings)
    return {
        "exchange rays": rays,
        "exchange": rays,
        "solution": rays * columns,
        "companion": rays * columns,
        "direct light": elements * max(options.light_points, options.replicates) * max(n_emitters, 1),
        "readings": max(n_readings * (paths + n_emitters * options.light_samples), 1.0),
    }


def work_of_plan(plan: Plan, options: Options) -> dict[str, float]:
    """The same for the elements that a plan made."""
    return work_of(
        plan.n_elements,
        options,
        n_readings=plan.n_readings,
        n_emitters=plan.n_emitters,
        columns=plan.columns.n_columns,
    )


@dataclass(frozen=True)
class Measured:
    """A run that others are predicted from.

    seconds : of all of it
    stages : seconds of each stage
    work : of each stage
    """

    seconds: float
    stages: Mapping[str, float]
    work: Mapping[str, float]


def predict(base: Measured, wanted: Mapping[str, float], smaller: Measured | None = None) -> float:
    """Seconds of a run with other work: each stage changes with its work, and the rest stays as it was.

    Parameters
    ----------
    base : Measured
    wanted : mapping
        Work of the stages of the other run.
    smaller : Measured, optional
        A run with less work. Where it did less, a stage's seconds grow along the line through both, since there is
        much that a stage takes anyway; elsewhere in proportion.
    """
    change = sum(
        _seconds_a_unit(base, stage, smaller) * (amount - base.work[stage])
        for stage, amount in wanted.items()
        if base.work.get(stage, 0.0) > 0.0
    )
    return base.seconds + change


def _seconds_a_unit(base: Measured, stage: str, smaller: Measured | None) -> float:
    """What more work of a stage takes, between a share of proportion and all of it."""
    seconds, work = base.stages.get(stage, 0.0), base.work[stage]
    whole = seconds / work
    if smaller is None or not 0.0 < smaller.work.get(stage, 0.0) < LEAST_GROWTH * work:
        return whole
    slope = (seconds - smaller.stages.get(stage, 0.0)) / (work - smaller.work[stage])
    return min(max(slope, LEAST_SLOPE * whole), whole)
