"""Light on the surfaces: one replicate of the exchange between row elements and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.estimate import EXCHANGE, MESH
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Note, Scene
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration, Plan
from hradiosity.planning import sized
from hradiosity.planning_memory import check_fits
from hradiosity.radiosity.aiming import Aiming
from hradiosity.radiosity.companion import Companion, half_of
from hradiosity.radiosity.iteration import Iteration
from hradiosity.radiosity.proved_sight import plan_with_sight, proved_sight
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.refinement import GreyLight, Refinement
from hradiosity.radiosity.row_lamps import RowLamps
from hradiosity.radiosity.row_light import RowLight, light_of_glow
from hradiosity.radiosity.scene_light import SceneLight
from hradiosity.radiosity.watching import Glimpse, LightWatch
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.solution import Surfaces
from hradiosity.solvers.choice import SolverChoice
from hradiosity.solvers.dense import DIRECT_SOLVERS, check_dense_size
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Progress
from hradiosity.solvers.southwell import shooting_weights
from hradiosity.solvers.spectral_basis import TOLERANCE, SpectralBasis, choose_basis
from hradiosity.space.bvh import Bvh
from hradiosity.space.companion import coarser_rows
from hradiosity.space.hierarchy import UNLIT, Elements, build_elements
from hradiosity.space.lit_sides import LitSides, find_lit_sides
from hradiosity.transport.aim_shares import RayWorth, Smoothing
from hradiosity.transport.aims import trace_aimed_rows
from hradiosity.transport.contrast import lookup_sizes
from hradiosity.transport.device_scene import DeviceScene, upload_elements, upload_scene
from hradiosity.transport.direct import light_of_emitters
from hradiosity.transport.exchange import ClosedRows, Exchange, RowHits, build_exchange, trace_rows
from hradiosity.transport.glow import sampled_scene

RETRIES = 3
"""Times that sides found to be lit only by the exchange rays are added, and the rays traced again."""
COMPANION_ROTA = (MESH, "", MESH, EXCHANGE)
"""What the replicates' companions tell about, in turn; these changes are far steadier than the readings themselves."""
LOST_SHARE = 1e-4
"""Share of exchange rays that may end on sides thought to be dark; more, and those sides join."""


