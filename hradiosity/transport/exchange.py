"""Exchange areas between row elements, sampled by rays: pooled, closed and reciprocal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.space.hierarchy import COVERED, MISS, SKY, UNLIT, Elements
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

if TYPE_CHECKING:
    from scipy.sparse import csr_array

CLOSURE_TOLERANCE, CLOSURE_WORST = 1e-3, 0.05
"""Rms by area, and largest relative defect, at which scaling stops. Rays leave an rms of 0.04 and more in rows; what is
left of it after scaling becomes exchange of a row with itself."""
CLOSURE_STEPS = 60
LARGEST_SCALE = 2.0
"""Factor that no row is scaled beyond: what it then still lacks becomes exchange with itself."""

SURE = 2.0
"""Rays along a line over those without aims, from which on what they find is not scaled."""
MOST_SURE = 0.9
"""Share of a row's exchange that is not scaled, at most; where there is more, the excess is trimmed."""


@dataclass(frozen=True)
class RowHits:
    """What the rays of each row element met.

    row : (n_rows, n_samples) uint32, row element or an outcome (MISS, SKY, COVERED, UNLIT)
    side : (n_rows, n_samples) uint32, 2 · patch + side that was hit; 0xFFFFFFFF for none
    on_device : `row`, still on the device
    density : (n_rows, n_samples, 2) float32, of the row's rays in that direction over the cosine law's, infinite for
        rays that are lost; and of the rays that the row which is met sends back along it. None: 1 (see
        `hradiosity.transport.aims`)
    """

    row: NDArray[np.uint32]
    side: NDArray[np.uint32]
    on_device: DeviceArray
    density: NDArray[np.float32] | None = None

    @property
    def share(self) -> NDArray[np.float64]:
        """(n_rows, n_samples) share of a row's exchange that each ray stands for, with the sum 1 in the mean."""
        n_samples = self.row.shape[1]
        if self.density is None:
            return np.broadcast_to(np.float64(1.0 / n_samples), self.row.shape)
        share: NDArray[np.float64] = 1.0 / (n_samples * self.density[:, :, 0].astype(np.float64))
        return share

    @property
    def lost_share(self) -> float:
        """Share of the rays that ended on sides thought to be dark."""
        return float((self.row == UNLIT).mean()) if self.row.size else 0.0

    def unlit_links(self, elements: Elements) -> NDArray[np.int64]:
        """(n, 2) pairs of sides: one that a ray left, and one that it met though no light was thought to reach it."""
        row, sample = np.nonzero(self.row == UNLIT)
        origin = elements.cell_side[elements.row_cell[elements.row_start[row]]]
        pairs = np.column_stack([origin, self.side[row, sample]]).astype(np.int64)
        return np.unique(pairs, axis=0)


@dataclass(frozen=True)
class Defects:
    """What was wrong with the sampled exchange before reciprocity and closure were enforced.

    row_sum_rms, row_sum_max : of |Σ_j F_ij + F_i,outside − 1|, weighted by area for the rms
    reciprocity_rms : of |A_i F_ij − A_j F_ji| over the pairs that rays from both sides found, relative to their mean
    scale_rms, scale_max : of |d − 1|, d the factors that closed the rows
    self_share : share of all exchange that rows have with themselves because scaling could not close them
    closure_residual : largest |row sum − 1| that scaling left; excess is trimmed, the rest goes to the row itself
    closure_steps : scaling steps taken
    lost_share : share of rays that ended where no light was thought to come
    """

    row_sum_rms: float
    row_sum_max: float
    reciprocity_rms: float
    scale_rms: float
    scale_max: float
    self_share: float
    closure_residual: float
    closure_steps: int
    lost_share: float


@dataclass(frozen=True)
class ClosedRows:
    """What all kinds of exchange tell about each row element; rows are closed: Σ_j K_ij + outside_i = A_i.

    outside : (n_rows,) float64 [m²], exchange area with what lies outside the scene
    sky : (n_rows,) float64 [m²], the part of it above the horizon
    element_area : (n_rows,) float64 [m²], of the exposed part of each element
    defects : before closure
    """

    outside: NDArray[np.float64]
    sky: NDArray[np.float64]
    element_area: NDArray[np.float64]
    defects: Defects


