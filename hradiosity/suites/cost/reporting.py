"""The report of a run, whole or not."""

from __future__ import annotations

import numpy as np

from hradiosity.io.learnt import Learnt
from hradiosity.options import Options
from hradiosity.planning_seconds import BEFORE
from hradiosity.suites.cost.bench import SceneBench
from hradiosity.suites.cost.pricing import Truth, largest_spread, prices
from hradiosity.suites.cost.running import CostRun
from hradiosity.suites.cost.values import Report


def report_of(run: CostRun, bench: SceneBench, *, complete: bool) -> Report:
    """All that is known.

    Raises
    ------
    RuntimeError
        Before the reference began.
    ValueError
        When no reading has light.
    """
    truth = Truth.of(bench.reference.readings())
    return Report(
        scene=bench.scene.name,
        device=bench.device.description,
        budget=run.budget.seconds,
        spent=run.budget.spent,
        noise=truth.noise,
        spectral_noise=truth.spectral_noise,
        paths=bench.reference.paths,
        reference_cpu_seconds=bench.reference.cpu_seconds,
        readings=int(truth.lit.sum()),
        prices=tuple(prices(run.runs, truth)),
        skipped=tuple(run.skipped),
        solvers=tuple(run.extras.solvers),
        effects=tuple(run.extras.effects),
        bands=tuple(run.extras.bands),
        complete=complete,
    )


def learnt_of(run: CostRun) -> list[tuple[Options, Learnt]]:
    """What plan and render can use of each setting.

    Raises
    ------
    RuntimeError, ValueError
        See `report_of`.
    """
    found = []
    for price in run.prices():
        runs = [one for one in run.runs if one.setting.name == price.setting.name]
        first = float(np.mean([sum(one.stage_seconds.get(s, 0.0) for s in BEFORE) for one in runs]))
        each = float(np.mean([sum(one.stage_seconds.values()) / one.replicates for one in runs]))
        each -= first / runs[0].replicates
        learnt = Learnt(largest_spread(runs), first, each, price.illuminance.rms, price.sampling)
        found.append((price.setting.options, learnt))
    return found
