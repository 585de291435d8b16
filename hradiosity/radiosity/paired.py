"""Runs whose elements exchange light by another method of form factors than rays."""

from __future__ import annotations

from typing import Any, Final

from hradiosity.device import Device
from hradiosity.model.scene import Note, Scene
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.radiosity.paired_surfaces import HemicubeSurfaces, PairedSurfaces
from hradiosity.radiosity.round import Round
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.transport.cell_pairs import RANDOM

_FIXED: Final = (
    "form factors are the same in each replicate: intervals hold what paths and shadow rays do, not their error"
)
_DRAWN: Final = "form factors are drawn again in each replicate: intervals hold their noise, not their bias"


class PairedSolver(RadiositySolver):
    """A run like that of `RadiositySolver`, with the exchange of ``options.form_factors``.

    Parameters
    ----------
    scene : Scene
    options : Options
    device : Device
    calibration : Calibration, optional
        Not used: it is that of exchange by rays.
    """

    def __init__(
        self,
        scene: Scene,
        options: Options,
        device: Device,
        calibration: Calibration | ClassicCalibration | None = None,
    ) -> None:
        self.surface_solver = HemicubeSurfaces if options.form_factors == "hemicube" else PairedSurfaces
        super().__init__(scene, options, device, calibration)

    def _prepared(self) -> Round:
        """Plan and elements of this round; made on first use."""
        is_new = not self._rounds.is_begun
        found = super()._prepared()
        if is_new:
            method = self.options.form_factors
            message = _DRAWN if method in (*RANDOM, "hemicube") else _FIXED
            self._rounds.notes = (*self.notes, Note("info", f"--form-factors {method}", message))
        return found

    def _summary(self) -> dict[str, Any]:
        surfaces = self._prepare()
        if not isinstance(surfaces, HemicubeSurfaces | PairedSurfaces):
            raise TypeError(f"surfaces with form factors are wanted, not {type(surfaces).__name__}")
        return super()._summary() | {"form_factors": surfaces.account()}
