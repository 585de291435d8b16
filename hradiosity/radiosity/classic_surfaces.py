"""Light on the surfaces by the classic method: hemicubes, shooting, subdivision where the light changes.

Lamps are patches that shoot their exitance first; what they send is kept for the finest cells, so that splitting an
element costs no further hemicube. Then patches shoot what they reflect (Cohen, Chen, Wallace & Greenberg 1988).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import NONE
from hradiosity.plan import Calibration, ClassicCalibration, Plan
from hradiosity.planning_classic import ClassicSizes, classic_plan
from hradiosity.radiosity.classic_companion import ClassicCompanion, means
from hradiosity.radiosity.classic_lamps import cut_lamps, side_exitance
from hradiosity.radiosity.classic_light import ClassicLight
from hradiosity.radiosity.iteration import SINGLE_PRECISION
from hradiosity.radiosity.shooting import KEPT_BYTES, ShootingPoints, ShootingRows, over_area, shooting_points
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.solvers.result import Convergence, Progress
from hradiosity.solvers.southwell import ShootingState, ShootingSystem, shoot, shooting_weights
from hradiosity.space.companion import coarser_rows
from hradiosity.space.hierarchy import COVERED, Elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.substructure import SPLITS, Substructure, cut_substructure
from hradiosity.transport.device_scene import DeviceScene, upload_scene
from hradiosity.transport.direct import direct_at_points, direct_on_rows
from hradiosity.transport.exchange import Defects, RowHits
from hradiosity.transport.form_factor.hemicube import Hemicube

CONTRAST: Final = 0.2
"""Difference of illuminance between the parts of an element, over the mean of its own and the scene's, above which
it is split."""
SHOTS_A_PATCH: Final = 400
"""Bound on the shots, on average; reflectances up to 0.98 need fewer."""
SHOT_SHARE: Final = 16
LEAST_BATCH: Final = 16
"""One in `SHOT_SHARE` patches shoots at a time, and at least `LEAST_BATCH`, which saves launches."""


class ClassicSurfaces(SurfaceSolver):
    """Estimates the light on all row elements with new random points and turns of the hemicubes for each seed."""

    uses_shafts = False

    def solve(self, seed: int) -> ClassicLight:
        """One independent estimate."""
        with self.record.timed("exposure"):
            hits = self._trace(seed)
            exposed = 1.0 - (hits.row == COVERED).mean(axis=1)
        rng = np.random.Generator(np.random.Philox(key=seed))
        area = self.elements.area * exposed
        with self.record.timed("lamps"):
            direct = self._from_lamps(self.hemicube, self.elements.cell_row, area, exposed, rng)
            direct += self._point_light(hits, seed)
        n_patches = len(self._structure.levels[0])
        patch_area = np.bincount(self._row_patch, weights=area, minlength=n_patches).astype(np.float64)
        points = self._points(0, np.arange(n_patches), rng)
        rows = ShootingRows(self.hemicube, points, patch_area * points.exposed, self._row_patch)
        if self.scene.sky is not None:
            with self.record.timed("sky"):
                rows(np.arange(n_patches))
                direct += rows.sky[self._row_patch][:, None] * self.light.sky[: self.plan.columns.n_columns]
        with self.record.timed("shooting"):
            system = self._system(rows, area, direct)
            shot = self._shoot(system, direct)
        with self.record.timed("companion"):
            sent = np.concatenate([shot, self._coarse_shot(system, rows)], axis=1)
        with self.record.timed("shooting"):
            fine, coarse = np.split(over_area(rows.arriving(sent), area), 2, axis=1)
            irradiance = direct + fine
        self._note(irradiance, direct, exposed, rows)
        reflectance = self.light.reflectance[self.elements.row_material, : self.plan.columns.n_columns]
        return ClassicLight(
            hemicube=self.hemicube,
            reflected=reflectance * irradiance,
            emitted=self._emitted(),
            seed=seed,
            change=reflectance * self._companion.change(irradiance, direct + coarse, area),
        )

    def shared_errors(self) -> dict[str, float]:
        """Light that is not shot yet is missing everywhere, in about the same share."""
        return {
            "precision": SINGLE_PRECISION,
            "iteration": max((c.residual[-1] for c in self.record.convergence), default=0.0),
        }

    def count_hemicubes(self, hemicube: Hemicube) -> None:
        """Take what was drawn since the last call over into the record."""
        self.record.hemicubes += hemicube.drawn
        self.record.hemicube_seconds += hemicube.seconds
        hemicube.drawn, hemicube.seconds = 0, 0.0

    def sized_plan(self, calibration: Calibration | ClassicCalibration | None) -> Plan:
        """The plan for the patches that were cut, with seconds if the device was measured in this mode."""
        patches = self._structure.levels[0]
        reflectance = self.light.reflectance[patches.row_material, : self.plan.columns.n_columns].astype(np.float64)
        total = float(patches.area.sum())
        mean = np.einsum("p,pc->c", patches.area, reflectance) / total if total > 0.0 else np.zeros(1)
        sizes = ClassicSizes(
            shooters=len(patches),
            lamp_points=len(self._area_lamps.cell),
            elements=len(self.elements),
            resolution=self.options.hemicube_resolution,
            tolerance=self.options.tolerance,
            reflectance=float(mean.max(initial=0.0)),
            kept_bytes=KEPT_BYTES,
            batch=self.hemicube.batch,
        )
        return classic_plan(self.plan, sizes, calibration if isinstance(calibration, ClassicCalibration) else None)

    def _divide(self, lit: LitSides) -> Elements:
        """Patches, split where the light of the lamps changes quickly; draws a first round of their hemicubes."""
        patches, size = self.scene.patches, self.plan.element_size
        two_sided = np.array([m.two_sided for m in self.scene.materials], bool)
        self._structure: Substructure = cut_substructure(patches, lit.space, two_sided, size, lit.slots)
        self._side_exitance = side_exitance(self.scene, self.light.emission[:, : self.plan.columns.n_columns])
        self._area_lamps = cut_lamps(self._structure, self._side_exitance)
        self._points_alone = self._without_area_lamps()
        elements, self._row_patch = self._structure.rows(patches, self._splits())
        self._companion = self._coarser_patches(elements, lit)
        self.hemicube = Hemicube(self.on_device, patches, elements, self.options.hemicube_resolution)
        return elements

    def _coarser_patches(self, elements: Elements, lit: LitSides) -> ClassicCompanion:
        """The patches and elements of twice the size."""

        def parents(fine: Elements) -> NDArray[np.int64]:
            if not len(fine):
                return np.zeros(0, np.int64)
            space = lit.space.ravel()[fine.cell_side[fine.row_cell[fine.row_start[:-1]]]]
            return coarser_rows(self.scene.patches, fine, space, self.light.glow.paint, self.plan.element_size)

        return ClassicCompanion(parents(self._structure.levels[0]), parents(elements))

    def _splits(self) -> list[NDArray[np.bool_]]:
        """Which cells of each level but the last to split."""
        structure = self._structure
        finest = structure.finest
        hemicube = Hemicube(self.on_device, self.scene.patches, finest, self.options.hemicube_resolution)
        rng = np.random.Generator(np.random.Philox(key=self.options.seed))
        everything = np.ones(len(finest))
        light = self._from_lamps(hemicube, np.arange(len(finest)), finest.area, everything, rng)
        if self._points_alone is not None:
            places = self._points(SPLITS, np.arange(len(finest)), rng)
            light += self._from_points(direct_at_points(self._points_alone, places.position, places.normal, 1, 0))
        lux = np.einsum("rc,c->r", light, self._luminous_columns())
        total = float(finest.area.sum())
        mean = float((lux * finest.area).sum()) / total if total > 0.0 else 0.0
        return [
            structure.spread(lux, level) > CONTRAST * 0.5 * (structure.means(lux, level) + mean)
            for level in range(SPLITS)
        ]

    def _luminous_columns(self) -> NDArray[np.float64]:
        """(n_columns,) lumens in a unit of each column."""
        luminous: NDArray[np.float64] = np.einsum(
            "cb,b->c", self.plan.columns.expansion, luminous_weights(self.scene.bands)
        )
        return luminous

    def _emitted(self) -> NDArray[np.float64]:
        """(n_rows, n_columns) exitance of the lamps; all cells of a row lie on one side."""
        first = self.elements.row_cell[self.elements.row_start[:-1]]
        return self._side_exitance[self.elements.cell_side[first]]

    def _without_area_lamps(self) -> DeviceScene | None:
        """The scene with its point sources alone, which hemicubes do not show; None without any."""
        lamps = self.scene.emitters
        alone = lamps.patch == NONE
        if not alone.any():
            return None
        kept = replace(
            lamps, patch=lamps.patch[alone], position=lamps.position[alone], luminaire=lamps.luminaire[alone]
        )
        scene = replace(self.scene, emitters=kept)
        return upload_scene(self.device, scene, self._bvh, occlusion=self.plan.occlusion)

    def _points(self, level: int, cells: NDArray[np.int64], rng: np.random.Generator) -> ShootingPoints:
        return shooting_points(self._bvh, self.scene.patches, self._structure.levels[level], cells, rng)

    def _from_lamps(
        self,
        hemicube: Hemicube,
        item_of_finest: NDArray[np.integer],
        area: NDArray[np.float64],
        exposed: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        """(n_items, n_columns) irradiance of items with an exposed `area` by all area lamps."""
        lamps = self._area_lamps
        points = shooting_points(self._bvh, self.scene.patches, lamps.grid, lamps.cell, rng)
        return lamps.light(hemicube, points, exposed[item_of_finest[lamps.finest]], area)

    def _point_light(self, hits: RowHits, seed: int) -> NDArray[np.float64]:
        """(n_rows, n_columns) irradiance by point sources."""
        if self._points_alone is None:
            return np.zeros((len(self.elements), self.plan.columns.n_columns))
        per_source = direct_on_rows(self._points_alone, self.on_device_elements, hits, self.plan.light_points, seed)
        self.record.rays += per_source.size * self.plan.light_points
        return self._from_points(per_source)

    def _from_points(self, factor: NDArray[np.float32]) -> NDArray[np.float64]:
        """(n, n_columns) irradiance from (n, n_point_sources) factors."""
        emission = self.light.emission[self.scene.emitters.patch == NONE, : self.plan.columns.n_columns]
        light: NDArray[np.float64] = np.einsum("re,ec->rc", factor.astype(np.float64), emission.astype(np.float64))
        return light

    def _system(self, rows: ShootingRows, area: NDArray[np.float64], direct: NDArray[np.float64]) -> ShootingSystem:
        """The patches, with the direct light of their elements."""
        patches = self._structure.levels[0]
        n_patches = len(patches)
        patch_area = np.bincount(self._row_patch, weights=area, minlength=n_patches).astype(np.float64)
        return ShootingSystem(
            area=patch_area,
            reflectance=self.light.reflectance[patches.row_material, : direct.shape[1]].astype(np.float64),
            direct=means(self._row_patch, area, direct, n_patches),
            rows=rows,
        )

    def _shots(self, system: ShootingSystem) -> Iterator[ShootingState]:
        """Shoot until little is left."""
        n_patches = len(system.area)
        weight = shooting_weights(self.plan.columns.expansion, luminous_weights(self.scene.bands))
        batch = max(LEAST_BATCH, n_patches // SHOT_SHARE)
        most = SHOTS_A_PATCH * n_patches
        return shoot(system, weight, tolerance=self.options.tolerance, batch=batch, max_shots=most)

    def _shoot(self, system: ShootingSystem, direct: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_patches, n_columns) exitance that every patch has shot when little is left."""
        history, cpu = [], time.process_time()
        for state in self._shots(system):
            history.append(state.residual)
            if self.watch is not None:
                self._show(self._progress(state, system.direct, direct))
        self.record.convergence.append(
            Convergence(
                tuple(history),
                history[-1] <= self.options.tolerance,
                products=state.shots / max(len(system.area), 1),
                solved_columns=direct.shape[1],
                solver="southwell",
                seconds=time.process_time() - cpu,
            )
        )
        return state.shot

    def _coarse_shot(self, system: ShootingSystem, rows: ShootingRows) -> NDArray[np.float64]:
        """(n_patches, n_columns) exitance that the patch of twice the size has shot that each is a part of."""
        for state in self._shots(self._companion.system(system, rows)):
            shot = state.shot
        return np.asarray(shot[self._companion.patch])

    def _progress(self, state: ShootingState, pooled: NDArray[np.float64], direct: NDArray[np.float64]) -> Progress:
        """Where shooting stands: on each element its own direct light, and what its patch received from shots."""
        received = state.irradiance - pooled
        shots = state.shots / max(len(pooled), 1)
        return Progress("southwell", shots, state.residual, lambda: direct + received[self._row_patch])

    def _note(
        self,
        irradiance: NDArray[np.float64],
        direct: NDArray[np.float64],
        exposed: NDArray[np.float64],
        rows: ShootingRows,
    ) -> None:
        """Running means, and what the hemicubes lost."""
        padded = self.plan.columns.padded
        self.iteration.means.add(padded(irradiance), padded(direct), exposed)
        lost = rows.lost[~np.isnan(rows.lost)]
        self.record.defects.append(
            Defects(
                row_sum_rms=float(np.sqrt(np.mean(lost**2))) if len(lost) else 0.0,
                row_sum_max=float(lost.max(initial=0.0)),
                reciprocity_rms=rows.reciprocity_defect(),
                scale_rms=0.0,
                scale_max=0.0,
                self_share=0.0,
                closure_residual=float(lost.max(initial=0.0)),
                closure_steps=0,
                lost_share=float(lost.mean()) if len(lost) else 0.0,
            )
        )
