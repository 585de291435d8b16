"""Progressive shooting: the patches with the most unshot light send it out first, all columns at once.

Cohen, Chen, Wallace & Greenberg 1988; the same iteration as Southwell's relaxation (Gortler, Cohen & Slusallek 1993).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

EQUAL_ENERGY_FLOOR = 1e-3
"""Weight that every band has at least, as a share of the mean luminous weight, so that no band starves."""

RowProvider: TypeAlias = Callable[[NDArray[np.int64]], "csr_array"]
"""Exchange areas A_i F_ij [m²] of some patches i with all patches j: (k,) numbers → (k, n_patches) CSR."""


@dataclass(frozen=True)
class ShootingSystem:
    """Patches that shoot and receive.

    area : (n_patches,) float64 [m²]; patches without area take no part
    reflectance : (n_patches, n_columns) float64
    direct : (n_patches, n_columns) float64, irradiance from elsewhere
    rows : RowProvider
    """

    area: NDArray[np.float64]
    reflectance: NDArray[np.float64]
    direct: NDArray[np.float64]
    rows: RowProvider


@dataclass(frozen=True)
class ShootingState:
    """After a number of shots: unshot = ρ E − shot for every patch, where E = D + Σ K shot / A.

    shots : so far
    irradiance : (n_patches, n_columns) float64, E
    shot, unshot : (n_patches, n_columns) float64, exitance that was sent out, and that still has to be
    residual : largest power of a column still unshot, over what there was of it at the start
    """

    shots: int
    irradiance: NDArray[np.float64]
    shot: NDArray[np.float64]
    unshot: NDArray[np.float64]
    residual: float


def shoot(
    system: ShootingSystem, weight: NDArray[np.float64], *, tolerance: float, batch: int = 1, max_shots: int
) -> Iterator[ShootingState]:
    """Shoot until every column has less than `tolerance` of its power unshot, or `max_shots` are spent.

    Parameters
    ----------
    system : ShootingSystem
    weight : (n_columns,) float64
        By which columns count when the next patch is chosen, see `shooting_weights`.
    tolerance : float
    batch : int
        Patches that shoot at once, those with the largest weighted unshot power; more than one to save launches.
    max_shots : int

    Yields
    ------
    ShootingState
        Before the first shot, and after each batch; its arrays do not change when the run goes on.
    """
    from scipy.sparse import csr_array

    area = np.where(system.area > 0.0, system.area, 0.0)[:, None]
    inverse_area = np.divide(1.0, area, out=np.zeros_like(area), where=area > 0.0)
    irradiance = system.direct.astype(np.float64)
    unshot = system.reflectance * irradiance
    shot = np.zeros_like(unshot)
    start = (area * unshot).sum(axis=0)
    shots = 0
    while True:
        left = np.divide((area * unshot).sum(axis=0), start, out=np.zeros_like(start), where=start > 0.0)
        residual = float(left.max(initial=0.0))
        yield ShootingState(shots, irradiance, shot, unshot, residual)
        if residual <= tolerance or shots >= max_shots:
            return
        power = area[:, 0] * np.einsum("pc,c->p", unshot, weight)
        chosen = _largest(power, min(batch, max_shots - shots))
        arriving = inverse_area * (csr_array(system.rows(chosen).T) @ unshot[chosen])
        irradiance = irradiance + arriving
        shot, unshot = shot.copy(), unshot.copy()
        shot[chosen] += unshot[chosen]
        unshot[chosen] = 0.0
        unshot += system.reflectance * arriving
        shots += len(chosen)


def shooting_weights(expansion: NDArray[np.float64], luminous: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weight of each column in the choice of the next patch: its luminous efficacy and a floor of equal energy.

    Parameters
    ----------
    expansion : (n_columns, n_bands) float64
        What each column means in bands.
    luminous : (n_bands,) float64 [lm W⁻¹]

    Returns
    -------
    (n_columns,) float64
    """
    weight = luminous + EQUAL_ENERGY_FLOOR * luminous.mean()
    columns: NDArray[np.float64] = np.einsum("cb,b->c", expansion, weight)
    return columns


def _largest(power: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Numbers of the largest powers above 0; of equal ones the lowest number."""
    order = np.argsort(-power, kind="stable")[:count]
    return order[power[order] > 0.0].astype(np.int64)
