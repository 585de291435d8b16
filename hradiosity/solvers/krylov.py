"""Block conjugate gradients with deflation, all columns at once."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_ratio
from hradiosity.solvers.deflation import CoarseSpace
from hradiosity.solvers.measure import Measure, Sets
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Convergence, Progress, Solved, Watch
from hradiosity.solvers.vectors import V, Vectors, vectors_for

PATIENCE = 20
"""Iterations without a smaller residual after which single precision is taken to be exhausted."""


def solve_irradiance(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float = 1e-4,
    max_iterations: int = 200,
    start: Columns | None = None,
    deflation: NDArray[np.float64] | None = None,
    watch: Watch | None = None,
) -> Solved:
    """Irradiance of every element: E = D + F ρ E.

    Solved as (I − R½ S R½) w = R½ S R½ b with b = A½ R½ D for w = A½ R½ (E − D), which stays finite for black
    elements; then E − D = A^-½ S R½ (b + w), which smooths once more. Each set of connected elements is brought to
    the same brightness before and back afterwards: a night light keeps its digits beside a sealed bright room.

    Parameters
    ----------
    operator : ExchangeOperator
    reflectance, direct : (n_rows, 8 n_groups) float32
        Reflectance [1] and direct irradiance of each element and column.
    tolerance : float
        Residual over right-hand side, for every column and every set of connected elements; of the elements' own
        relative residuals, the rms by area may be ten times that.
    start : (n_rows, 8 n_groups) float32, optional
        First guess of the indirect irradiance E − D.
    deflation : (n_rows, k) float64, optional
        Orthonormal vectors, from `deflation_vectors`.
    watch : Watch, optional
        Called after each step.
    """
    before, cpu = operator.products, time.process_time()
    system = _Symmetric.of(operator, reflectance, direct)
    sets = Sets(operator.component)
    vectors = vectors_for(operator, system.root, sets)
    coarse = None if deflation is None or deflation.shape[1] == 0 else CoarseSpace(vectors, system.root, deflation)
    brightness = sets.largest(system.rhs)
    per_set = np.divide(1.0, brightness, out=np.ones_like(brightness), where=brightness > 0.0)
    guess = system.guess(start, brightness)
    measure = Measure(sets, system.rhs * per_set, system.emitted * per_set, operator.root_area**2)

    def step(residual: float, found: Any) -> None:
        if watch is not None:
            counted = operator.products
            shown = Progress(
                "cg", counted - before + 1, residual, lambda: system.irradiance(vectors.get(found) * brightness)
            )
            watch(shown)
            operator.products = counted

    solution, residual = _conjugate_gradients(
        vectors, system.rhs * per_set, guess * per_set, coarse, measure, tolerance, max_iterations, step
    )
    result = system.irradiance(vectors.get(solution) * brightness)
    convergence = Convergence(
        residual=tuple(residual),
        converged=min(residual) <= tolerance,
        products=operator.products - before,
        deflated=0 if coarse is None else coarse.size,
        solved_columns=direct.shape[1],
        seconds=time.process_time() - cpu,
    )
    return Solved(result, convergence)


@dataclass(frozen=True)
class _Symmetric:
    """(I − R½ S R½) w = R½ S R½ b, see `solve_irradiance`.

    direct : (n_rows, n_columns)
    root : (n_rows, n_columns), R½
    emitted, rhs : (n_rows, n_columns), b and the right-hand side
    """

    operator: ExchangeOperator
    direct: Columns
    root: Columns
    emitted: Columns
    rhs: Columns

    @classmethod
    def of(cls, operator: ExchangeOperator, reflectance: Columns, direct: Columns) -> _Symmetric:
        reflectance, direct = reflectance.astype(operator.dtype), direct.astype(operator.dtype)
        root = np.sqrt(reflectance)
        emitted = operator.root_area[:, None] * root * direct
        return cls(operator, direct, root, emitted, root * operator.apply(root * emitted))

    def guess(self, start: Columns | None, brightness: Columns) -> Columns:
        """First w, for an indirect irradiance; where nothing can arrive (no `brightness`), a guess would only shrink,
        and never become small beside the light there.
        """
        if start is None:
            return np.zeros_like(self.rhs)
        lit = self.operator.linked[:, None] & (brightness > 0.0)
        return np.where(lit, self.operator.root_area[:, None] * self.root * start, np.zeros_like(self.rhs))

    def irradiance(self, found: Columns) -> Columns:
        """E of a solution w."""
        arriving = self.operator.apply(self.root * (self.emitted + found))
        return self.direct + self.operator.inverse_root_area[:, None] * arriving


def _conjugate_gradients(
    vectors: Vectors[V],
    rhs: Columns,
    guess: Columns,
    coarse: CoarseSpace[V] | None,
    measure: Measure,
    tolerance: float,
    max_iterations: int,
    watch: Callable[[float, V], None],
) -> tuple[V, list[float]]:
    """Deflated conjugate gradients (Saad, Yeung, Erhel & Guyomarc'h 2000), scalars per column.

    Stops at the tolerance, or when single precision lets nothing improve any more; the best solution is returned.
    """
    ones = np.ones(rhs.shape[1])
    solution, residual, image = (vectors.put(x) for x in (guess, rhs, np.zeros_like(rhs)))

    def measured() -> tuple[NDArray[np.float64], float]:
        squares = vectors.products(residual, residual)
        picked = (vectors.pick(x, measure.every) for x in (residual, solution))
        return squares.sum(axis=0), measure.of_picked(np.sqrt(squares), *picked)

    if guess.any():
        vectors.image(image, solution)
        vectors.add(residual, -ones, image)
    if coarse is not None:
        coarse.remove(residual, solution)
    direction, best = vectors.put(rhs), vectors.put(guess)
    vectors.assign(direction, residual)
    vectors.assign(best, solution)
    if coarse is not None:
        coarse.project(residual, direction)
    power, size = measured()
    history = [size]
    while history[-1] > tolerance and len(history) <= max_iterations and _improves(history):
        vectors.image(image, direction)
        step = column_ratio(power, vectors.products(direction, image).sum(axis=0), np.float64)
        vectors.add(solution, step, direction)
        vectors.add(residual, -step, image)
        if coarse is not None:
            # Rounding puts a little of W back into the residual, and without this it grows without bound.
            coarse.remove(residual, solution)
        fresh, size = measured()
        vectors.turn(direction, column_ratio(fresh, power, np.float64), residual)
        if coarse is not None:
            coarse.project(direction, direction)
        power = fresh
        history.append(size)
        if size <= min(history):
            vectors.assign(best, solution)
        watch(size, solution)
    return best, history


def _improves(history: list[float]) -> bool:
    """Whether one of the last `PATIENCE` values is the smallest."""
    return min(history[-PATIENCE:]) <= min(history)
