"""Progressive shooting over the stored exchange: Southwell's relaxation, with overshooting if asked for."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Solved, Watch
from hradiosity.solvers.stationary import kernel_precision
from hradiosity.solvers.system import System

SHOTS_A_LOOK: Final = 16
"""The residual is looked at after one in so many elements shot."""
MOST_ROUNDS: Final = 2000
PATIENCE: Final = 20
"""Rounds without a smaller residual after which the precision is taken to be exhausted."""
LARGEST_MEAN: Final = 0.999
"""Mean reflectance beyond which the ambient light is not estimated higher."""


class Shooter:
    """Rows that shoot, the one with the largest weighted unshot power first; the state stays on the device.

    After any number of shots x = d + S y and u = ρ x − y, y being what was shot, so that the residual d + S ρ x − x of
    gathering is S u: shooting and gathering tell the same.

    Parameters
    ----------
    system : System
    weight : (n_columns,)
        By which columns count in the choice of the next row.
    overshoot : bool
        Send in advance what a row will reflect of the ambient light (Feda & Purgathofer 1992).
    """

    def __init__(self, system: System, weight: NDArray[np.floating], *, overshoot: bool) -> None:
        operator, device = system.operator, system.operator.device
        self._system, self._n = system, operator.n_rows
        reflectance, guess = system.reflectance, system.guess
        shot = np.zeros_like(system.direct) if guess is None else reflectance * guess
        light = system.direct if guess is None else system.next_light(guess)
        unshot = reflectance * light - shot
        root = operator.root_area[:, None]
        self._packs = light.shape[1] // (8 if operator.dtype is np.float32 else 4)
        gain, mean_gain = self._ambient(weight) if overshoot else (np.zeros_like(weight), np.zeros(self._n))
        arrays = {
            "reflectance": reflectance,
            "root_area": operator.root_area,
            "weight": weight,
            "gain": gain,
            "mean_gain": mean_gain,
            "light": light,
            "shot": shot,
            "unshot": unshot,
            "power": np.einsum("rc,c->r", root * unshot, weight),
            "total": (root * unshot).sum(axis=0, dtype=np.float64),
        }
        self._on_device: dict[str, DeviceArray] = {k: device.upload(v, operator.dtype) for k, v in arrays.items()}
        self._kernel = device.kernel(
            "relaxation", "shoot_largest", **kernel_precision(operator, HR_OVERSHOOT=int(overshoot))
        )

    def shoot(self, n_shots: int) -> None:
        """Shoot so many times, or until nothing is left."""
        operator = self._system.operator
        self._kernel(1, **operator.links, **self._on_device, n_rows=self._n, n_packs=self._packs, n_shots=n_shots)
        self._system.shots += n_shots / self._n

    @property
    def light(self) -> Columns:
        """X = A½ E."""
        return self._fetch("light")

    @property
    def unshot(self) -> Columns:
        """ρ x − y."""
        return self._fetch("unshot")

    def residual(self) -> float:
        """Size of the residual without a product: |S u| is not larger than |u|."""
        system, unshot = self._system, self.unshot
        root = np.sqrt(system.reflectance)
        return system.residual(np.divide(unshot, root, out=np.zeros_like(unshot), where=root > 0.0), self.light)

    def _fetch(self, name: str) -> Columns:
        fetched: Columns = self._system.operator.device.fetch(self._on_device[name])
        return fetched

    def _ambient(self, weight: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """1 / ((1 − ρ̄) Σ A) of each column, and A_i ρ_i of each row for the choice, ρ_i weighted over the columns."""
        area = self._system.operator.root_area.astype(np.float64) ** 2
        reflectance = self._system.reflectance
        total = float(area.sum())
        mean = np.einsum("r,rc->c", area, reflectance) / total if total > 0.0 else np.zeros(len(weight))
        share = weight / max(float(weight.sum()), float(np.finfo(np.float32).tiny))
        return 1.0 / ((1.0 - np.minimum(mean, LARGEST_MEAN)) * max(total, 1e-300)), area * np.einsum(
            "rc,c->r", reflectance, share
        )


def southwell(
    operator: ExchangeOperator,
    reflectance: Columns,
    direct: Columns,
    *,
    tolerance: float,
    start: Columns | None = None,
    watch: Watch | None = None,
    weight: NDArray[np.floating] | None = None,
    overshoot: bool = False,
    max_rounds: float = MOST_ROUNDS,
) -> Solved:
    """Progressive shooting (Cohen et al. 1988; Southwell's relaxation, Gortler, Cohen & Slusallek 1993).

    Parameters
    ----------
    operator, reflectance, direct, tolerance, start, watch
        See `System`.
    weight : (n_columns,), optional
        By which columns count in the choice of the next row; all alike if left out.
    overshoot : bool
    max_rounds : float
        Shots at most, over the number of rows.
    """
    name = "overshooting" if overshoot else "southwell"
    system = System(name, operator, reflectance, direct, tolerance=tolerance, start=start, watch=watch)
    columns = np.ones(direct.shape[1]) if weight is None else np.asarray(weight, np.float64)
    shooter = Shooter(system, columns, overshoot=overshoot)
    a_look = max(1, operator.n_rows // SHOTS_A_LOOK)
    while shooter.residual() > tolerance and system.shots < max_rounds and not _stalled(system.history):
        shooter.shoot(a_look)
    light = shooter.light
    system.residual(system.next_light(light) - light, light)
    return system.solved(light)


def _stalled(history: list[float]) -> bool:
    return min(history[-PATIENCE * SHOTS_A_LOOK :]) > min(history)
