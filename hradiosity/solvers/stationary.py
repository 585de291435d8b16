"""Gathering: Jacobi's and Gauss-Seidel's iteration, all columns at once."""

from __future__ import annotations

from typing import Final

import numpy as np

from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Solved, Watch
from hradiosity.solvers.system import System

MOST_SWEEPS: Final = 5000
ROUNDING: Final = 4.0
"""Changes of so many units in the last place are taken for rounding: the precision is exhausted."""


def jacobi(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
    max_sweeps: int = MOST_SWEEPS,
) -> Solved:
    """X ← d + S ρ x: each sweep adds one reflection. The error falls with ρ̄ a sweep in a closed room."""
    system = System("jacobi", operator, reflectance, direct, tolerance=tolerance, start=start, watch=watch)
    light: Columns = system.direct + system.reflected_once if system.guess is None else system.guess
    while True:
        fresh = system.next_light(light)
        residual = system.residual(fresh - light, light)
        if residual <= tolerance or len(system.history) > max_sweeps or _only_rounding(light, fresh):
            return system.solved(light)
        light = fresh


def gauss_seidel(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
    max_sweeps: int = MOST_SWEEPS,
) -> Solved:
    """Sweeps that use the newest light of every element, in the order of the elements: twice as fast as Jacobi's.

    What a sweep changes is never smaller than the residual that it leaves in a room where light only adds up, and
    costs nothing to know; so sweeps go on until that is below the tolerance, and one product proves the end.
    """
    system = System("gauss-seidel", operator, reflectance, direct, tolerance=tolerance, start=start, watch=watch)
    light: Columns = system.direct + system.reflected_once if system.guess is None else system.guess
    device, lanes = operator.device, 8 if operator.dtype is np.float32 else 4
    on_device = {
        "reflectance": device.upload(system.reflectance, operator.dtype),
        "direct": device.upload(system.direct, operator.dtype),
        "light": device.upload(light, operator.dtype),
        "reflected": device.upload(system.reflectance * light, operator.dtype),
    }
    packs = light.shape[1] // lanes
    sweep = device.kernel("relaxation", "gauss_seidel", **kernel_precision(operator))
    while True:
        sweep(64 * packs, **operator.links, **on_device, n_rows=operator.n_rows, n_packs=packs)
        fresh: Columns = device.fetch(on_device["light"])
        system.shots += 1.0
        residual = system.residual(fresh - light, fresh)
        if residual <= tolerance or len(system.history) > max_sweeps or _only_rounding(light, fresh):
            break
        light = fresh
    system.residual(system.next_light(fresh) - fresh, fresh)
    return system.solved(fresh)


def kernel_precision(operator: ExchangeOperator, **more: int) -> dict[str, int | str]:
    """What the kernels in ``relaxation.cl`` are built with."""
    return {"HR_DOUBLE": int(operator.dtype is np.float64), "HR_OVERSHOOT": 0, **more}


def _only_rounding(light: Columns, fresh: Columns) -> bool:
    return bool((np.abs(fresh - light) <= ROUNDING * np.finfo(light.dtype).eps * np.abs(light)).all())
