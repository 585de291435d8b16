"""Progressive shooting over the stored exchange: Southwell's relaxation, with overshooting if asked for."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.device.kernel import Kernel
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns, Solved, Watch
from hradiosity.solvers.stationary import kernel_precision
from hradiosity.solvers.system import System

SHOTS_A_LOOK: Final = 16
LATER_LOOKS: Final = 32
"""The residual is looked at after one in so many elements shot, and later after so large a part of all shots so far."""
MOST_ROUNDS: Final = 5000
FRESH_STARTS: Final = 3
"""Times that the unshot light is computed anew from the light, which rounding in many shots has made differ."""
FAIR_TRIAL: Final = 6
STUCK: Final = 0.9
"""Overshooting ends when so many rounds did not bring the residual below this part of what it was."""
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
        self._weight, self._gain = weight, self._ambient_gain() if overshoot else np.zeros(len(weight))
        arrays = {
            "reflectance": reflectance,
            "root_area": operator.root_area,
            "weight": weight,
            "gain": self._gain,
            "light": light,
            "shot": shot,
            "unshot": unshot,
            "total": (root * unshot).sum(axis=0, dtype=np.float64),
        }
        self._on_device: dict[str, DeviceArray] = {k: device.upload(v, operator.dtype) for k, v in arrays.items()}
        self._kernel = self._build(overshoot)

    def shoot(self, n_shots: int) -> None:
        """Shoot so many times, or until nothing is left."""
        system, operator = self._system, self._system.operator
        device, dtype = operator.device, operator.dtype
        self._kernel(
            1,
            **operator.links,
            **self._on_device,
            power=device.upload(self._power(), dtype),
            mean_gain=device.upload(self._expected(), dtype),
            n_rows=self._n,
            n_packs=self._packs,
            n_shots=n_shots,
        )
        system.shots += n_shots / self._n

    def stop_overshooting(self) -> None:
        """Plain shooting from here on."""
        self._gain = np.zeros_like(self._gain)
        self._kernel = self._build(False)

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

    def _build(self, overshoot: bool) -> Kernel:
        operator = self._system.operator
        built = kernel_precision(operator, HR_OVERSHOOT=int(overshoot))
        return operator.device.kernel("relaxation", "shoot_largest", **built)

    def _fetch(self, name: str) -> Columns:
        fetched: Columns = self._system.operator.device.fetch(self._on_device[name])
        return fetched

    def _power(self) -> NDArray[np.float64]:
        """Weighted unshot power of each row; that in advance is told apart by its sign."""
        unshot = self._system.operator.root_area[:, None] * self.unshot
        power: NDArray[np.float64] = np.einsum("rc,c->r", unshot if self._gain.any() else np.abs(unshot), self._weight)
        return power

    def _ambient_gain(self) -> NDArray[np.float64]:
        """1 / ((1 − ρ̄) Σ A) of each column: the ambient light by unshot power."""
        area = self._system.operator.root_area.astype(np.float64) ** 2
        total = max(float(area.sum()), float(np.finfo(np.float64).tiny))
        mean = np.einsum("r,rc->c", area, self._system.reflectance) / total
        gain: NDArray[np.float64] = 1.0 / ((1.0 - np.minimum(mean, LARGEST_MEAN)) * total)
        return gain

    def _expected(self) -> NDArray[np.float64]:
        """Weighted power that each row would send in advance, by the weighted ambient light of all columns."""
        area = self._system.operator.root_area.astype(np.float64) ** 2
        ambient = self._weight * self._gain * np.abs(self._fetch("total"))
        share = ambient / max(float(ambient.sum()), float(np.finfo(np.float64).tiny))
        power: NDArray[np.float64] = area * np.einsum("rc,c->r", self._system.reflectance, share)
        return power


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
    for _ in range(FRESH_STARTS):
        shooter = Shooter(system, columns, overshoot=overshoot)
        light = _shoot_all(shooter, system, max_rounds, overshoot=overshoot)
        done = system.residual(system.next_light(light) - light, light) <= tolerance
        if done or system.shots >= max_rounds:
            break
        system.guess = light
    return system.solved(light)


def _shoot_all(shooter: Shooter, system: System, max_rounds: float, *, overshoot: bool) -> Columns:
    """Shoot until little is left by the shooter's own account."""
    n, first = system.operator.n_rows, len(system.history)
    while shooter.residual() > system.tolerance and system.shots < max_rounds:
        if overshoot and _stuck(system.history[first:]):
            shooter.stop_overshooting()
        shooter.shoot(max(1, n // SHOTS_A_LOOK, int(system.shots * n) // LATER_LOOKS))
    return shooter.light


def _stuck(history: list[float]) -> bool:
    """Whether overshooting brought nothing lately: it need not converge where the ambient light is no good guess."""
    before = history[: -FAIR_TRIAL * SHOTS_A_LOOK]
    return bool(before) and min(history[-FAIR_TRIAL * SHOTS_A_LOOK :]) > STUCK * min(before)
