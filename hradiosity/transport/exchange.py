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


@dataclass(frozen=True)
class RowHits:
    """What the rays of each row element met.

    row : (n_rows, n_samples) uint32, row element or an outcome (MISS, SKY, COVERED, UNLIT)
    side : (n_rows, n_samples) uint32, 2 · patch + side that was hit; 0xFFFFFFFF for none
    on_device : `row`, still on the device
    """

    row: NDArray[np.uint32]
    side: NDArray[np.uint32]
    on_device: DeviceArray

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
    large element outweigh all that a small one found itself.
    """
    from scipy.sparse import csr_array

    n_rows, n_samples = hits.row.shape
    found = csr_array(
        (
            np.ones(int((hits.row < UNLIT).sum())),
            hits.row[hits.row < UNLIT].astype(np.int32),
            np.concatenate([[0], np.cumsum((hits.row < UNLIT).sum(axis=1))]).astype(np.int32),
        ),
        shape=(n_rows, n_rows),
    )
    found.sum_duplicates()
    back = csr_array(found.T)
    rays_per_area = np.divide(n_samples, elements.area, out=np.full(n_rows, np.inf), where=elements.area > 0.0)
    pooled = csr_array(found + back)
    pooled.sort_indices()
    receiver = np.repeat(np.arange(n_rows), np.diff(pooled.indptr))
    pooled.data /= rays_per_area[receiver] + rays_per_area[pooled.indices]
    element_area, outside, sky = seen_areas(hits, elements)
    return closed_exchange(
        pooled,
        outside,
        sky,
        element_area,
        reciprocity_rms=_reciprocity_defect(found, back, rays_per_area),
        lost_share=hits.lost_share,
    )


def closed_exchange(
    pooled: csr_array,
    outside: NDArray[np.float64],
    sky: NDArray[np.float64],
    element_area: NDArray[np.float64],
    *,
    reciprocity_rms: float,
    lost_share: float,
) -> Exchange:
    """Scale rows and columns alike until every row closes; what that leaves over is trimmed or given to the row itself.

    Parameters
    ----------
    pooled : (n_rows, n_rows) CSR
        Symmetric exchange areas [m²], sorted indices.
    outside, sky, element_area : (n_rows,) float64 [m²]
        As in `ClosedRows`, before closure.
    reciprocity_rms, lost_share : float
        As in `Defects`.
    """
    from scipy.sparse import csr_array, diags_array

    n_rows = len(element_area)
    receiver = np.repeat(np.arange(n_rows), np.diff(pooled.indptr))
    before = row_sum_defects(np.asarray(pooled.sum(axis=1)).ravel(), outside, element_area)
    scale, steps = close_rows(lambda d: np.asarray(pooled @ d), outside, element_area)
    pooled.data *= scale[receiver] * scale[pooled.indices]
    outside, sky = outside * scale, sky * scale
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
    per_ray = elements.area / hits.row.shape[1]
    exposed = per_ray * (hits.row != COVERED).sum(axis=1)
    sky = per_ray * (hits.row == SKY).sum(axis=1)
    return exposed, sky + per_ray * (hits.row == MISS).sum(axis=1), sky


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


def weighted_rms(values: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """Root of the weighted mean of squares; 0 without any weight."""
    total = float(weight.sum())
    return float(np.sqrt((weight * values**2).sum() / total)) if total > 0.0 else 0.0