@dataclass(frozen=True)
class Exchange(ClosedRows):
    """Symmetric exchange areas K[i, j] = A_i F_ij = A_j F_ji between single row elements.

    start, source, area : CSR by receiver; (n_rows + 1,) uint32, (n_links,) uint32, (n_links,) float64 [m²]
    """

    start: NDArray[np.uint32]
    source: NDArray[np.uint32]
    area: NDArray[np.float64]


def trace_rows(scene: DeviceScene, elements: DeviceElements, n_samples: int, seed: int) -> RowHits:
    """Send `n_samples` rays from each row element, spread evenly over it, with density cos θ / π."""
    device, n_rows = scene.device, len(elements.elements)
    if n_rows == 0:
        nothing = np.zeros((0, n_samples), np.uint32)
        return RowHits(nothing, nothing, device.upload(nothing))
    row = device.empty((n_rows, n_samples), np.uint32)
    side = device.empty((n_rows, n_samples), np.uint32)
    device.kernel("exchange", "trace_rows")(
        n_rows * n_samples,
        **scene.geometry,
        **elements.cells,
        patch_solid=scene.solid,
        flush_reach=scene.flush_reach,
        hit_row=row,
        hit_side=side,
        first_row=0,
        n_samples=n_samples,
        seed=seed,
        scale=scene.scale,
    )
    return RowHits(device.fetch(row), device.fetch(side), row)


def build_exchange(hits: RowHits, elements: Elements) -> Exchange:
    """Pool the hits of both directions, then scale rows and columns alike until every row closes.

    With N_ij hits among the M rays of row i, the pooled estimate is K_ij = (N_ij + N_ji) / (M/A_i + M/A_j): each
    direction counts by the rays it had per area. Averaging A_i F_ij and A_j F_ji instead would let one hit from a
    large element outweigh all that a small one found itself. Of rays that are aimed each counts by what both rows would
    have sent along it, which is the same where none are.
    """
    from scipy.sparse import csr_array

    n_rows, n_samples = hits.row.shape
    met = hits.row < UNLIT
    target = hits.row[met].astype(np.int32)

    def summed(of_rays: NDArray[np.float64], some: NDArray[np.bool_] | slice = slice(None)) -> csr_array:
        found = csr_array((of_rays[some], target[some].copy(), _starts(sender[some], n_rows)), shape=(n_rows, n_rows))
        found.sum_duplicates()
        return found

    sender = np.repeat(np.arange(n_rows), met.sum(axis=1))
    rays_per_area = np.divide(n_samples, elements.area, out=np.full(n_rows, np.inf), where=elements.area > 0.0)
    fixed = None
    if hits.density is None:
        count = summed(np.ones(len(target)))
        back = csr_array(count.T)
        pooled = csr_array(count + back)
        pooled.sort_indices()
        receiver = np.repeat(np.arange(n_rows), np.diff(pooled.indptr))
        pooled.data /= rays_per_area[receiver] + rays_per_area[pooled.indices]
        reciprocity = _reciprocity_defect(count, back, rays_per_area)
    else:
        own, other = hits.density[met].astype(np.float64).T
        plain, alone = rays_per_area[sender] + rays_per_area[target], own * rays_per_area[sender]
        dense = alone + other * rays_per_area[target]
        sure = dense > SURE * plain
        pooled, fixed = (_both_ways(summed(1.0 / dense, some)) for some in (~sure, sure))
        reciprocity = _aimed_reciprocity_defect(summed(np.ones(len(target)), sure), summed(1.0 / alone, sure))
    element_area, outside, sky = seen_areas(hits, elements)
    return closed_exchange(
        pooled,
        outside,
        sky,
        element_area,
        reciprocity_rms=reciprocity,
        lost_share=hits.lost_share,
        fixed=fixed,
    )


