"""Solution on a few columns, from which the others are combined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.choice import SolverChoice, solve_system
from hradiosity.solvers.column_algebra import column_dot, column_ratio
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Solved
from hradiosity.solvers.spectral_basis import SpectralBasis


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
    few, convergence = solve_system(
        replace(choice, weight=weight),
        operator,
        solved(reflectance),
        few_direct,
        tolerance=tolerance,
        start=None if start is None else solved(start),
        deflation=deflation,
    )
    indirect = np.zeros_like(direct)
    n_columns = basis.combination.shape[1]
    indirect[:, :n_columns] = np.einsum("rk,kc->rc", (few - few_direct)[:, : len(basis.solved)], basis.combination)
    leaving = operator.root_area[:, None] * reflectance * (direct + indirect)
    smoothed = operator.inverse_root_area[:, None] * operator.apply(leaving)
    weight = operator.root_area[:, None]
    change = np.sqrt(column_dot(weight * (smoothed - indirect), weight * (smoothed - indirect)))
    defect = float(column_ratio(change, np.sqrt(column_dot(weight * smoothed, weight * smoothed))).max(initial=0.0))
    account = replace(
        convergence,
        products=convergence.products + 1,
        solved_columns=len(basis.solved),
        spectral_defect=defect,
    )
    return Solved(direct + smoothed, account)
