"""The light of the rows of one mesh, replicate after replicate: what each solution tells the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.radiosity.row_light import RowLight, light_of_glow
from hradiosity.radiosity.row_means import RowMeans
from hradiosity.readings.interval import part_of
from hradiosity.solvers.deflation import DEFLATE_ABOVE, deflation_vectors
from hradiosity.solvers.error_growth import ErrorGrowth, error_growth
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Convergence, Watch

SINGLE_PRECISION = 1e-5
"""Largest relative error of a reading by rounding; tests compare single with double precision."""


class Iteration:
    """Solutions that start from the mean of those before, with one set of deflation vectors.

    Parameters
    ----------
    solver : RowLight
    space : (n_rows,) int32
        Connected space that each row looks into.
    area : (n_rows,) float64
        Of the rows [m²], covered parts included.

    Attributes
    ----------
    solver : RowLight
    means : RowMeans
        Over the replicates so far.
    deflation : (n_rows, k) float64, or None before the first solution
    """

    def __init__(self, solver: RowLight, space: NDArray[np.int32], area: NDArray[np.float64]) -> None:
        self.solver = solver
        self.means = RowMeans(len(space), 8 * solver.plan.columns.n_groups)
        self.deflation: NDArray[np.float64] | None = None
        self._space, self._area = space, area
        self._growth: ErrorGrowth | None = None

    def light(
        self,
        operator: ExchangeOperator,
        element_area: NDArray[np.float64],
        reflectance: NDArray[np.float32],
        direct: NDArray[np.float32],
        row_glow: NDArray[np.float32],
        watch: Watch | None = None,
    ) -> tuple[NDArray[np.float32], list[Convergence]]:
        """Irradiance (n_rows, 8 n_groups) of one more replicate, and how it was come by; not yet in the means.

        Parameters
        ----------
        operator : ExchangeOperator
        element_area : (n_rows,) float64
            Exposed area of each row [m²].
        reflectance, direct, row_glow : (n_rows, 8 n_groups) float32
        watch : Watch, optional
            Called after each step.
        """
        glow = light_of_glow(operator, row_glow)
        lit = direct + glow
        if not self.solver.plan.interreflection:
            return lit, []
        if self.deflation is None:
            mean_reflectance = np.einsum("r,rc->c", element_area, reflectance) / element_area.sum()
            bright = float(mean_reflectance.max(initial=0.0)) > DEFLATE_ABOVE
            self.deflation = deflation_vectors(operator, self._space) if bright else np.zeros((len(direct), 0))
        start = self.means.indirect.astype(np.float32) - glow if self.means.count else None
        irradiance, account = self.solver.solve(operator, reflectance, lit, start, self.deflation, watch=watch)
        if self._growth is None:
            self._growth = error_growth(operator, reflectance, lit, irradiance)
        return irradiance, account

    def add(
        self, irradiance: NDArray[np.float32], direct: NDArray[np.float32], element_area: NDArray[np.float64]
    ) -> None:
        """Take one more replicate into the means; `element_area` (n_rows,) is exposed [m²]."""
        exposed = np.divide(element_area, self._area, out=np.zeros_like(element_area), where=self._area > 0.0)
        self.means.add(irradiance, direct, exposed)

    def shared_errors(self, convergence: list[Convergence]) -> dict[str, float]:
        """By part of the intervals: share of itself that each band may be off by in all replicates alike."""
        shares = {"precision": SINGLE_PRECISION}
        if self._growth is not None:
            used = [c for c in convergence if self.solver.accepts(c)]
            shares["iteration"] = self._growth.residual * max(c.residual[-1] for c in used)
            shares["spectral"] = self._growth.reflection * max(c.spectral_defect for c in used)
        return shares

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs beside the constructor's arguments."""
        kept: dict[str, NDArray[Any]] = {f"means/{name}": array for name, array in self.means.checkpoint().items()}
        if self.deflation is not None:
            kept["deflation"] = self.deflation
        if self._growth is not None:
            kept["growth"] = np.array(self._growth)
        return kept

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a checkpoint, bit for bit."""
        self.deflation = kept.get("deflation")
        self._growth = ErrorGrowth(*(float(value) for value in kept["growth"])) if "growth" in kept else None
        self.means.restore(part_of(kept, "means"))
