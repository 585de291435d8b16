"""Solution on a few columns, from which the others are combined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.solvers.choice import SolverChoice, solve_system
from hradiosity.solvers.column_algebra import column_ratio
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Progress, Solved, Watch
from hradiosity.solvers.spectral_basis import SpectralBasis
from hradiosity.solvers.vectors import squares


def solve_by_basis(
    choice: SolverChoice,
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    basis: SpectralBasis,
    *,
    tolerance: float,
    start: Columns | None = None,
    deflation: NDArray[np.float64] | None = None,
    watch: Watch | None = None,
) -> Solved:
    """As `solve_system`, iterating on the basis' columns only; the others are combined and reflected once more.

    That reflection with each column's own reflectance takes away most of what the combination misses; how much it
    changes is the certificate, `Convergence.spectral_defect`.
    """
    width = -(-len(basis.solved) // 8) * 8

    def solved(columns: Columns) -> Columns:
        few = np.zeros((len(columns), width), np.float32)
        few[:, : len(basis.solved)] = columns[:, basis.solved]
        return few

    weight = None if choice.weight is None else solved(choice.weight[None])[0]

    few_direct = solved(direct)

    def relay(progress: Progress) -> None:
        def light() -> Columns:
            return direct + _combined(operator.device, progress.irradiance() - few_direct, basis, direct.shape[1])

        if watch is not None:
            watch(replace(progress, irradiance=light))

    few, convergence = solve_system(
        replace(choice, weight=weight),
        operator,
        solved(reflectance),
        few_direct,
        tolerance=tolerance,
        start=None if start is None else solved(start),
        deflation=deflation,
        watch=None if watch is None else relay,
    )
    indirect = _combined(operator.device, few - few_direct, basis, direct.shape[1])
    area = operator.root_area[:, None]
    leaving = direct + indirect
    leaving *= reflectance
    leaving *= area
    smoothed = operator.apply(leaving)
    # Both by root areas: norms over the surfaces.
    indirect *= area
    change = squares(operator.device, smoothed - indirect)
    defect = float(np.sqrt(column_ratio(change, squares(operator.device, smoothed))).max(initial=0.0))
    smoothed *= operator.inverse_root_area[:, None]
    account = replace(
        convergence,
        products=convergence.products + 1,
        solved_columns=len(basis.solved),
        spectral_defect=defect,
    )
    smoothed += direct
    return Solved(smoothed, account)


def _combined(device: Device, few: Columns, basis: SpectralBasis, width: int) -> Columns:
    """(n_rows, width) light of all columns, from that of the solved ones."""
    combination = np.zeros((few.shape[1], width), np.float32)
    combination[: len(basis.solved), : basis.combination.shape[1]] = basis.combination
    combined = device.empty((len(few), width), np.float32)
    device.kernel("columns", "combine_columns", HR_GROUPS=width // 8)(
        len(few),
        factors=device.upload(few, np.float32),
        combination=device.upload(combination),
        combined=combined,
        n_factors=few.shape[1],
    )
    fetched: Columns = device.fetch(combined).reshape(len(few), width)
    return fetched
