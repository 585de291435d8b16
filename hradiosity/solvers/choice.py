"""All solvers behind one call."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hradiosity.options import SolverName
from hradiosity.solvers.dense import block_inversion, gaussian_elimination
from hradiosity.solvers.krylov import solve_irradiance
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Progress, Solved, Stage, Watch
from hradiosity.solvers.stationary import gauss_seidel, jacobi
from hradiosity.solvers.stored_shooting import southwell

FIRST_ROUNDS: Final = 1.0 / 16.0
"""Of `auto`: shots before the conjugate gradients take over, over the number of elements. The brightest ones show the
light; a whole round takes as long as the conjugate gradients need to the end."""
FEW_ROUNDS: Final = 0.5
"""Rooms that shooting is expected to finish in so many rounds are left to it, for twice as many."""

Solver: TypeAlias = Callable[..., Solved]


@dataclass(frozen=True)
class SolverChoice:
    """A solver and what it needs beside the system.

    name : which one
    weight : (n_columns,) by which columns count in the choice of who shoots next; None for all alike
    blocks : along each edge of the matrix, for block-inversion
    """

    name: SolverName = "cg"
    weight: NDArray[np.floating] | None = None
    blocks: int = 4


def solve_system(
    choice: SolverChoice,
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    deflation: NDArray[np.float64] | None = None,
    watch: Watch | None = None,
) -> Solved:
    """Irradiance of every element, E = D + F ρ E, by the solver of one's choice.

    Parameters
    ----------
    choice : SolverChoice
    operator, reflectance, direct, tolerance, start, deflation
        See `hradiosity.solvers.krylov.solve_irradiance`. Only the conjugate gradients use the deflation, and the
        direct solvers no start.
    watch : Watch, optional
        Called after each step; the numbers are the same whether someone watches or not.

    Raises
    ------
    SceneError
        When a direct solver would need too much memory.
    """
    shoot = partial(southwell, weight=choice.weight)
    conjugate = partial(solve_irradiance, deflation=deflation)
    solvers: dict[SolverName, Solver] = {
        "cg": conjugate,
        "southwell": shoot,
        "overshooting": partial(shoot, overshoot=True),
        "jacobi": jacobi,
        "gauss-seidel": gauss_seidel,
        "gaussian-elimination": gaussian_elimination,
        "block-inversion": partial(block_inversion, blocks=choice.blocks),
        "auto": partial(_shoot_then_finish, shoot, conjugate),
    }
    return solvers[choice.name](operator, reflectance, direct, tolerance=tolerance, start=start, watch=watch)


def rounds_expected(reflectance: float, tolerance: float) -> float:
    """Rounds of shots, as many as elements each, until shooting is done in a closed room of that mean reflectance."""
    if reflectance <= 0.0:
        return 0.0
    return float(np.log(tolerance) / (2.0 * np.log(min(reflectance, 0.999))))


def _shoot_then_finish(
    shoot: Solver,
    conjugate: Solver,
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
) -> Solved:
    """A few shots, which show the light soonest; then conjugate gradients from there, unless little is left."""
    cpu = time.process_time()
    area = operator.root_area.astype(np.float64) ** 2
    mean = np.einsum("r,rc->c", area, reflectance) / max(float(area.sum()), float(np.finfo(np.float64).tiny))
    swift = rounds_expected(float(mean.max(initial=0.0)), tolerance) <= FEW_ROUNDS
    rounds = 2.0 * FEW_ROUNDS if swift else FIRST_ROUNDS
    first = shoot(operator, reflectance, direct, tolerance=tolerance, start=start, watch=watch, max_rounds=rounds)
    done = Stage("southwell", first.convergence.products, first.convergence.residual[-1])
    if first.convergence.converged:
        return Solved(first.irradiance, replace(first.convergence, solver="auto", stages=(done,)))

    def relay(progress: Progress) -> None:
        if watch is not None:
            watch(replace(progress, products=progress.products + done.products))

    guess = first.irradiance - direct
    last = conjugate(operator, reflectance, direct, tolerance=tolerance, start=guess, watch=relay)
    convergence = replace(
        last.convergence,
        residual=(*first.convergence.residual, *last.convergence.residual),
        products=done.products + last.convergence.products,
        solver="auto",
        seconds=time.process_time() - cpu,
        stages=(done, Stage("cg", last.convergence.products, last.convergence.residual[-1])),
    )
    return Solved(last.irradiance, convergence)
