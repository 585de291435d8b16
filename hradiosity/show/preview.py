"""A quick picture while the run goes on: one ray a pixel, one value an element."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb, xyz_weights
from hradiosity.model.scene import Scene, View
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.show.camera import ABOVE, NOTHING, ViewHits, trace_view
from hradiosity.show.channels import emitted_xyz, reflected_channels
from hradiosity.show.exposure import to_bytes, white_luminance
from hradiosity.show.files import png_bytes, write_bytes
from hradiosity.show.first_picture import first_view, preview_texts
from hradiosity.show.white import WhiteName, white_of
from hradiosity.solution import Solution
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.hierarchy import Elements

_EVERY: Final = 4
"""Of so many pixels one takes part in the choice of the exposure."""


class Preview:
    """Draws what a running solver knows, again and again from one view.

    ``Preview(scene, device).write(solver, folder / "preview.png")`` after each replicate. The exposure,
    ``white_luminance`` [cd m⁻²], is chosen with the first light and then stays. What is shown before there is any
    solution is `hradiosity.show.first_picture`.

    Parameters
    ----------
    scene : Scene
        With at least one patch.
    device : Device
    view : View, optional
        The first of the scene, or an automatic one, if left out.
    bvh : Bvh, optional
        The scene's ray structure, where it is at hand already.
    white : WhiteName
        What is shown as white, see `hradiosity.show.white`.
    """

    def __init__(
        self,
        scene: Scene,
        device: Device,
        view: View | None = None,
        bvh: Bvh | None = None,
        white: WhiteName = "as-measured",
    ) -> None:
        bvh = build_bvh(device, scene.patches) if bvh is None else bvh
        self.view = first_view(scene, bvh) if view is None else view
        self._scene = scene
        self._white = white_of(scene, white)
        self._hits: ViewHits = trace_view(bvh, self.view, 1)
        self._emitted = emitted_xyz(scene)
        self._elements: Elements | None = None
        self._row = self._side = self._number = np.zeros(0, np.int64)
        self.white_luminance: float | None = None

    def write(self, solver: RadiositySolver, path: Path) -> None:
        """Write a PNG of what the solver knows.

        Raises
        ------
        OutputError
            When the file can't be written.
        RuntimeError
            Before the first replicate.
        """
        write_bytes(path, png_bytes(self.pixels(solver.solution()), preview_texts(self._scene, self.view)))

    def pixels(self, solution: Solution) -> NDArray[np.uint8]:
        """(height, width, 3) sRGB of a solution."""
        if solution.elements is not self._elements:
            self._locate(solution.elements)
        colours = to_bytes(encode_srgb(self._light(solution)))
        return colours[self._number].reshape(self.view.height, self.view.width, 3)

    def _light(self, solution: Solution) -> NDArray[np.float64]:
        """Linear sRGB of all that is seen."""
        scene, row, side = self._scene, self._row, self._side
        of_row = reflected_channels(scene, solution.elements.row_material, solution.surfaces.irradiance)[:, :3]
        emitted = np.where(side[:, None] >= 0, self._emitted[np.maximum(side, 0)], np.float32(0.0))
        radiance = (np.where(row[:, None] >= 0, of_row[np.maximum(row, 0)], np.float32(0.0)) + emitted) / np.pi
        if scene.sky is not None:
            radiance[side == ABOVE] = np.einsum("b,bc->c", scene.sky.radiance, xyz_weights(scene.bands))
        shown = self._white.shown(radiance)
        if self.white_luminance is None:
            dull = ((row >= 0) & (side == NOTHING))[self._number]
            self.white_luminance = white_luminance([shown.astype(np.float32)[self._number[dull][::_EVERY]]])
        return xyz_to_linear_srgb(shown, self.white_luminance)

    def _locate(self, elements: Elements) -> None:
        """Number what is seen: row elements, emitting sides of them, the sky."""
        hits = self._hits
        cell, _, _ = locate_cells(elements, self._scene.patches.is_triangle, hits.side, hits.u, hits.v)
        row = np.where(cell >= 0, elements.cell_row[np.maximum(cell, 0)].astype(np.int64), -1)
        shines = np.any(self._emitted > 0.0, axis=1)[np.maximum(hits.side, 0)] | (hits.side == ABOVE)
        side = np.where(shines, hits.side, NOTHING)
        span = len(self._emitted) + 2
        pairs, number = np.unique((row + 1) * span + side + 2, return_inverse=True)
        self._row, self._side, self._number = pairs // span - 1, pairs % span - 2, number
        self._elements = elements