def _starts(sender: NDArray[np.int64], n_rows: int) -> NDArray[np.int32]:
    """(n_rows + 1,) where the entries of each row begin, by the rows (n,), ascending, that entries are of."""
    return np.concatenate([[0], np.cumsum(np.bincount(sender, minlength=n_rows))]).astype(np.int32)


def _both_ways(found: csr_array) -> csr_array:
    """Hits of both directions."""
    from scipy.sparse import csr_array

    pooled = csr_array(found + csr_array(found.T))
    pooled.sort_indices()
    return pooled


def closed_exchange(
    pooled: csr_array,
    outside: NDArray[np.float64],
    sky: NDArray[np.float64],
    element_area: NDArray[np.float64],
    *,
    reciprocity_rms: float,
    lost_share: float,
    fixed: csr_array | None = None,
) -> Exchange:
    """Scale rows and columns alike until every row closes; what that leaves over is trimmed or given to the row itself.

    Scaling takes noise out of the links that made it and would bring it into those that have hardly any: their factors
    d_i d_j are above 1 in the mean, by 3 % in the two rooms.

    Parameters
    ----------
    pooled : (n_rows, n_rows) CSR
        Symmetric exchange areas [m²], sorted indices.
    outside, sky, element_area : (n_rows,) float64 [m²]
        As in `ClosedRows`, before closure.
    reciprocity_rms, lost_share : float
        As in `Defects`.
    fixed : (n_rows, n_rows) CSR, optional
        The same of links that are not scaled.
    """
    from scipy.sparse import csr_array, diags_array

    n_rows = len(element_area)
    receiver = np.repeat(np.arange(n_rows), np.diff(pooled.indptr))
    sure = np.zeros(n_rows) if fixed is None else np.asarray(fixed.sum(axis=1)).ravel()
    before = row_sum_defects(np.asarray(pooled.sum(axis=1)).ravel() + sure, outside, element_area)
    open_area = np.maximum(element_area - sure, (1.0 - MOST_SURE) * element_area)
    scale, steps = close_rows(lambda d: np.asarray(pooled @ d), outside, open_area)
    pooled.data *= scale[receiver] * scale[pooled.indices]
    outside, sky = outside * scale, sky * scale
    if fixed is not None:
        pooled = csr_array(pooled + fixed)
        pooled.sort_indices()
        receiver = np.repeat(np.arange(n_rows), np.diff(pooled.indptr))
    # No row may give more than it has: an excess of 1e-4 is a gain of 10 % at a reflectance of 0.999.
    received = np.asarray(pooled.sum(axis=1)).ravel() + outside
    trim = np.minimum(np.divide(element_area, received, out=np.ones(n_rows), where=received > 0.0), 1.0)
    pooled.data *= np.minimum(trim[receiver], trim[pooled.indices])
    outside, sky = outside * trim, sky * trim
    missing = element_area - np.asarray(pooled.sum(axis=1)).ravel() - outside
    closed = csr_array(pooled + diags_array(np.maximum(missing, 0.0), format="csr"))
    counts = element_area > 0.0
    total = float(element_area.sum())
    defects = Defects(
        **before,
        reciprocity_rms=reciprocity_rms,
        scale_rms=weighted_rms(scale - 1.0, element_area),
        scale_max=float(np.abs(scale - 1.0)[counts].max(initial=0.0)),
        self_share=float(np.maximum(missing, 0.0).sum()) / total if total > 0.0 else 0.0,
        closure_residual=float(np.abs(received[counts] / element_area[counts] - 1.0).max(initial=0.0)),
        closure_steps=steps,
        lost_share=lost_share,
    )
    return Exchange(
        start=closed.indptr.astype(np.uint32),
        source=closed.indices.astype(np.uint32),
        area=closed.data,
        outside=outside,
        sky=sky,
        element_area=element_area,
        defects=defects,
    )


