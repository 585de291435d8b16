"""What the rounds of a run share, and what passes from one to the next: geometry, notes, light that is still shown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.errors import SceneError
from hradiosity.model.scene import Note, Scene
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.planning import make_plan
from hradiosity.planning_memory import check_fits
from hradiosity.planning_seconds import with_geometry
from hradiosity.radiosity.geometry import Geometry, find_geometry
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.round import Round
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.readings.interval import part_of


class Rounds:
    """The round that goes on, and the one before it as long as there is no light on the elements of this one.

    Parameters
    ----------
    device : Device
    scene : Scene
    size : Options
        Elements and rays of the first round.
    record : Record
        Filled while running.
    surface_solver : type of SurfaceSolver
        What estimates the light on the surfaces.
    calibration : Calibration or ClassicCalibration, optional
        Rates of the device in this mode, for the plan's expected seconds.

    Attributes
    ----------
    scene : as it is solved, once its geometry is known
    notes : remarks of the scene and of its geometry, and those that came to light while running
    size : elements and rays of the round
    shared : by part, share of each band that the replicates of earlier rounds may be off by alike
    """

    def __init__(
        self,
        device: Device,
        scene: Scene,
        size: Options,
        record: Record,
        surface_solver: type[SurfaceSolver],
        calibration: Calibration | ClassicCalibration | None = None,
    ) -> None:
        self.scene, self.size = scene, size
        self.notes: tuple[Note, ...] = scene.notes
        self.shared: dict[str, float] = {}
        self._device, self._record = device, record
        self._surface_solver, self._calibration = surface_solver, calibration
        self._geometry: Geometry | None = None
        self._now: Round | None = None
        self._before: Round | None = None

    @property
    def geometry(self) -> Geometry:
        """Ray structure and lit sides, found once; the scene is checked then."""
        if self._geometry is None:
            self._geometry = find_geometry(self._device, self.scene, self.size.seed, self._record)
            self.scene, self.notes = self._geometry.scene, self._geometry.notes
            self._record.cpu_seconds += self._geometry.cpu_seconds
        return self._geometry

    @property
    def now(self) -> Round:
        """The round that goes on; made on first use."""
        if self._now is None:
            self._now = self._made(self.size)
        return self._now

    @property
    def is_begun(self) -> bool:
        """Whether the round that goes on was made."""
        return self._now is not None

    @property
    def shown(self) -> SurfaceSolver | None:
        """Surfaces that there is light on: those of the last round, until there is some on those of this one."""
        shown = self._before or self._now
        return shown.surfaces if shown is not None and shown.count else None

    def shared_errors(self) -> dict[str, float]:
        """By part: share of each band that all replicates of the rounds may be off by alike that readings are of."""
        shown = self.shown
        now = {} if shown is None or self._before is not None else shown.shared_errors()
        return {part: max(self.shared.get(part, 0.0), now.get(part, 0.0)) for part in {**self.shared, **now}}

    def begin(self, size: Options) -> None:
        """Start anew with replicates of another size.

        Raises
        ------
        SceneError
            When they don't fit into memory.
        """
        self.size, self._now = size, None
        self._forget_account()
        self._now = self._made(size)

    def renew(self, size: Options) -> bool:
        """Other elements, beside which readings by the last ones count on; False, and a note, if they don't fit."""
        shared = self.shared_errors()
        try:
            made = self._made(size)
        except SceneError as error:
            self.notes = (*self.notes, Note("warning", "--accuracy", f"not reached: {error}"))
            return False
        self.size, self.shared = size, shared
        self._before, self._now = self._now, made
        self._forget_account()
        return True

    def forget_before(self, *, readings_too: bool) -> None:
        """There is light on the elements of this round; and maybe no reading is of earlier ones any more."""
        self._before = None
        self.shared = {} if readings_too else self.shared

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a checkpoint of the surfaces."""
        self.now.restore(part_of(kept, "surfaces"))

    def _made(self, size: Options) -> Round:
        """A round of some size, without replicates."""
        geometry = self.geometry
        cpu = self._device.work_cpu_seconds()
        with self._record.timed("geometry"):
            made = Round(lambda record: self._make_surfaces(geometry, size, record), self._record, size.seed)
        made.surfaces.plan = with_geometry(made.surfaces.plan, self._record.seconds)
        self._record.cpu_seconds += self._device.work_cpu_seconds() - cpu
        return made

    def _make_surfaces(self, geometry: Geometry, size: Options, record: Record) -> SurfaceSolver:
        """Elements of some size, without light."""
        plan = make_plan(self.scene, size, geometry.lit)
        surfaces = self._surface_solver(self._device, self.scene, geometry.bvh, geometry.lit, plan, size, record)
        surfaces.plan = surfaces.sized_plan(self._calibration)
        check_fits(surfaces.plan, self._device)
        return surfaces

    def _forget_account(self) -> None:
        self._record.defects.clear()
        self._record.convergence.clear()
