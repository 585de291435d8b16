"""Block conjugate gradients with deflation, all columns at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_dot, column_ratio
from hradiosity.solvers.deflation import CoarseSpace
from hradiosity.solvers.operator import ExchangeOperator

LOCAL_SHARE = 0.1
"""Weight of the elements' own relative residuals beside the residual of the whole."""
PATIENCE = 20
"""Iterations without a smaller residual after which single precision is taken to be exhausted."""
TINY = np.finfo(np.float64).tiny


@dataclass(frozen=True)
class Convergence:
    """How an iteration went.

    residual : largest relative residual over the columns and sets of connected elements, or a tenth of the elements'
        own ones if that is larger; one an iteration, the start first
    converged : whether the tolerance was met
    products : products with the operator, those for deflation included
    deflated : number of deflation vectors
    solved_columns : right-hand sides that were iterated on
    spectral_defect : largest relative change, over the columns, by one more reflection of light that was combined
        from the solved columns; 0 when all were solved
    """

    residual: tuple[float, ...]
    converged: bool
    products: int
    deflated: int
    solved_columns: int = 0
    spectral_defect: float = 0.0


def solve_irradiance(
    operator: ExchangeOperator,
    reflectance: NDArray[np.float32],
    direct: NDArray[np.float32],
    *,
    tolerance: float = 1e-4,
    max_iterations: int = 200,
    start: NDArray[np.float32] | None = None,
    deflation: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.float32], Convergence]:
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

    Returns
    -------
    irradiance : (n_rows, 8 n_groups) float32
    convergence : Convergence
    """
    before = operator.products
    root = np.sqrt(reflectance)
    area = operator.root_area[:, None]
    emitted = area * root * direct
    rhs = root * operator.apply(root * emitted)
    guess = np.zeros_like(rhs) if start is None else area * root * start
    coarse = None if deflation is None or deflation.shape[1] == 0 else CoarseSpace(operator, root, deflation)
    sets = _Sets(operator.component)
    brightness = sets.largest(rhs)
    per_set = np.divide(1.0, brightness, out=np.ones_like(brightness), where=brightness > 0.0)
    measure = _Measure(sets, rhs * per_set, emitted * per_set, operator.root_area**2)
    solution, residual = _conjugate_gradients(
        operator, root, rhs * per_set, guess * per_set, coarse, measure, tolerance, max_iterations
    )
    solution = solution * brightness
    indirect = operator.inverse_root_area[:, None] * operator.apply(root * (emitted + solution))
    convergence = Convergence(
        residual=tuple(residual),
        converged=min(residual) <= tolerance,
        products=operator.products - before,
        deflated=0 if coarse is None else coarse.size,
        solved_columns=direct.shape[1],
    )
    return direct + indirect, convergence


class _Sets:
    """Sums and maxima over sets of connected elements, (n_rows,) numbers from 0."""

    def __init__(self, component: NDArray[np.int32]) -> None:
        self._component = component
        order = np.argsort(component, kind="stable")
        ends = np.cumsum(np.bincount(component, minlength=1))[:-1]
        self._rows = np.split(order, ends)

    def norms(self, x: NDArray[np.float32]) -> NDArray[np.float64]:
        """Euclidean norm of each set and column, (n_sets, n_columns)."""
        if len(self._rows) == 1:
            return np.sqrt(column_dot(x, x))[None]
        return np.sqrt([column_dot(part, part) for part in (x[rows] for rows in self._rows)])

    def largest(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Largest |x| in each row's set, (n_rows, n_columns); (1, n_columns) if all are one set."""
        size = np.array([np.abs(x[rows]).max(axis=0, initial=0.0) for rows in self._rows])
        found: NDArray[np.float32] = size if len(size) == 1 else size[self._component]
        return found


class _Measure:
    """How far a solution is from one, as the largest over columns of two ratios.

    One is the norm of the residual over that of the right-hand side, in each set of connected elements. It says nothing
    about a dim room behind a gap, whose light is all below the tolerance; so the other is the rms over elements, by
    area, of residual over own light, which may be ten times larger. A thousand elements, evenly picked, stand for all.
    """

    def __init__(
        self, sets: _Sets, rhs: NDArray[np.float32], emitted: NDArray[np.float32], area: NDArray[np.float32]
    ) -> None:
        self._sets = sets
        self._size = sets.norms(rhs)
        self._picked = slice(None, None, max(1, len(area) // 1024))
        self._emitted = emitted[self._picked]
        picked_area = area[self._picked].astype(np.float64)
        self._share = picked_area / max(float(picked_area.sum()), TINY)

    def __call__(self, residual: NDArray[np.float32], solution: NDArray[np.float32]) -> float:
        size = np.abs(residual[self._picked])
        level = np.abs(solution[self._picked]) + self._emitted + size
        own = np.divide(size, level, out=np.zeros_like(size), where=level > 0.0)
        local = np.sqrt(np.einsum("r,rc,rc->c", self._share, own, own))
        everywhere = column_ratio(self._sets.norms(residual), self._size)
        return max(float(everywhere.max(initial=0.0)), LOCAL_SHARE * float(local.max(initial=0.0)))


def _conjugate_gradients(
    operator: ExchangeOperator,
    root: NDArray[np.float32],
    rhs: NDArray[np.float32],
    solution: NDArray[np.float32],
    coarse: CoarseSpace | None,
    measure: _Measure,
    tolerance: float,
    max_iterations: int,
) -> tuple[NDArray[np.float32], list[float]]:
    """Deflated conjugate gradients (Saad, Yeung, Erhel & Guyomarc'h 2000), scalars per column.

    Stops at the tolerance, or when single precision lets nothing improve any more; the best solution is returned.
    """

    def apply(x: NDArray[np.float32]) -> NDArray[np.float32]:
        return x - root * operator.apply(root * x)

    residual = rhs - apply(solution) if solution.any() else rhs.copy()
    if coarse is not None:
        correction = coarse.solve(residual)
        solution = solution + correction
        residual = residual - apply(correction)
    direction = residual if coarse is None else residual - coarse.project(residual)
    power = column_dot(residual, residual)
    history = [measure(residual, solution)]
    best = solution
    while history[-1] > tolerance and len(history) <= max_iterations and _improves(history):
        image = apply(direction)
        step = column_ratio(power, column_dot(direction, image))
        solution = solution + step * direction
        residual = residual - step * image
        if coarse is not None:
            # Rounding puts a little of W back into the residual, and without this it grows without bound.
            correction, its_image = coarse.remove(residual)
            solution = solution + correction
            residual = residual - its_image
        fresh = column_dot(residual, residual)
        direction = residual + column_ratio(fresh, power) * direction
        if coarse is not None:
            direction = direction - coarse.project(direction)
        power = fresh
        history.append(measure(residual, solution))
        if history[-1] <= min(history):
            best = solution
    return best, history


def _improves(history: list[float]) -> bool:
    """Whether one of the last `PATIENCE` values is the smallest."""
    return min(history[-PATIENCE:]) <= min(history)