class SurfaceSolver:
    """Estimates the light on all row elements, afresh for each seed.

    Parameters
    ----------
    device : Device
    scene : Scene
    bvh : Bvh
    lit : LitSides
    plan : Plan
    options : Options
    record : Record
        Filled while running.
    """

    watch: LightWatch | None = None
    """Called while the light is solved for."""
    exchange_by_rays = True
    """Whether the exchange is made of the rays that each element sends out."""
    uses_shafts = True
    """Whether shafts are tried before shadow rays."""

    def __init__(
        self, device: Device, scene: Scene, bvh: Bvh, lit: LitSides, plan: Plan, options: Options, record: Record
    ) -> None:
        if options.mode == "rays":
            check_fits(plan, device)
        self.device, self.scene, self.plan, self.options, self.record = device, scene, plan, options, record
        self._bvh = bvh
        self.sampled = sampled_scene(scene, plan.weak_emitters)
        self.on_device: DeviceScene = upload_scene(
            device, self.sampled, bvh, occlusion=plan.occlusion, shafts=self.uses_shafts and options.occlusion is None
        )
        self.light = SceneLight.of(device, scene, self.sampled, plan)
        columns = plan.columns
        weight = columns.padded(shooting_weights(columns.summed, luminous_weights(scene.bands)))
        self._choice = SolverChoice(options.solver, weight, options.blocks)
        self._refinement = Refinement.of(scene, plan, options)
        self._cut(lit)

    def _cut(self, lit: LitSides) -> None:
        """Cut the lit sides into row elements; forget what was known about others."""
        self._lit = lit
        self.elements: Elements = self._refinement.refined(self.scene.patches, self._divide(lit))
        self.on_device_elements = upload_elements(self.device, self.elements, self.light.glow.paint)
        self.sight = proved_sight(self.on_device, self.plan, self.sampled, self._bvh, self.elements, lit)
        if self.sight is not None:
            self.on_device_elements = self.on_device_elements.with_sight(self.device, self.sight)
        first = self.elements.row_cell[self.elements.row_start[:-1]]
        self.space: NDArray[np.int32] = lit.space.ravel()[self.elements.cell_side[first]]
        self._row_glow = self.light.exitance[self.light.glow.paint.ravel()[self.elements.cell_side[first]]]
        self._links = np.zeros((0, 2), np.int64)
        self._aiming = Aiming()
        solver = RowLight(self.plan, self.options, self._choice, self._choose_basis())
        self.iteration = Iteration(solver, self.space, self.elements.area)
        self._parent = self._coarser()
        lamps = self.light.emission, self.sight, self.plan.light_points
        self._lamps = RowLamps.of(self.on_device, self.on_device_elements, *lamps, self.options.seed)

    def _divide(self, lit: LitSides) -> Elements:
        """The row elements of the lit sides."""
        two_sided = np.array([m.two_sided for m in self.scene.materials], bool)
        size, paint = self.plan.element_size, self.light.glow.paint
        return build_elements(self.scene.patches, lit.space, two_sided, size, paint=paint, slots=lit.slots)

    def _coarser(self) -> NDArray[np.int64]:
        """(n_rows,) element of twice the size that each row is part of."""
        if not len(self.elements):
            return np.zeros(0, np.int64)
        size = self.plan.element_size
        return coarser_rows(self.scene.patches, self.elements, self.space, self.light.glow.paint, size)

    def replicate(self, seed: int) -> SurfaceLight:
        """One independent estimate, as paths look it up."""
        with self.record.timed("exchange rays"):
            hits = self._trace(seed)
        with self.record.timed("direct light"):
            per_emitter, rays = self._lamps.direct(hits, self.plan.light_points, seed, self._aiming.points)
            self.record.rays += rays
        with self.record.timed("exchange"):
            exchange = self._exchange(hits, seed)
            self.record.defects.append(exchange.defects)
        row_direct = self.device.upload(per_emitter)
        direct = self._direct_columns(row_direct, exchange)
        reflectance = self.light.reflectance[self.elements.row_material]
        companion = COMPANION_ROTA[self.iteration.means.count % len(COMPANION_ROTA)]
        with self.record.timed("solution"):
            irradiance = self._solve(exchange, reflectance, direct)
        with self.record.timed("refinement"):
            first = self.iteration.means.count == 1 and not self._aiming.done
            again = first and self._refine(hits, exchange, reflectance, irradiance, direct, seed)
        if again:
            return self.replicate(seed)
        with self.record.timed("companion"):
            coarse = None
            if companion == MESH:
                coarse = self._coarse(exchange, reflectance, direct, irradiance)
            elif companion == EXCHANGE:
                coarse = self._with_half_the_rays(hits, seed, reflectance, direct, irradiance)
        light = self._looked_up(hits, exchange.element_area, row_direct, reflectance, irradiance)
        change = None if coarse is None else self.device.upload(reflectance * (coarse - irradiance))
        return replace(light, change=change, changed_by=companion)

    def _looked_up(
        self,
        hits: RowHits,
        area: NDArray[np.float64],
        row_direct: DeviceArray,
        reflectance: NDArray[np.float32],
        irradiance: NDArray[np.float32],
    ) -> SurfaceLight:
        """The light of a replicate as paths look it up."""
        return SurfaceLight(
            columns=self.plan.columns,
            reflectance=self.light.reflectance_on_device,
            glow=self.light.exitance_on_device,
            emission=self.light.emission,
            emission_on_device=self.light.emission_on_device,
            reflected=self.device.upload(reflectance * irradiance + self._row_glow),
            row_size=self.device.upload(self._lookup_size(hits, area, reflectance, irradiance)),
            sky=self.light.sky_on_device,
            emitter_choice=self._lamps.choice(row_direct),
            row_direct=row_direct,
            weight=self.light.weight_on_device,
            row_space=self.space,
            spots=self._aiming.spots,
        )

    def _lookup_size(
        self,
        hits: RowHits,
        area: NDArray[np.float64],
        reflectance: NDArray[np.float32],
        irradiance: NDArray[np.float32],
    ) -> NDArray[np.float32]:
        """`SurfaceLight.row_size`."""
        brightness = self.light.brightness
        leaving = np.einsum("rc,c->r", reflectance * irradiance + self._row_glow, brightness)
        arriving = np.einsum("rc,c->r", irradiance, brightness)
        return lookup_sizes(hits, self.elements, area, leaving, arriving)

    def _refine(
        self,
        hits: RowHits,
        exchange: ClosedRows,
        reflectance: NDArray[np.float32],
        irradiance: NDArray[np.float32],
        direct: NDArray[np.float32],
        seed: int,
    ) -> bool:
        """Whether elements were split because of this replicate's light, which is then of no more use."""
        if not isinstance(exchange, Exchange):
            return False
        brightness = self.light.brightness
        rows = irradiance, reflectance * irradiance, self._row_glow
        light = GreyLight.of(brightness, *rows, self.light.emission, sky=self.light.sky)
        patches = self.scene.patches
        again = self._refinement.next_round(
            self.on_device, self.on_device_elements, patches, hits, exchange, light, seed
        )
        self.record.rays += self._refinement.rays
        if again:
            self.record.convergence.clear()
            self.record.defects.clear()
            self._split_rows()
        self._plan_for_elements()
        return again or self._aim(hits, light, np.einsum("rc,c->r", direct, brightness), seed)

    def _aim(self, hits: RowHits, light: GreyLight, direct: NDArray[np.float64], seed: int) -> bool:
        """Whether rays go elsewhere from now on because of this replicate's light, which then is computed again."""
        importance = self._refinement.importance
        if importance is None or not self.exchange_by_rays:
            return False
        smooth = Smoothing.of(self.scene.patches, self.elements)
        leaving = light.reflectance * (direct + smooth(light.arriving - direct)) + light.glow
        worth = RayWorth(leaving, light.reflectance * smooth(importance), light.sky)
        again = self._aiming.look(
            self.on_device,
            self.on_device_elements,
            hits,
            worth,
            light.emission,
            None if self._lamps.chance is not None else self.device.fetch(self._lamps.clear),
            self.sight,
            n_points=self.plan.light_points,
            replicates=self.plan.replicates,
            seed=seed,
        )
        self.record.rays += self._aiming.rays
        if again:
            self.record.convergence.clear()
            self.record.defects.clear()
            self.iteration = Iteration(self.iteration.solver, self.space, self.elements.area)
        return again

    def _split_rows(self) -> None:
        """Cut the same sides, then split what is to be split."""
        links = self._links
        self._cut(self._lit)
        self._links = links

    def sized_plan(self, calibration: Calibration | ClassicCalibration | None) -> Plan:
        """The plan for the elements that were cut, with seconds if the device was measured in this mode.

        Raises
        ------
        SceneError
            When the solver asked for would need too much memory.
        """
        if self.options.solver in DIRECT_SOLVERS and self.plan.interreflection:
            check_dense_size(len(self.elements), self.options.solver)
        known = calibration if isinstance(calibration, Calibration) else None
        plan = sized(self.plan, len(self.elements), known)
        if self.sight is None:
            return plan
        return plan_with_sight(plan, self.sampled, self._bvh, self.elements, self.space, self.sight, known)

    def surfaces(self) -> Surfaces:
        """Mean over the replicates so far, each row's over those parts of it that its rays found exposed."""
        return self.iteration.means.surfaces(self.plan.columns, self.space)

    def _show(self, progress: Progress) -> None:
        """Let whoever watches have a look."""
        if self.watch is not None:
            means, found = self.iteration.means, (self.plan.columns, self.space)
            light = partial(means.surfaces_with, progress, *found)
            self.watch(Glimpse(self.scene, self.elements, progress, means.count, light))

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs beside the constructor's arguments."""
        return {
            "links": self._links,
            **self._refinement.checkpoint(),
            **self._aiming.checkpoint(self.device),
            **self.iteration.checkpoint(),
        }

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a checkpoint, bit for bit."""
        if not np.array_equal(kept["links"], self._links):
            self._cut_again(kept["links"])
        if self._refinement.restore(kept):
            self._split_rows()
        self._plan_for_elements()
        self._aiming.restore(self.device, kept)
        self.iteration.restore(kept)

    def _trace(self, seed: int) -> RowHits:
        """Exchange rays; sides that only now turn out to be lit join, and the rays start again."""
        for attempt in range(RETRIES + 1):
            rows, n_rays, aims = self.on_device_elements, self.plan.rays_per_element, self._aiming.aims
            if aims is None:
                hits = trace_rows(self.on_device, rows, n_rays, seed)
            else:
                hits = trace_aimed_rows(self.on_device, rows, aims, n_rays, seed)
            self.record.rays += hits.row.size
            if attempt == RETRIES or np.count_nonzero(hits.row == UNLIT) <= LOST_SHARE * hits.row.size:
                break
            self._cut_again(np.concatenate([self._links, hits.unlit_links(self.elements)]))
        return hits

    def _cut_again(self, links: NDArray[np.int64]) -> None:
        """Cut all sides that are lit now that some (n, 2) are known to see each other, and plan for these elements."""
        self._refinement.start()
        self._cut(find_lit_sides(self.scene, self._bvh, seed=self.options.seed, known_links=links))
        self._links = links
        self._plan_for_elements()

    def _plan_for_elements(self) -> None:
        """Bring the plan up to the elements that there are."""
        before, after = (sized(self.plan, n).memory_bytes for n in (self.plan.n_elements, len(self.elements)))
        memory = self.plan.memory_bytes + after - before
        effects = self._refinement.told(self.plan.effects, len(self.elements))
        self.plan = replace(self.plan, n_elements=len(self.elements), memory_bytes=memory, effects=effects)

    def notes(self) -> tuple[Note, ...]:
        """What came to light only while running."""
        if not len(self._links):
            return ()
        late = len(np.unique(self._links[:, 1]))
        message = (
            f"rays found light on {late} side{'s' if late > 1 else ''} of patches that seemed dark when the run was "
            f"planned; the surfaces were cut again, into {len(self.elements)} elements"
        )
        return (Note("info", "plan", message),)

    def _exchange(self, hits: RowHits, seed: int) -> ClosedRows:
        """The exchange between row elements, closed."""
        return build_exchange(hits, self.elements)

    def _operator(self, exchange: ClosedRows) -> ExchangeOperator:
        """What solvers iterate with."""
        return ExchangeOperator(self.device, self._rows(exchange))

    def _rows(self, exchange: ClosedRows) -> Exchange:
        """The same between single elements."""
        if not isinstance(exchange, Exchange):
            raise TypeError(f"rows between single elements are wanted, not {type(exchange).__name__}")
        return exchange

    def _direct_columns(self, row_direct: DeviceArray, exchange: ClosedRows) -> NDArray[np.float32]:
        """(n_rows, 8 n_groups) direct irradiance from emitters and sky."""
        direct = light_of_emitters(
            self.device, row_direct, self.light.emission_on_device, (len(self.elements), self.on_device.n_emitters)
        )
        if self.scene.sky is not None:
            area = exchange.element_area
            share = np.divide(exchange.sky, area, out=np.zeros_like(area), where=area > 0.0)
            direct += share.astype(np.float32)[:, None] * self.light.sky
        return direct

    def _solve(
        self, exchange: ClosedRows, reflectance: NDArray[np.float32], direct: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Irradiance of the row elements; keeps the running means."""
        irradiance = direct
        if self.plan.gathers and len(self.elements):
            operator, watch = self._operator(exchange), self._show if self.watch else None
            irradiance, account = self.iteration.light(
                operator, exchange.element_area, reflectance, direct, self._row_glow, watch
            )
            self.record.convergence.extend(account)
        self.iteration.add(irradiance, direct, exchange.element_area)
        return irradiance

    def _coarse(
        self,
        exchange: ClosedRows,
        reflectance: NDArray[np.float32],
        direct: NDArray[np.float32],
        irradiance: NDArray[np.float32],
    ) -> NDArray[np.float32]:
        """(n_rows, 8 n_groups) irradiance by elements of twice the size, from the same hits."""
        if not self.plan.gathers or not len(self.elements):
            return irradiance
        return Companion(self._parent, exchange.element_area).light(
            self.device,
            self._rows(exchange),
            replace(self.iteration.solver, choice=replace(self._choice, name="cg")),
            reflectance,
            direct,
            self._row_glow,
            irradiance,
            self.iteration.deflation,
        )

    def _with_half_the_rays(
        self,
        hits: RowHits,
        seed: int,
        reflectance: NDArray[np.float32],
        direct: NDArray[np.float32],
        irradiance: NDArray[np.float32],
    ) -> NDArray[np.float32] | None:
        """(n_rows, 8 n_groups) irradiance by half of the exchange rays; None where the exchange is not made of them.

        Scaling rows of few rays until they close favours links that were hit by chance, an error of the order of one
        over the number of rays that grows with the number of reflections and that replicates have in common.
        """
        if not self.exchange_by_rays:
            return None
        if not self.plan.gathers or not len(self.elements):
            return irradiance
        exchange = self._exchange(half_of(hits), seed)
        operator = self._operator(exchange)
        lit = direct + light_of_glow(operator, self._row_glow)
        if self.plan.interreflection:
            lit = self.iteration.solver.solve(operator, reflectance, lit, irradiance - lit, self.iteration.deflation)[0]
        return np.where(exchange.element_area[:, None] > 0.0, lit, irradiance)

    def shared_errors(self) -> dict[str, float]:
        """By part of the intervals: share of itself that each band may be off by in all replicates alike."""
        return self.iteration.shared_errors(self.record.convergence)

    def _choose_basis(self) -> SpectralBasis | None:
        """Columns to iterate on; None for all."""
        if self.options.reduced_basis is False:
            return None
        columns = self.plan.columns
        sources = np.concatenate([columns.emission, columns.sky[None]])
        material = np.minimum(self.elements.row_material, len(columns.reflectance) - 1)
        area = np.bincount(material, weights=self.elements.area, minlength=len(columns.reflectance)).astype(np.float64)
        return choose_basis(sources, columns.reflectance, area, tolerance=min(TOLERANCE, self.options.tolerance))
