"""Block conjugate gradients with deflation, all columns at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.solve.operator import ExchangeOperator

LANCZOS_STEPS = 20
DEFLATE_ABOVE = 0.8
"""Ritz values of S above this are deflated; each is a nearly constant vector on one space."""


@dataclass(frozen=True)
class Convergence:
    """How an iteration went.

    residual : largest relative residual over the columns and sets of connected elements, one an iteration, the start
        first
    converged : whether the tolerance was met
    products : products with the operator, those for deflation included
    deflated : number of deflation vectors
    """

    residual: tuple[float, ...]
    converged: bool
    products: int
    deflated: int


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
        Residual over right-hand side, for every column and every set of connected elements.
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
    coarse = None if deflation is None or deflation.shape[1] == 0 else _Coarse(operator, root, deflation)
    sets = _Sets(operator.component)
    brightness = sets.largest(rhs)
    per_set = np.divide(1.0, brightness, out=np.ones_like(brightness), where=brightness > 0.0)
    solution, residual = _conjugate_gradients(
        operator, root, rhs * per_set, guess * per_set, coarse, sets, tolerance, max_iterations
    )
    solution = solution * brightness
    indirect = operator.inverse_root_area[:, None] * operator.apply(root * (emitted + solution))
    convergence = Convergence(
        residual=tuple(residual),
        converged=residual[-1] <= tolerance,
        products=operator.products - before,
        deflated=0 if coarse is None else coarse.size,
    )
    return direct + indirect, convergence


def deflation_vectors(operator: ExchangeOperator, spaces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Ritz vectors of S with values above 0.8, (n_rows, k): one for each nearly closed space.

    Parameters
    ----------
    spaces : (n_rows,) int32
        Connected space of each element; the start holds one vector for each (at most 8), so that spaces which are
        not connected at all are found as well.
    """
    n_spaces = min(int(spaces.max(initial=-1)) + 1, 8)
    rng = np.random.Generator(np.random.Philox(key=1))
    start = [operator.root_area * (spaces == k) for k in range(n_spaces)]
    start.append(operator.root_area * (1.0 + rng.random(operator.shape[0])))
    basis: list[NDArray[np.float64]] = []
    images: list[NDArray[np.float64]] = []
    for vector in start:
        candidate = np.asarray(vector, np.float64)
        for _ in range(LANCZOS_STEPS if vector is start[-1] else 1):
            candidate = _orthonormalise(candidate, basis)
            if not candidate.any():
                break
            basis.append(candidate)
            images.append(operator.apply_vector(candidate))
            candidate = images[-1]
    if not basis:
        return np.zeros((operator.shape[0], 0))
    q, image = np.column_stack(basis), np.column_stack(images)
    values, vectors = np.linalg.eigh(np.einsum("ni,nj->ij", q, image))
    kept: NDArray[np.float64] = np.einsum("ni,ik->nk", q, vectors[:, values > DEFLATE_ABOVE])
    return kept


def _orthonormalise(vector: NDArray[np.float64], basis: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    size = np.sqrt(np.einsum("n,n->", vector, vector))
    for _ in range(2):
        for q in basis:
            vector = vector - np.einsum("n,n->", q, vector) * q
    norm = np.sqrt(np.einsum("n,n->", vector, vector))
    return vector / norm if norm > 1e-10 * size else np.zeros_like(vector)


class _Coarse:
    """The deflation space of each column: W, A W and (Wᵀ A W)⁻¹ with A = I − R½ S R½."""

    def __init__(
        self, operator: ExchangeOperator, root: NDArray[np.float32], vectors: NDArray[np.float64]
    ) -> None:
        self.size = vectors.shape[1]
        self._w = vectors.astype(np.float32)
        self._aw = [w[:, None] - root * operator.apply(root * w[:, None]) for w in self._w.T]
        small = np.array([[_dot(w[:, None], aw) for aw in self._aw] for w in self._w.T])
        self._inverse = np.linalg.inv(np.moveaxis(small, 2, 0))

    def solve(self, residual: NDArray[np.float32]) -> NDArray[np.float32]:
        """W (Wᵀ A W)⁻¹ Wᵀ r."""
        return self._combine(np.array([_dot(w[:, None], residual) for w in self._w.T]))

    def project(self, residual: NDArray[np.float32]) -> NDArray[np.float32]:
        """W (Wᵀ A W)⁻¹ (A W)ᵀ r: the part of a direction that is not conjugate to W."""
        return self._combine(np.array([_dot(aw, residual) for aw in self._aw]))

    def _combine(self, right: NDArray[np.float64]) -> NDArray[np.float32]:
        factors = np.einsum("cij,jc->ic", self._inverse, right).astype(np.float32)
        combined: NDArray[np.float32] = np.einsum("ni,ic->nc", self._w, factors)
        return combined


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
            return np.sqrt(_dot(x, x))[None]
        return np.sqrt([_dot(part, part) for part in (x[rows] for rows in self._rows)])

    def largest(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Largest |x| in each row's set, (n_rows, n_columns); (1, n_columns) if all are one set."""
        size = np.array([np.abs(x[rows]).max(axis=0, initial=0.0) for rows in self._rows])
        found: NDArray[np.float32] = size if len(size) == 1 else size[self._component]
        return found


def _conjugate_gradients(
    operator: ExchangeOperator,
    root: NDArray[np.float32],
    rhs: NDArray[np.float32],
    solution: NDArray[np.float32],
    coarse: _Coarse | None,
    sets: _Sets,
    tolerance: float,
    max_iterations: int,
) -> tuple[NDArray[np.float32], list[float]]:
    """Deflated conjugate gradients (Saad, Yeung, Erhel & Guyomarc'h 2000), scalars per column."""

    def apply(x: NDArray[np.float32]) -> NDArray[np.float32]:
        return x - root * operator.apply(root * x)

    size = sets.norms(rhs)
    residual = rhs - apply(solution) if solution.any() else rhs.copy()
    if coarse is not None:
        correction = coarse.solve(residual)
        solution = solution + correction
        residual = residual - apply(correction)
    direction = residual if coarse is None else residual - coarse.project(residual)
    power = _dot(residual, residual)
    history = [_worst(sets.norms(residual), size)]
    while history[-1] > tolerance and len(history) <= max_iterations:
        image = apply(direction)
        step = _ratio(power, _dot(direction, image))
        solution = solution + step * direction
        residual = residual - step * image
        fresh = _dot(residual, residual)
        direction = residual + _ratio(fresh, power) * direction
        if coarse is not None:
            direction = direction - coarse.project(residual)
        power = fresh
        history.append(_worst(sets.norms(residual), size))
    return solution, history


def _dot(x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float64]:
    """Product of each column, summed in float64."""
    total: NDArray[np.float64] = np.add.reduce(x * y, axis=0, dtype=np.float64)
    return total


def _ratio(above: NDArray[np.float64], below: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0).astype(np.float32)


def _worst(norms: NDArray[np.float64], size: NDArray[np.float64]) -> float:
    return float(_ratio(norms, size).max(initial=0.0))
