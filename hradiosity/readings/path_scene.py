"""What unbiased paths meet: materials and lamps in plain bands, beside the geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.model.geometry import NONE
from hradiosity.model.lamps import lamp_emissions
from hradiosity.model.scene import Scene
from hradiosity.transport.device_scene import DeviceScene

_NO_ONE = 0xFFFFFFFF


@dataclass(frozen=True)
class RefereeScene:
    """Materials and lamps in plain bands, padded to groups of eight, beside the geometry.

    scene : geometry and emitters
    arguments : device arrays by the names of the kernel's arguments
    emission : (n_emitters, 8 n_groups) float32, exitance [W m⁻²] or intensity [W sr⁻¹]
    n_groups : groups of eight bands
    direct_share : points drawn on each emitter for each path from a reading
    """

    scene: DeviceScene
    arguments: dict[str, DeviceArray]
    emission: NDArray[np.float32]
    n_bands: int
    n_groups: int
    direct_share: float


def prepare_referee(on_device: DeviceScene, scene: Scene) -> RefereeScene:
    """Upload what paths need beside the geometry.

    Raises
    ------
    ValueError
        When a patch emits twice: a ray that meets it could not tell which emitter it is.
    """
    lamps = scene.emitters
    area_lamps = np.flatnonzero(lamps.patch != NONE)
    if len(np.unique(lamps.patch[area_lamps])) < len(area_lamps):
        raise ValueError("a patch belongs to two emitters")
    patch_emitter = np.full(len(scene.patches), _NO_ONE, np.uint32)
    patch_emitter[lamps.patch[area_lamps]] = area_lamps
    emission = _padded(_emission(scene))
    sky = np.zeros(len(scene.bands)) if scene.sky is None else np.pi * scene.sky.radiance
    device = on_device.device
    return RefereeScene(
        scene=on_device,
        arguments={
            "side_material": device.upload(_side_materials(scene)),
            "patch_solid": on_device.solid,
            "patch_emitter": device.upload(patch_emitter),
            "emitter_power": device.upload(_relative_power(scene), np.float32),
            "reflectance": device.upload(_padded(scene.reflectance)),
            "emission": device.upload(emission),
            "sky": device.upload(_padded(sky)),
        },
        emission=emission,
        n_bands=len(scene.bands),
        n_groups=emission.shape[1] // 8,
        direct_share=0.5 ** int(np.log2(max(len(lamps), 1))),
    )


def _emission(scene: Scene) -> NDArray[np.float64]:
    """(n_emitters, n_bands) exitance [W m⁻²] or intensity [W sr⁻¹]."""
    return lamp_emissions(scene)[scene.emitters.luminaire]


def _relative_power(scene: Scene) -> NDArray[np.float64]:
    """(n_emitters,) mean exitance times area, or π times mean intensity, over the largest of them."""
    is_area = scene.emitters.patch != NONE
    size = np.full(len(scene.emitters), np.pi)
    size[is_area] = scene.patches.area[scene.emitters.patch[is_area]]
    power: NDArray[np.float64] = _emission(scene).mean(axis=1) * size
    return power / max(float(power.max(initial=0.0)), np.finfo(np.float64).tiny)


def _side_materials(scene: Scene) -> NDArray[np.uint32]:
    """(n_patches, 2) material of each side; `_NO_ONE` for black backs and for those with matter behind."""
    patches = scene.patches
    two_sided = np.array([m.two_sided for m in scene.materials], bool)
    black = ~two_sided[patches.material] | (patches.solid != NONE)
    return np.stack([patches.material, np.where(black, _NO_ONE, patches.material)], axis=1).astype(np.uint32)


def _padded(bands: NDArray[np.float64]) -> NDArray[np.float32]:
    """(…, n_bands) as float32 with zero bands up to a multiple of eight; at least one row."""
    rows = bands if len(bands) else np.zeros((1, *bands.shape[1:]))
    out = np.zeros((*rows.shape[:-1], -(-rows.shape[-1] // 8) * 8), np.float32)
    out[..., : rows.shape[-1]] = rows
    return out
