"""The scene's geometry and elements as the tracing kernels take them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.model.scene import Scene
from hradiosity.space.bvh import Bvh
from hradiosity.space.flush import flush_reach
from hradiosity.space.hierarchy import NONE, Elements


@dataclass(frozen=True)
class DeviceScene:
    """Device arrays by the names of the kernels' arguments, band-free.

    geometry : ray structure and patches
    emitters : patch, position and sides of each emitter
    solid : (n_patches,) uint32, 1 + number of the solid whose matter lies behind the patch; 0 for none
    flush_reach : (n_patches, 2) float32, see `hradiosity.space.flush.flush_reach` [m]
    n_emitters : number of emitters
    scale : size of the scene, for ray offsets [m]
    occlusion : False when nothing can stand between any two points
    shafts : True to leave out shadow rays where shafts prove that they are free
    """

    device: Device
    bvh: Bvh
    geometry: dict[str, DeviceArray]
    emitters: dict[str, DeviceArray]
    solid: DeviceArray
    flush_reach: DeviceArray
    n_emitters: int
    occlusion: bool
    shafts: bool

    @property
    def scale(self) -> float:
        """Largest half extent of the scene [m]: ray offsets are relative to it."""
        return self.bvh.scale

    def without_occlusion(self) -> DeviceScene:
        """The same, taking all sight lines for free."""
        return replace(self, occlusion=False)


@dataclass(frozen=True)
class DeviceElements:
    """Row elements on the device.

    cells : arrays by the names of the kernels' arguments
    side_paint : (n_patches, 2) uint32, see `hradiosity.transport.glow.Glow`
    proved : (n_rows, n_emitters) uint8, see `hradiosity.space.shafts`; None where nothing was tried
    """

    elements: Elements
    cells: dict[str, DeviceArray]
    side_paint: DeviceArray
    proved: DeviceArray | None = None

    def sight(self, scene: DeviceScene) -> DeviceArray:
        """What is sure about the sight between rows and emitters; all unknown where nothing was tried."""
        if self.proved is not None:
            return self.proved
        return scene.device.upload(np.zeros((max(len(self.elements), 1), max(scene.n_emitters, 1)), np.uint8))

    def with_sight(self, device: Device, sight: NDArray[np.uint8]) -> DeviceElements:
        """The same, with what was proved about rows and emitters."""
        return replace(self, proved=device.upload(sight) if sight.size else None)


_NOTHING: Final = np.zeros((1, 3), np.float32)


def upload_scene(device: Device, scene: Scene, bvh: Bvh, *, occlusion: bool, shafts: bool = True) -> DeviceScene:
    """Put what does not depend on the elements on the device; coordinates relative to the local origin."""
    lamps = scene.emitters
    two_sided = np.array([lamp.two_sided for lamp in scene.luminaires], bool)
    position = (lamps.position - bvh.local_origin).astype(np.float32) if len(lamps) else _NOTHING
    return DeviceScene(
        device=device,
        bvh=bvh,
        geometry=bvh.kernel_arguments() | bvh.patch_arguments(),
        emitters={
            "emitter_patch": device.upload(np.where(lamps.patch < 0, NONE, lamps.patch), np.uint32),
            "emitter_position": device.upload(position),
            "emitter_extent": device.upload(_emitter_extent(scene), np.float32),
            "emitter_two_sided": device.upload(two_sided[lamps.luminaire], np.uint32),
        },
        solid=device.upload(scene.patches.solid + 1, np.uint32),
        flush_reach=device.upload(flush_reach(scene.patches)),
        n_emitters=len(lamps),
        occlusion=occlusion,
        shafts=shafts,
    )


def _emitter_extent(scene: Scene) -> NDArray[np.float64]:
    """(n_emitters, 2) area [m²] and diameter [m] of each emitter; 0 for a point source."""
    lamps, patches = scene.emitters, scene.patches
    extent = np.zeros((max(len(lamps), 1), 2))
    flat = np.flatnonzero(lamps.patch >= 0)
    patch = lamps.patch[flat]
    corners = patches.corners()[patch]
    extent[flat, 0] = patches.area[patch]
    extent[flat, 1] = np.linalg.norm(corners[:, :, None] - corners[:, None, :], axis=-1).max(axis=(1, 2), initial=0.0)
    return extent


def upload_elements(device: Device, elements: Elements, paint: NDArray[np.uint32] | None = None) -> DeviceElements:
    """Put the row elements on the device; the paint (n_patches, 2) of each side is its material if none is given."""
    return DeviceElements(
        elements=elements,
        cells={
            "cell_divisions": device.upload(elements.divisions),
            "side_first_cell": device.upload(elements.first_cell),
            "cell_row": device.upload(elements.cell_row),
            "cell_side": device.upload(elements.cell_side),
            "row_start": device.upload(elements.row_start),
            "row_cell": device.upload(elements.row_cell),
            "row_share": device.upload(elements.row_share),
        },
        side_paint=device.upload(elements.side_material if paint is None else paint),
    )
