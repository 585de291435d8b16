"""Block conjugate gradients with deflation, all columns at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.solve.operator import ExchangeOperator
from hradiosity.solve.spectral_basis import SpectralBasis

LANCZOS_STEPS = 20
DEFLATE_ABOVE = 0.8
"""Ritz values of S above this are deflated; each is a nearly constant vector on one space."""
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
    coarse = None if deflation is None or deflation.shape[1] == 0 else _Coarse(operator, root, deflation)
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


def solve_by_basis(
    operator: ExchangeOperator,
    reflectance: NDArray[np.float32],
    direct: NDArray[np.float32],
    basis: SpectralBasis,
    *,
    tolerance: float,
    start: NDArray[np.float32] | None = None,
    deflation: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.float32], Convergence]:
    """As `solve_irradiance`, iterating on the basis' columns only; the others are combined and reflected once more.

    That reflection with each column's own reflectance takes away most of what the combination misses; how much it
    changes is the certificate, `Convergence.spectral_defect`.
    """

    def solved(columns: NDArray[np.float32]) -> NDArray[np.float32]:
        width = -(-len(basis.solved) // 8) * 8
        few = np.zeros((len(columns), width), np.float32)
        few[:, : len(basis.solved)] = columns[:, basis.solved]
        return few

    few_direct = solved(direct)
    few, convergence = solve_irradiance(
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
    change = np.sqrt(_dot(weight * (smoothed - indirect), weight * (smoothed - indirect)))
    defect = float(_ratio(change, np.sqrt(_dot(weight * smoothed, weight * smoothed))).max(initial=0.0))
    return direct + smoothed, replace(
        convergence,
        products=convergence.products + 1,
        solved_columns=len(basis.solved),
        spectral_defect=defect,
    )


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
    start.append(operator.root_area * (1.0 + rng.random(operator.n_rows)))
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
        return np.zeros((operator.n_rows, 0))
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

    def remove(self, residual: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """W c and A W c with c = (Wᵀ A W)⁻¹ Wᵀ r."""
        factors = self._factors(np.array([_dot(w[:, None], residual) for w in self._w.T]))
        image = np.zeros_like(residual)
        for aw, factor in zip(self._aw, factors):
            image += aw * factor
        return np.einsum("ni,ic->nc", self._w, factors), image

    def _factors(self, right: NDArray[np.float64]) -> NDArray[np.float32]:
        factors: NDArray[np.float32] = np.einsum("cij,jc->ic", self._inverse, right).astype(np.float32)
        return factors

    def _combine(self, right: NDArray[np.float64]) -> NDArray[np.float32]:
        combined: NDArray[np.float32] = np.einsum("ni,ic->nc", self._w, self._factors(right))
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
        everywhere = _ratio(self._sets.norms(residual), self._size)
        return max(float(everywhere.max(initial=0.0)), LOCAL_SHARE * float(local.max(initial=0.0)))


def _conjugate_gradients(
    operator: ExchangeOperator,
    root: NDArray[np.float32],
    rhs: NDArray[np.float32],
    solution: NDArray[np.float32],
    coarse: _Coarse | None,
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
    power = _dot(residual, residual)
    history = [measure(residual, solution)]
    best = solution
    while history[-1] > tolerance and len(history) <= max_iterations and _improves(history):
        image = apply(direction)
        step = _ratio(power, _dot(direction, image))
        solution = solution + step * direction
        residual = residual - step * image
        if coarse is not None:
            # Rounding puts a little of W back into the residual, and without this it grows without bound.
            correction, its_image = coarse.remove(residual)
            solution = solution + correction
            residual = residual - its_image
        fresh = _dot(residual, residual)
        direction = residual + _ratio(fresh, power) * direction
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


def _dot(x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float64]:
    """Product of each column, summed in float64."""
    total: NDArray[np.float64] = np.add.reduce(x * y, axis=0, dtype=np.float64)
    return total


def _ratio(above: NDArray[np.float64], below: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0).astype(np.float32)
