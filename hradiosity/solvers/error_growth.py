"""How much larger the error of a solution may be than the residual that an iteration stops at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_ratio
from hradiosity.solvers.measure import Sets
from hradiosity.solvers.operator import ExchangeOperator


class ErrorGrowth(NamedTuple):
    """Errors of reflected light in the norm of all elements, over what is known of them.

    residual : largest relative error of reflected light over the relative residual
    reflection : largest relative error of reflected light over its relative change by one more reflection
    """

    residual: float
    reflection: float


def error_growth(
    operator: ExchangeOperator,
    reflectance: NDArray[np.float32],
    direct: NDArray[np.float32],
    irradiance: NDArray[np.float32],
) -> ErrorGrowth:
    """Growth of errors in the system (I − M) w = b of `hradiosity.solvers.krylov`, in the norm of all elements.

    With M = R½ S R½, whose values lie below 1, ‖e‖ ≤ ‖r‖ / (1 − λ), λ its largest; the Rayleigh quotient of the light
    itself stands for λ, 1 − λ ≈ ⟨w, b⟩ / ⟨w, w⟩, since light that was reflected often lies near the vector of λ. Then
    ‖e‖/‖w‖ over ‖r‖/‖b‖ is ‖b‖ ‖w‖ / ⟨w, b⟩.

    Parameters
    ----------
    operator : ExchangeOperator
    reflectance, direct, irradiance : (n_rows, 8 n_groups) float32
        A system and its solution.
    """
    root = np.sqrt(reflectance)
    area = operator.root_area[:, None]
    rhs = root * operator.apply(root * (area * root * direct))
    solution = area * root * (irradiance - direct)
    sets = Sets(operator.component)
    both = sets.dots(rhs, solution)
    growth = column_ratio(sets.norms(rhs) * sets.norms(solution), both)
    squares = sets.norms(solution) ** 2
    reflection = column_ratio(np.maximum(squares - both, 0.0), both)
    return ErrorGrowth(float(growth.max(initial=1.0)), float(reflection.max(initial=0.0)))
