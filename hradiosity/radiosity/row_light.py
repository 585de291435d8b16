"""The light of row elements, given their exchange: fine rows and their coarser companions alike."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import Options
from hradiosity.plan import Plan
from hradiosity.solvers.choice import SolverChoice, solve_system
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.reduced import solve_by_basis
from hradiosity.solvers.result import Convergence, Watch
from hradiosity.solvers.spectral_basis import SpectralBasis

SPECTRAL_DEFECT = 5.0
"""Columns that combination leaves worse than this many solver tolerances are solved after all."""
DIFFERENCE_TOLERANCE = 3e-5
"""Solver tolerance where variants are compared: what stops the iteration does not cancel as random errors do. It costs
half as many iterations again, since the last ones start from combined columns."""


@dataclass(frozen=True)
class RowLight:
    """How the light of row elements is found.

    plan, options : of the run
    choice : the solver
    basis : columns to iterate on; None for all
    """

    plan: Plan
    options: Options
    choice: SolverChoice
    basis: SpectralBasis | None

    def solve(
        self,
        operator: ExchangeOperator,
        reflectance: NDArray[np.float32],
        direct: NDArray[np.float32],
        start: NDArray[np.float32] | None,
        deflation: NDArray[np.float64] | None,
        watch: Watch | None = None,
    ) -> tuple[NDArray[np.float32], list[Convergence]]:
        """Irradiance (n_rows, 8 n_groups) that reflection makes of `direct`, on a basis where that is good enough.

        Parameters
        ----------
        operator : ExchangeOperator
        reflectance, direct : (n_rows, 8 n_groups) float32
        start : (n_rows, 8 n_groups) float32, optional
            First guess of what reflection adds.
        deflation : (n_rows, k) float64, optional
        watch : Watch, optional
            Called after each step.

        Returns
        -------
        irradiance : (n_rows, 8 n_groups) float32
        convergence : one a solution that was needed
        """
        tolerance = self.tolerance
        account = []
        if self.basis is not None:
            irradiance, convergence = solve_by_basis(
                self.choice,
                operator,
                reflectance,
                direct,
                self.basis,
                tolerance=tolerance,
                start=start,
                deflation=deflation,
                watch=watch,
            )
            account.append(convergence)
            if self.accepts(convergence):
                return irradiance, account
            start = irradiance - direct
        irradiance, convergence = solve_system(
            self.choice,
            operator,
            reflectance,
            direct,
            tolerance=tolerance,
            start=start,
            deflation=deflation,
            watch=watch,
        )
        account.append(replace(convergence, solved_columns=self.plan.columns.n_columns))
        return irradiance, account

    @property
    def tolerance(self) -> float:
        """Of the linear solver, residual over right-hand side."""
        asked = self.options.tolerance
        return min(asked, DIFFERENCE_TOLERANCE) if self.plan.columns.variants else asked

    def accepts(self, convergence: Convergence) -> bool:
        """Whether a solution on a basis is good enough for all columns."""
        return convergence.spectral_defect <= SPECTRAL_DEFECT * self.tolerance


def light_of_glow(operator: ExchangeOperator, row_glow: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n_rows, 8 n_groups) irradiance straight from rows that shine with the exitance `row_glow`."""
    if not row_glow.any():
        return np.zeros_like(row_glow)
    light = operator.inverse_root_area[:, None] * operator.apply(operator.root_area[:, None] * row_glow)
    return light.astype(np.float32)
