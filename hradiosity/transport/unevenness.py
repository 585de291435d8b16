"""What readings lose by one value for a whole element: where light and its importance both change inside of it.

With one value for each element, the mean over it, a reading is wrong by Σ_i ∫ ρ (E − E_i) (Z − Z_i) over the elements.
E is the irradiance and Z the importance, which obeys the same equation with what readings see in place of the direct
light (dual weighted residuals of Becker & Rannacher 2001, for Galerkin's method and a kernel that smooths). What
changes only one of them costs nothing. The quarters of an element show most of the integral.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.hierarchy import COVERED, SKY, UNLIT
from hradiosity.transport.exchange import Exchange, RowHits

SWEEPS = 24
"""Reflections that the importance is followed through."""


@dataclass(frozen=True)
class Transported:
    """One number for each row, as it leaves its surface.

    leaving : (n_rows,) float64
    sky : float, the same of the sky
    """

    leaving: NDArray[np.float64]
    sky: float = 0.0

    def brought(self, hits: RowHits) -> NDArray[np.float64]:
        """(n, n_samples) what each ray brings; 0 for rays that met nothing."""
        n = len(self.leaving)
        place = np.where(hits.row < UNLIT, hits.row, np.where(hits.row == SKY, n, n + 1)).astype(np.int64)
        return np.concatenate([self.leaving, [self.sky, 0.0]])[place]


def importance_of_rows(
    exchange: Exchange, reflectance: NDArray[np.float64], seen: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n_rows,) importance Z of the exitance of each row, per area.

    Parameters
    ----------
    exchange : Exchange
    reflectance : (n_rows,) float64
    seen : (n_rows,) float64
        What of each row readings see themselves, per area [m⁻²].
    """
    from scipy.sparse import csr_array

    n = len(seen)
    area = exchange.element_area
    links = csr_array((exchange.area, exchange.source.astype(np.int64), exchange.start.astype(np.int64)), (n, n))
    share = np.divide(reflectance, area, out=np.zeros(n), where=area > 0.0)
    arriving = seen
    for _ in range(SWEEPS):
        arriving = seen + np.divide(links @ (share * area * arriving), area, out=np.zeros(n), where=area > 0.0)
    return np.asarray(arriving)


def near_share(hits: RowHits, centre: NDArray[np.float64], reach: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_rows,) share of each row's rays that end on rows whose centres (n_rows, 3) are nearer than its `reach` [m]."""
    far = np.full((1, 3), np.inf, np.float32)
    ends = np.concatenate([centre.astype(np.float32), far])[np.where(hits.row < UNLIT, hits.row, len(centre))]
    square = ((ends - centre.astype(np.float32)[:, None]) ** 2).sum(axis=2)
    share: NDArray[np.float64] = (square < (reach**2)[:, None]).mean(axis=1)
    return share


def uneven_products(
    hits: tuple[RowHits, RowHits],
    direct: tuple[NDArray[np.float64], NDArray[np.float64]],
    light: Transported,
    importance: Transported,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of (E − E_i) (Z − Z_i) over the quarters of elements, twice: of light by the one set of rays and importance
    by the other, and the other way round, so that their noise does not multiply.

    Parameters
    ----------
    hits : two RowHits
        Of the quarters (4 n, n_samples), with different seeds.
    direct : two (4 n,) float64
        Direct light of the quarters.
    light, importance : Transported

    Returns
    -------
    two (n,) float64
    """
    found = [(light.brought(some), importance.brought(some), some.row != COVERED) for some in hits]
    arriving = [_mean(brought, open_) + own for (brought, _, open_), own in zip(found, direct)]
    wanted = [_mean(brought, open_) for _, brought, open_ in found]
    one = _product(arriving[0], wanted[1])
    return one, _product(arriving[1], wanted[0])


def _mean(brought: NDArray[np.float64], open_: NDArray[np.bool_]) -> NDArray[np.float64]:
    mean: NDArray[np.float64] = (brought * open_).sum(axis=1) / np.maximum(open_.sum(axis=1), 1)
    return mean


def _product(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    one, other = one.reshape(-1, 4), other.reshape(-1, 4)
    mean = one.mean(axis=1, keepdims=True)
    return np.asarray(((one - mean) * other).mean(axis=1))


def worst_first(
    error: NDArray[np.float64], noise: NDArray[np.float64], group: NDArray[np.int64], tolerance: float, most: int
) -> tuple[NDArray[np.int64], float]:
    """What to split so that the groups that are left are off by no more than a quarter of the tolerance together.

    Single elements are too noisy to go by: those of a group stand and fall together, groups whose sum may as well be
    noise stay.

    Parameters
    ----------
    error, noise : (n,) float64
        Of each element, and its standard error.
    group : (n,) int64
    tolerance : float
        Sum of the groups' errors up to which nothing is split.
    most : int
        Elements that are split at most; groups that do not fit are left.

    Returns
    -------
    chosen : (m,) int64
        Ascending.
    total : float
        Sum of the groups' errors.
    """
    label = np.unique(group, return_inverse=True)[1].ravel()
    size = np.bincount(label)
    sums = np.abs(np.bincount(label, error))
    sums[sums < 2.0 * np.sqrt(np.bincount(label, noise**2))] = 0.0
    total = float(sums.sum())
    if total <= tolerance:
        return np.zeros(0, np.int64), total
    order = np.argsort(-sums, kind="stable")
    left = total - np.cumsum(sums[order]) + sums[order]
    wanted = order[(left > 0.25 * tolerance) & (sums[order] > 0.0)]
    wanted = wanted[np.cumsum(size[wanted]) <= most]
    return np.flatnonzero(np.isin(label, wanted)), total
