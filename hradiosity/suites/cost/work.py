"""What a setting will take, from what another one took: each stage's seconds grow with its work."""

from __future__ import annotations

from collections.abc import Mapping

from hradiosity.options import Options
from hradiosity.plan import Plan

_LOOKUP_SHARE = {1: 0.4, 2: 0.67, 3: 1.0}
"""Of a path, by the hit at which it ends."""


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
    paths = 3.0 * _LOOKUP_SHARE[options.lookup] * options.gather_samples
    return {
        "exchange rays": rays,
        "exchange": rays,
        "solution": rays * columns,
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


def predict(
    wall_seconds: float, stage_seconds: Mapping[str, float], work: Mapping[str, float], wanted: Mapping[str, float]
) -> float:
    """Wall seconds of a run with other work, each stage in proportion and the rest as it was.

    Parameters
    ----------
    wall_seconds, stage_seconds, work
        Of a run that was measured.
    wanted : mapping
        Work of the stages of the other run.
    """
    change = sum(
        stage_seconds.get(stage, 0.0) * (amount / work[stage] - 1.0)
        for stage, amount in wanted.items()
        if work.get(stage, 0.0) > 0.0
    )
    return wall_seconds + change
