"""Block conjugate gradients with deflation, all columns at once."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_dot, column_ratio
from hradiosity.solvers.deflation import CoarseSpace
from hradiosity.solvers.measure import Measure, Sets
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Convergence, Progress, Solved, Watch

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
    reflectance, direct = reflectance.astype(operator.dtype), direct.astype(operator.dtype)
    root = np.sqrt(reflectance)
    area = operator.root_area[:, None]
    emitted = area * root * direct
    rhs = root * operator.apply(root * emitted)
    coarse = None if deflation is None or deflation.shape[1] == 0 else CoarseSpace(operator, root, deflation)
    sets = Sets(operator.component)
    brightness = sets.largest(rhs)
    per_set = np.divide(1.0, brightness, out=np.ones_like(brightness), where=brightness > 0.0)
    guess = np.zeros_like(rhs)
    if start is not None:
        # Where nothing can arrive, a guess would only shrink, and never become small beside the light there.
        lit = operator.linked[:, None] & (brightness > 0.0)
        guess = np.where(lit, area * root * start, guess)
    measure = Measure(sets, rhs * per_set, emitted * per_set, operator.root_area**2)

    def irradiance(found: Columns) -> Columns:
        return direct + operator.inverse_root_area[:, None] * operator.apply(root * (emitted + found * brightness))

    def step(residual: float, found: Columns) -> None:
        if watch is not None:
            counted = operator.products
            watch(Progress("cg", counted - before + 1, residual, lambda: irradiance(found)))
            operator.products = counted

    solution, residual = _conjugate_gradients(
        operator, root, rhs * per_set, guess * per_set, coarse, measure, tolerance, max_iterations, step
    )
    result = irradiance(solution)
    convergence = Convergence(
        residual=tuple(residual),
        converged=min(residual) <= tolerance,
        products=operator.products - before,
        deflated=0 if coarse is None else coarse.size,
        solved_columns=direct.shape[1],
        seconds=time.process_time() - cpu,
    )
    return Solved(result, convergence)


def _conjugate_gradients(
    operator: ExchangeOperator,
    root: Columns,
    rhs: Columns,
    solution: Columns,
    coarse: CoarseSpace | None,
    measure: Measure,
    tolerance: float,
    max_iterations: int,
    watch: Callable[[float, Columns], None],
) -> tuple[Columns, list[float]]:
    """Deflated conjugate gradients (Saad, Yeung, Erhel & Guyomarc'h 2000), scalars per column.

    Stops at the tolerance, or when single precision lets nothing improve any more; the best solution is returned.
    """

    def apply(x: Columns) -> Columns:
        return x - root * operator.apply(root * x)

    residual = rhs - apply(solution) if solution.any() else rhs.copy()
    if coarse is not None:
        correction, its_image = coarse.remove(residual)
        solution = solution + correction
        residual = residual - its_image
    direction = residual if coarse is None else residual - coarse.project(residual)
    power = column_dot(residual, residual)
    history = [measure(residual, solution)]
    best = solution
    while history[-1] > tolerance and len(history) <= max_iterations and _improves(history):
        image = apply(direction)
        step = column_ratio(power, column_dot(direction, image), operator.dtype)
        solution = solution + step * direction
        residual = residual - step * image
        if coarse is not None:
            # Rounding puts a little of W back into the residual, and without this it grows without bound.
            correction, its_image = coarse.remove(residual)
            solution = solution + correction
            residual = residual - its_image
        fresh = column_dot(residual, residual)
        direction = residual + column_ratio(fresh, power, operator.dtype) * direction
        if coarse is not None:
            direction = direction - coarse.project(direction)
        power = fresh
        history.append(measure(residual, solution))
        if history[-1] <= min(history):
            best = solution
        watch(history[-1], solution)
    return best, history


def _improves(history: list[float]) -> bool:
    """Whether one of the last `PATIENCE` values is the smallest."""
    return min(history[-PATIENCE:]) <= min(history)
