"""Columns that follow from others: which to solve, and how the rest is combined from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TOLERANCE = 1e-3
"""Part of any column's expected light that the combination may miss."""
LARGEST_SHARE = 0.6
"""A basis of more than this share of all columns is not worth having."""


@dataclass(frozen=True)
class SpectralBasis:
    """Reflected light of all columns as combinations of that of a few.

    solved : (k,) int64, the columns that are solved
    combination : (k, n_columns) float32; all = solved @ combination
    """

    solved: NDArray[np.int64]
    combination: NDArray[np.float32]


def choose_basis(
    emission: NDArray[np.floating],
    reflectance: NDArray[np.floating],
    area: NDArray[np.floating],
    *,
    tolerance: float = TOLERANCE,
) -> SpectralBasis | None:
    """Columns by which the reflected light of all others can be expressed; None where nearly all are needed.

    Light that was reflected n times by materials m₁ … m_n carries the spectrum M(λ) ρ_m₁(λ) … ρ_mn(λ), wherever it
    is; so the first two reflections' products, with the tail as 1/(1 − ρ̄(λ)), span what any element can show. The
    columns are taken greedily, that first which the ones before explain least (Gram–Schmidt with pivoting).

    Parameters
    ----------
    emission : (n_sources, n_columns)
    reflectance : (n_materials, n_columns) [1]
    area : (n_materials,)
        Area of each material [m²]: how much its products count.
    tolerance : float
        Part of any column's expected light that the combination may miss.
    """
    if emission.shape[1] == 0:
        return None
    features = _features(np.asarray(emission, np.float64), np.asarray(reflectance, np.float64), area)
    size = np.sqrt(np.einsum("fc,fc->c", features, features))
    lit = size > 0.0
    rest = np.divide(features, size, out=np.zeros_like(features), where=lit)
    unit = rest.copy()
    most = int(LARGEST_SHARE * features.shape[1])
    solved: list[int] = []
    directions: list[NDArray[np.float64]] = []
    while True:
        missing = np.sqrt(np.einsum("fc,fc->c", rest, rest))
        worst = int(np.argmax(missing))
        if missing[worst] <= tolerance:
            break
        if len(solved) >= most:
            return None
        direction = rest[:, worst] / missing[worst]
        solved.append(worst)
        directions.append(direction)
        rest = rest - direction[:, None] * np.einsum("f,fc->c", direction, rest)[None, :]
    if not solved:
        return None
    pivots = np.array(solved, np.int64)
    coordinates = np.einsum("fk,fc->kc", np.column_stack(directions), unit)
    combination = np.linalg.solve(coordinates[:, pivots], coordinates) * size / size[pivots, None]
    return SpectralBasis(solved=pivots, combination=np.where(lit, combination, 0.0).astype(np.float32))


def _features(
    emission: NDArray[np.float64], reflectance: NDArray[np.float64], area: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(n_features, n_columns) spectra of light reflected once and twice, weighted by the materials' areas."""
    share = area / max(float(area.sum()), np.finfo(float).tiny)
    once = share[:, None] * reflectance
    mean = np.minimum(once.sum(axis=0), 0.99)
    first, second = np.triu_indices(len(reflectance))
    products = np.concatenate([once, once[first] * once[second]]) / (1.0 - mean)
    spectra: NDArray[np.float64] = (emission[:, None, :] * products[None, :, :]).reshape(-1, emission.shape[1])
    return spectra[spectra.any(axis=1)]
