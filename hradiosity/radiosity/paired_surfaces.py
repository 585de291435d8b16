"""Light on the surfaces with exchange by form factors of all pairs of cells, or by hemicubes, in place of row rays."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from hradiosity.plan import Calibration, ClassicCalibration, Plan
from hradiosity.planning_classic import VISIBLE_SHARE, pixels_drawn
from hradiosity.planning_seconds import hemicube_seconds, pair_seconds
from hradiosity.radiosity.shooting import LEAST_PIXELS, ShootingPoints, shooting_points
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.space.hierarchy import Elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.shafts import FARTHEST
from hradiosity.transport.cell_pairs import (
    RANDOM,
    RAYS_OF_A_PAIR,
    CellPairs,
    RowPairs,
    check_pairs,
    most_pairs,
    pair_bytes,
    symmetric,
)
from hradiosity.transport.exchange import ClosedRows, RowHits, closed_exchange, seen_areas
from hradiosity.transport.form_factor.hemicube import Hemicube
from hradiosity.transport.outside import outside_areas
from hradiosity.transport.pair_sight import open_share

COMPARED_PAIRS = 100_000
"""Pairs of elements whose two directions are compared."""


class PairedSurfaces(SurfaceSolver):
    """Exchange from the form factors of all pairs of cells, times what rays between them find open.

    The form factors are computed once for a mesh unless the method is random; what is open, and what solids cover, is
    sampled afresh for each seed.
    """

    def _cut(self, lit: LitSides) -> None:
        self._lit = lit
        self._cells: CellPairs | None = None
        self._proved: NDArray[np.bool_] | None = None
        self._pairs: RowPairs | None = None
        self._account: dict[str, Any] = {}
        super()._cut(lit)

    def account(self) -> dict[str, Any]:
        """What is known of the form factors, for ``run.json``; means are weighted with the exchange."""
        return {"method": self.options.form_factors, **self._account}

    def sized_plan(self, calibration: Calibration | ClassicCalibration | None) -> Plan:
        """The plan for the elements that were cut, with seconds if the device was measured in this mode.

        Raises
        ------
        SceneError
            When there are too many pairs.
        """
        method = self.options.form_factors
        n_pairs = self._cell_pairs().count()
        check_pairs(n_pairs, len(self.elements), method)
        known = calibration if isinstance(calibration, Calibration) else None
        plan = _with_pairs(super().sized_plan(known), method, n_pairs)
        if known is None or plan.seconds is None:
            return plan
        times = plan.replicates if method in RANDOM else 1
        return replace(plan, seconds=plan.seconds + pair_seconds(plan, known, times * RAYS_OF_A_PAIR[method]))

    def _exchange(self, hits: RowHits, seed: int) -> ClosedRows:
        """Exchange of one replicate; origins, covered parts and the outside come from the rays in `hits`."""
        pairs = self._row_pairs(seed)
        with self.record.timed("visibility"):
            share, share_error, rays = open_share(self.on_device, self.on_device_elements, hits, pairs, seed)
        self.record.rays += rays
        exchange = share * pairs.exchange
        self._tell(pairs, exchange, share_error, rays)
        area, _, _ = seen_areas(hits, self.elements)
        n_rows = len(self.elements)
        pooled = symmetric(pairs, exchange, n_rows)
        # Errors of a method have one sign, those of visibility have any.
        errors = (
            symmetric(pairs, share * pairs.error, n_rows).sum(axis=1),
            np.sqrt(symmetric(pairs, (share_error * pairs.exchange) ** 2, n_rows).sum(axis=1)),
        )
        received = np.asarray(pooled.sum(axis=1)).ravel()
        error = np.asarray(errors[0]).ravel() + np.asarray(errors[1]).ravel()
        outside, sky = outside_areas(hits, self.elements, received, error, self.space, self._lit.open)
        return closed_exchange(pooled, outside, sky, area, reciprocity_rms=0.0, lost_share=hits.lost_share)

    def _row_pairs(self, seed: int) -> RowPairs:
        """Exchange when nothing stands between; kept as long as it stays the same."""
        cells = self._cell_pairs()
        if self._proved is None:
            with self.record.timed("pairs"):
                self._proved = np.zeros(len(cells), bool)
                if self.plan.occlusion and self.on_device.shafts:
                    self._proved = cells.prove(FARTHEST * self._lit.free_path)
        if self._pairs is None or self.options.form_factors in RANDOM:
            with self.record.timed("form factors"):
                self._pairs = cells.by_rows(self.options.form_factors, seed, self._proved)
        return self._pairs

    def _cell_pairs(self) -> CellPairs:
        """Of the mesh; made on first use."""
        if self._cells is None:
            self._cells = CellPairs(self._bvh, self.scene.patches, self.elements, self.space)
        return self._cells

    def _tell(
        self, pairs: RowPairs, exchange: NDArray[np.float64], share_error: NDArray[np.float64], rays: int
    ) -> None:
        """Keep what `account` tells, of the last replicate."""
        whole = max(float(pairs.exchange.sum()), np.finfo(float).tiny)
        self._account = {
            "cell_pairs": pairs.n_cell_pairs,
            "element_pairs": len(pairs.first),
            "proved_share": float(pairs.proved.mean()) if len(pairs.proved) else 1.0,
            "mean_error": float(pairs.error.sum()) / whole,
            "open_share": float(exchange.sum()) / whole,
            "mean_visibility_error": float((share_error * pairs.exchange).sum()) / whole,
            "visibility_rays_per_replicate": rays,
        }


class HemicubeSurfaces(SurfaceSolver):
    """Exchange from a hemicube over a random point of each row element, drawn and turned afresh for each seed."""

    def _cut(self, lit: LitSides) -> None:
        super()._cut(lit)
        self._hemicube: Hemicube | None = None

    def account(self) -> dict[str, Any]:
        """What is known of the form factors, for ``run.json``."""
        drawn = {} if self._hemicube is None else {"hemicubes": self._hemicube.drawn}
        return {"method": "hemicube", "resolution": self.options.hemicube_resolution, **drawn}

    def sized_plan(self, calibration: Calibration | ClassicCalibration | None) -> Plan:
        """The plan for the elements that were cut, with seconds if the device was measured in the mode of rays.

        Raises
        ------
        SceneError
            When there are too many pairs.
        """
        n_rows = len(self.elements)
        n_pairs = n_rows * (n_rows - 1) // 2
        check_pairs(n_pairs, n_rows, "hemicube")
        known = calibration if isinstance(calibration, Calibration) else None
        plan = _with_pairs(super().sized_plan(known), "hemicube", n_pairs)
        if known is None or plan.seconds is None:
            return plan
        pixels = n_rows * pixels_drawn(self.options.hemicube_resolution, plan.n_patches)
        more = hemicube_seconds(plan, known, pixels, VISIBLE_SHARE * n_rows**2)
        return replace(plan, seconds=plan.seconds + more)

    def _exchange(self, hits: RowHits, seed: int) -> ClosedRows:
        """Exchange of one replicate; only what is covered comes from the rays in `hits`."""
        if self._hemicube is None:
            resolution = self.options.hemicube_resolution
            self._hemicube = Hemicube(self.on_device, self.scene.patches, self.elements, resolution)
        points = self._points(np.random.Generator(np.random.Philox(key=seed)))
        with self.record.timed("hemicubes"):
            views = self._hemicube.views(points.position, points.normal, points.angle, points.patch)
        area, _, _ = seen_areas(hits, self.elements)
        factor = csr_array(diags_array(points.exposed.astype(np.float64)) @ views.factor)
        pooled = pooled_factors(factor, area)
        sky = area * views.sky * points.exposed
        outside = sky + area * views.miss * points.exposed
        return closed_exchange(
            pooled,
            outside,
            sky,
            area,
            reciprocity_rms=_reciprocity_defect(factor, area, self.options.hemicube_resolution),
            lost_share=float(views.unlit.mean()) if len(views.unlit) else 0.0,
        )

    def _points(self, rng: np.random.Generator) -> ShootingPoints:
        """A random point of each row element, in one of its cells by their areas."""
        cells = random_cells(self.elements, rng)
        return shooting_points(self._bvh, self.scene.patches, self.elements, cells, rng)


def _with_pairs(plan: Plan, method: str, n_pairs: int) -> Plan:
    """The plan with so many pairs and the memory that they take."""
    memory = plan.memory_bytes + pair_bytes(n_pairs)
    return replace(plan, form_factors=method, pairs=n_pairs, most_pairs=most_pairs(), memory_bytes=memory)


def random_cells(elements: Elements, rng: np.random.Generator) -> NDArray[np.int64]:
    """(n_rows,) a cell of each row element, drawn by area."""
    start = elements.row_start.astype(np.int64)
    rows = np.arange(len(elements))
    ends = np.repeat(rows, np.diff(start)) + elements.row_share.astype(np.float64)
    place = np.searchsorted(ends, rows + rng.random(len(elements)))
    within = np.clip(place, start[:-1], start[1:] - 1)
    return elements.row_cell[within].astype(np.int64)


def pooled_factors(factor: csr_array, area: NDArray[np.float64]) -> csr_array:
    """Symmetric exchange areas [m²] of form factors (n, n) that are equally good from both ends.

    K_ij = (F_ij + F_ji) / (1/A_i + 1/A_j), as if each row were rays: a large element's view of a small one, from one
    of its points, says less than the other way round.
    """
    both = csr_array(factor + factor.T)
    both.sort_indices()
    inverse = np.divide(1.0, area, out=np.full(len(area), np.inf), where=area > 0.0)
    receiver = np.repeat(np.arange(len(area)), np.diff(both.indptr))
    both.data = both.data / (inverse[receiver] + inverse[both.indices])
    both.eliminate_zeros()
    return both


def _reciprocity_defect(factor: csr_array, area: NDArray[np.float64], resolution: int) -> float:
    """Rms of |A_i F_ij − A_j F_ji| over the mean of both, for pairs that both show in more than about five pixels."""
    often = csr_array(factor > LEAST_PIXELS / (3.0 * resolution**2))
    both = csr_array(often.multiply(often.T)).tocoo()
    row, column = both.coords
    chosen = np.flatnonzero(row < column)
    chosen = chosen[:: max(1, len(chosen) // COMPARED_PAIRS)]
    if not len(chosen):
        return 0.0
    i, j = row[chosen], column[chosen]
    there, here = area[i] * np.asarray(factor[i, j]).ravel(), area[j] * np.asarray(factor[j, i]).ravel()
    mean = 0.5 * (there + here)
    counts = mean > 0.0
    return float(np.sqrt(np.mean(((there - here)[counts] / mean[counts]) ** 2))) if counts.any() else 0.0
