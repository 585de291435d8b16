"""The system that relaxation and elimination solve: x = d + S ρ x for x = A½ E."""

from __future__ import annotations

import time

import numpy as np

from hradiosity.solvers.measure import Measure, Sets
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Convergence, Progress, Solved, Watch


class System:
    """E = D + F ρ E for all columns, each set of connected elements brought to one brightness.

    With x = A½ E it reads x = d + S ρ x, d = A½ D. Residuals are those of w = R½ (x − d), as the conjugate gradients
    have them, so that all solvers stop at the same light.

    Parameters
    ----------
    solver : str
        Name of the solver, for its account.
    operator : ExchangeOperator
    reflectance, direct : (n_rows, 8 n_groups)
    tolerance : float
        See `hradiosity.solvers.krylov.solve_irradiance`.
    start : (n_rows, 8 n_groups), optional
        First guess of E − D.
    watch : Watch, optional

    Attributes
    ----------
    direct, reflected_once : (n_rows, 8 n_groups), d and S ρ d
    guess : (n_rows, 8 n_groups), x to start from; None for d
    history : residuals so far
    shots : products that were not made as such: shots or sweeps, over what counts as one
    """

    def __init__(
        self,
        solver: str,
        operator: ExchangeOperator,
        reflectance: Columns,
        direct: Columns,
        *,
        tolerance: float,
        start: Columns | None = None,
        watch: Watch | None = None,
    ) -> None:
        self._cpu, self._before = time.process_time(), operator.products
        self.solver, self.operator, self.tolerance = solver, operator, tolerance
        area = operator.root_area[:, None]
        unscaled = area * direct.astype(operator.dtype)
        sets = Sets(operator.component)
        self._brightness = sets.largest(unscaled)
        # What nothing shines on stays dark whatever it reflects.
        self.reflectance = np.where(self._brightness > 0.0, reflectance, 0.0).astype(operator.dtype)
        per_set = np.divide(1.0, self._brightness, out=np.ones_like(self._brightness), where=self._brightness > 0.0)
        self.direct = unscaled * per_set
        self.reflected_once = operator.apply(self.reflectance * self.direct)
        self._root = np.sqrt(self.reflectance)
        self._measure = Measure(sets, self._root * self.reflected_once, self._root * self.direct, operator.root_area**2)
        self._given, self._watch = direct, watch
        self.guess: Columns | None = (
            None if start is None else self.direct + area * start.astype(operator.dtype) * per_set
        )
        self.history: list[float] = []
        self.shots = 0.0

    @property
    def products(self) -> float:
        """Products with S so far, or their equivalent."""
        return self.operator.products - self._before + self.shots

    def residual(self, change: Columns, light: Columns) -> float:
        """Size of a residual d + S ρ x − x of a light x; kept in the history, and shown to whoever watches."""
        found = self._measure(self._root * change, self._root * (light - self.direct))
        self.history.append(found)
        if self._watch is not None:
            self._watch(Progress(self.solver, self.products, found, lambda: self.irradiance(light)))
        return found

    def irradiance(self, light: Columns) -> Columns:
        """E of an x; exactly D where nothing arrives beside it."""
        indirect = self.operator.inverse_root_area[:, None] * (light - self.direct) * self._brightness
        return self._given.astype(self.operator.dtype) + indirect

    def solved(self, light: Columns, backward_error: float | None = None, condition: float | None = None) -> Solved:
        """The result, with its account."""
        convergence = Convergence(
            residual=tuple(self.history),
            converged=self.history[-1] <= self.tolerance,
            products=self.products,
            solved_columns=self.direct.shape[1],
            solver=self.solver,
            seconds=time.process_time() - self._cpu,
            backward_error=backward_error,
            condition=condition,
        )
        return Solved(self.irradiance(light), convergence)

    def next_light(self, light: Columns) -> Columns:
        """D + S ρ x: one reflection more."""
        return self.direct + self.operator.apply(self.reflectance * light)
