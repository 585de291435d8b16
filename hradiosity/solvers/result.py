"""What every solver gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Columns: TypeAlias = NDArray[np.floating[Any]]
"""(n_rows, 8 n_groups) values of all columns, in the precision of the operator."""


@dataclass(frozen=True)
class Stage:
    """One part of the work, when several solvers shared it.

    solver : which one
    products : its products
    residual : that it left
    """

    solver: str
    products: float
    residual: float


@dataclass(frozen=True)
class Convergence:
    """How an iteration went.

    residual : largest relative residual over the columns and sets of connected elements, or a tenth of the elements'
        own ones if that is larger; one a step, the start first
    converged : whether the tolerance was met
    products : products with the operator, those for deflation included; as many shots as there are elements count as
        one, and so does a sweep
    deflated : number of deflation vectors
    solved_columns : right-hand sides that were iterated on
    spectral_defect : largest relative change, over the columns, by one more reflection of light that was combined
        from the solved columns; 0 when all were solved
    solver : which one
    seconds : CPU seconds of the process
    stages : who did what, when there was more than one solver
    backward_error : of direct solvers, largest over the columns of ‖b − A x‖ / (‖A‖ ‖x‖ + ‖b‖) in the maximum norm
    condition : of direct solvers, largest estimate of the condition number over the columns, in the sum norm
    """

    residual: tuple[float, ...]
    converged: bool
    products: float
    deflated: int = 0
    solved_columns: int = 0
    spectral_defect: float = 0.0
    solver: str = "cg"
    seconds: float = 0.0
    stages: tuple[Stage, ...] = ()
    backward_error: float | None = None
    condition: float | None = None


class Solved(NamedTuple):
    """irradiance : (n_rows, 8 n_groups); convergence : how it was found."""

    irradiance: Columns
    convergence: Convergence


@dataclass(frozen=True)
class Progress:
    """Where a solver stands; watching never changes a bit of what it finds.

    solver : which one
    products : so far
    residual : as in `Convergence`
    irradiance : () → (n_rows, 8 n_groups), computed when asked for
    """

    solver: str
    products: float
    residual: float
    irradiance: Callable[[], Columns]


Watch: TypeAlias = Callable[[Progress], None]
