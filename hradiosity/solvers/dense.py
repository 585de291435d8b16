"""Direct solution in float64, a matrix for each column: referees for small scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Solved, Watch
from hradiosity.solvers.system import System

MOST_BYTES: Final = 512 * 2**20
"""Of all matrices that are held at a time."""
DIRECT_SOLVERS: Final = ("gaussian-elimination", "block-inversion")
MATRICES: Final = 4
"""S, the system, its factors or inverse, and a product on the way."""
REFINEMENTS: Final = 3

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class _Column:
    """Solution of one column, see `Convergence`."""

    light: Matrix
    backward_error: float
    condition: float


def check_dense_size(n_elements: int, solver: str) -> None:
    """`SceneError` when the matrices of a direct solver would be too large."""
    needed = dense_bytes(n_elements)
    if needed > MOST_BYTES:
        most = int(np.sqrt(MOST_BYTES / (8 * MATRICES)))
        found = f"{solver} would hold {MATRICES} matrices of {n_elements} × {n_elements} elements, {needed:.3g} bytes"
        expected = f"{MOST_BYTES:.3g} bytes or less, which {most} elements need; or an iterative solver"
        raise SceneError([Fault("command line", "--solver", found, expected)])


def dense_bytes(n_elements: int) -> int:
    """Memory of a direct solution."""
    return MATRICES * 8 * n_elements**2


def gaussian_elimination(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
) -> Solved:
    """Elimination with partial pivoting, then refinement by residuals that are summed in a fixed order.

    Raises
    ------
    SceneError
        When there are too many elements.
    """
    return _solve_each("gaussian-elimination", operator, reflectance, direct, tolerance, watch, _eliminate)


def block_inversion(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
    blocks: int = 4,
) -> Solved:
    """The inverse, made of inverses of `blocks` × `blocks` smaller matrices, times the direct light.

    Gauss–Jordan elimination over blocks: each pivot block is inverted, and the rest takes its Schur complement. Blocks
    are not exchanged, which the dominant diagonal of I − S ρ allows.

    Raises
    ------
    SceneError
        When there are too many elements.
    """

    def by_blocks(matrix: Matrix, right: Matrix) -> _Column:
        inverse = invert_by_blocks(matrix, blocks)
        light = np.einsum("ij,j->i", inverse, right)
        condition = float(np.abs(matrix).sum(axis=0).max() * np.abs(inverse).sum(axis=0).max())
        return _Column(light, backward_error(matrix, light, right), condition)

    return _solve_each("block-inversion", operator, reflectance, direct, tolerance, watch, by_blocks)


def invert_by_blocks(matrix: Matrix, blocks: int) -> Matrix:
    """Inverse of a matrix, divided into `blocks` along each edge."""
    inverse = matrix.copy()
    edges = np.linspace(0, len(matrix), min(blocks, len(matrix)) + 1).astype(int)
    for low, high in pairwise(edges):
        here = slice(low, high)
        rest = np.r_[0:low, high : len(matrix)]
        pivot = np.linalg.inv(inverse[here, here])
        column = inverse[rest, here]
        row = pivot @ inverse[here][:, rest]
        inverse[np.ix_(rest, rest)] -= column @ row
        inverse[here, rest] = row
        inverse[rest, here] = -column @ pivot
        inverse[here, here] = pivot
    return inverse


def backward_error(matrix: Matrix, light: Matrix, right: Matrix) -> float:
    """‖b − A x‖ / (‖A‖ ‖x‖ + ‖b‖) in the maximum norm (Rigal & Gaches 1967)."""
    residual = np.abs(right - np.einsum("ij,j->i", matrix, light)).max(initial=0.0)
    scale = np.abs(matrix).sum(axis=1).max(initial=0.0) * np.abs(light).max(initial=0.0) + np.abs(right).max(
        initial=0.0
    )
    return residual / scale if scale > 0.0 else 0.0


def _largest(values: Matrix) -> float:
    return float(np.abs(values).max(initial=0.0))


def _eliminate(matrix: Matrix, right: Matrix) -> _Column:
    from scipy.linalg import lapack

    factors, pivots, _ = lapack.dgetrf(matrix)
    light = lapack.dgetrs(factors, pivots, right)[0]
    for _ in range(REFINEMENTS):
        light = light + lapack.dgetrs(factors, pivots, right - np.einsum("ij,j->i", matrix, light))[0]
    reciprocal = float(lapack.dgecon(factors, np.abs(matrix).sum(axis=0).max(), norm="1")[0])
    return _Column(light, backward_error(matrix, light, right), 1.0 / reciprocal if reciprocal > 0.0 else np.inf)


def _solve_each(
    solver: str,
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    tolerance: float,
    watch: Watch | None,
    solve: Callable[[Matrix, Matrix], _Column],
) -> Solved:
    """Every column that has light; the others stay as they are."""
    check_dense_size(operator.n_rows, solver)
    system = System(solver, operator, reflectance, direct, tolerance=tolerance, watch=watch)
    links = operator.dense()
    light = system.direct.copy()
    worst, condition = 0.0, 1.0
    for c in np.flatnonzero(system.reflected_once.any(axis=0)):
        matrix = np.eye(operator.n_rows) - links * system.reflectance[:, c].astype(np.float64)
        found = solve(matrix, system.direct[:, c].astype(np.float64))
        light[:, c] = found.light
        worst, condition = max(worst, found.backward_error), max(condition, found.condition)
    system.residual(system.next_light(light) - light, light)
    return system.solved(light, worst, condition)
