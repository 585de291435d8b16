"""The radiosity equation with a given exchange, solved densely in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def solve_dense(
    exchange: NDArray[np.float64],
    area: NDArray[np.float64],
    reflectance: NDArray[np.float64],
    direct: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Irradiance E with E_i = D_i + Σ_j F_ij ρ_j E_j, F_ij = K_ij / A_i.

    Parameters
    ----------
    exchange : (n, n) float64
        K [m²]; rows without area must be 0.
    area : (n,) float64 [m²]
    reflectance, direct : (n, n_columns) float64
        Reflectance [1] and direct irradiance; a system of its own for each column.

    Returns
    -------
    (n, n_columns) float64
    """
    factor = np.divide(exchange, area[:, None], out=np.zeros_like(exchange), where=area[:, None] > 0.0)
    system = np.eye(len(area)) - factor[None] * reflectance.T[:, None, :]
    return np.asarray(np.linalg.solve(system, direct.T[..., None])[..., 0].T, np.float64)