def seen_areas(
    hits: RowHits, elements: Elements
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Exposed area of each row element, and its exchange areas with all outside and with the sky, (n_rows,) [m²]."""
    if hits.density is None:
        per_ray = elements.area / hits.row.shape[1]
        exposed = per_ray * (hits.row != COVERED).sum(axis=1)
        sky = per_ray * (hits.row == SKY).sum(axis=1)
        return exposed, sky + per_ray * (hits.row == MISS).sum(axis=1), sky
    # Rows that have covered parts aim no rays.
    exposed = elements.area * (hits.row != COVERED).mean(axis=1)
    sky, below = (elements.area * (hits.share * (hits.row == outcome)).sum(axis=1) for outcome in (SKY, MISS))
    return exposed, sky + below, sky


def close_rows(
    received: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    outside: NDArray[np.float64],
    area: NDArray[np.float64],
) -> tuple[NDArray[np.float64], int]:
    """Factors d ≤ 2 with d_i (Σ_j K_ij d_j + s_i) = A_i, by the damped symmetric scaling d ← √(d A / (K d + s)).

    `received` gives K d. Returns the factors, and the steps taken.

    The outside keeps the factor 1. Knight & Ruiz 2013 discuss the scaling of symmetric matrices; it has no solution
    where a few elements see only each other and their areas differ, hence the bound.
    """
    scale = np.ones(len(area))
    for step in range(CLOSURE_STEPS):
        total = received(scale) + outside
        usable = (area > 0.0) & (total > 0.0)
        free = usable & ((scale < LARGEST_SCALE) | (scale * total > area))
        defect = scale[free] * total[free] / area[free] - 1.0
        if weighted_rms(defect, area[free]) < CLOSURE_TOLERANCE and np.abs(defect).max(initial=0.0) < CLOSURE_WORST:
            return scale, step
        scale[usable] = np.minimum(np.sqrt(scale[usable] * area[usable] / total[usable]), LARGEST_SCALE)
    return scale, CLOSURE_STEPS


def row_sum_defects(
    received: NDArray[np.float64], outside: NDArray[np.float64], area: NDArray[np.float64]
) -> dict[str, float]:
    """`Defects.row_sum_rms` and `Defects.row_sum_max` of rows with sums `received` [m²]."""
    counts = area > 0.0
    defect = (received + outside)[counts] / area[counts] - 1.0
    return {
        "row_sum_rms": weighted_rms(defect, area[counts]),
        "row_sum_max": float(np.abs(defect).max(initial=0.0)),
    }


def _reciprocity_defect(found: csr_array, back: csr_array, rays_per_area: NDArray[np.float64]) -> float:
    """Rms relative difference of the two directions' estimates, over pairs with five hits or more each way."""
    from scipy.sparse import csr_array

    often, often_back = found.copy(), back.copy()
    often.data *= often.data > 4
    often_back.data *= often_back.data > 4
    both = csr_array(often.multiply(often_back > 0)).tocoo()
    other = csr_array(often_back.multiply(often > 0)).tocoo()
    keep = both.data > 0
    if not keep.any():
        return 0.0
    there = both.data[keep] / rays_per_area[both.row[keep]]
    here = other.data[other.data > 0] / rays_per_area[both.col[keep]]
    return float(np.sqrt(np.mean((2.0 * (there - here) / (there + here)) ** 2)))


def _aimed_reciprocity_defect(count: csr_array, form_factor_area: csr_array) -> float:
    """The same of lines that rows aim at, from numbers of hits and exchange areas by the rays of the one side alone."""
    often = count.copy()
    often.data = (often.data > 4).astype(np.float64)
    both = often.multiply(often.T)
    there = np.asarray(form_factor_area.multiply(both).tocoo().data)
    here = np.asarray(form_factor_area.T.multiply(both).tocsr().tocoo().data)
    if not len(there) or len(there) != len(here):
        return 0.0
    return float(np.sqrt(np.mean((2.0 * (there - here) / (there + here)) ** 2)))


def weighted_rms(values: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """Root of the weighted mean of squares; 0 without any weight."""
    total = float(weight.sum())
    return float(np.sqrt((weight * values**2).sum() / total)) if total > 0.0 else 0.0
