"""A solution as images look it up: tables on the device, in bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.lamps import lamp_emissions, lamp_exitances, side_luminaires
from hradiosity.model.scene import Scene, View
from hradiosity.radiosity.scene_light import EQUAL_ENERGY_WEIGHT
from hradiosity.show.image_guide import row_guides, rows_seen
from hradiosity.show.image_lamps import lamp_tables
from hradiosity.solution import Solution
from hradiosity.transport.contrast import lookup_sizes
from hradiosity.transport.device_scene import DeviceScene, upload_elements
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.glow import glow_of, sampled_scene

ROW_RAYS: Final = 128
"""From each element, to see from how many directions its light comes."""


@dataclass(frozen=True)
class ImageLight:
    """What the kernel ``image_samples`` takes of a scene and its solution.

    scene : geometry, and the emitters that shadow rays go to
    arguments : device arrays and numbers by the names of the kernel's arguments
    n_bands : bands of the spectra, which are filled up with zeros to groups of eight
    """

    scene: DeviceScene
    arguments: dict[str, DeviceArray | int | float]
    n_bands: int

    @property
    def n_groups(self) -> int:
        """Groups of eight bands."""
        return -(-self.n_bands // 8)


def image_light(solution: Solution, on_device: DeviceScene, views: Sequence[View]) -> ImageLight:
    """Tables for images of a solution from some views; from others there would be more noise.

    Parameters
    ----------
    solution : Solution
    views : sequence of View
    on_device : DeviceScene
        With the solution's sampled emitters.
    """
    scene, plan, device = solution.scene, solution.plan, on_device.device
    glow = glow_of(scene, plan.columns, plan.weak_emitters)
    elements = upload_elements(device, solution.elements, glow.paint)
    own = np.concatenate([scene.reflectance, np.zeros((1, len(scene.bands)))])[glow.material]
    shining = plan.columns.to_bands(glow.exitance)
    first_side = solution.elements.cell_side[solution.elements.row_cell[solution.elements.row_start[:-1]]]
    row_paint = glow.paint.ravel()[first_side]
    reflected = own[row_paint] * solution.surfaces.irradiance * plan.interreflection + shining[row_paint]
    hits = trace_rows(on_device, elements, ROW_RAYS, _seed(solution))
    emission = lamp_emissions(scene)[sampled_scene(scene, plan.weak_emitters).emitters.luminaire]
    sky = np.zeros(len(scene.bands)) if scene.sky is None else np.pi * scene.sky.radiance
    weight = luminous_weights(scene.bands) + EQUAL_ENERGY_WEIGHT
    exposed = solution.elements.area * solution.surfaces.exposed
    arriving = solution.surfaces.irradiance @ weight
    seen = rows_seen(solution, on_device.bvh, views)
    cells = {name: elements.cells[name] for name in ("cell_divisions", "side_first_cell", "cell_row")}
    arguments: dict[str, DeviceArray | int | float] = {
        **cells,
        "patch_solid": on_device.solid,
        "side_paint": elements.side_paint,
        "side_lamp": device.upload(side_luminaires(scene).astype(np.uint32)),
        "row_size": device.upload(lookup_sizes(hits, solution.elements, exposed, reflected @ weight, arriving)),
        **lamp_tables(on_device, elements, hits, emission @ weight, _seed(solution)),
        **row_guides(on_device, elements, seen, reflected @ weight, float(sky @ weight), _seed(solution)),
        "reflectance": device.upload(padded(own)),
        "glow": device.upload(padded(shining)),
        "shown": device.upload(padded(lamp_exitances(scene))),
        "emission": device.upload(padded(emission)),
        "reflected": device.upload(padded(reflected)),
        "sky": device.upload(padded(sky)),
        "colour": device.upload(padded(_colour_weights(scene))),
        "n_emitters": on_device.n_emitters,
        "occlusion": int(on_device.occlusion),
        "gathers": int(plan.gathers or scene.sky is not None),
        "bounce": float(plan.interreflection),
    }
    return ImageLight(on_device, arguments, len(scene.bands))


def padded(bands: NDArray[np.floating]) -> NDArray[np.float32]:
    """(…, n_bands) as float32 with zero bands up to a multiple of eight; at least one row."""
    rows = bands if len(bands) else np.zeros((1, *bands.shape[1:]))
    out = np.zeros((*rows.shape[:-1], -(-rows.shape[-1] // 8) * 8), np.float32)
    out[..., : rows.shape[-1]] = rows
    return out


def _colour_weights(scene: Scene) -> NDArray[np.float64]:
    """(4, n_bands) X, Y, Z of the radiance of a diffuse surface for its exitance, and illuminance for irradiance."""
    return np.vstack([xyz_weights(scene.bands).T / np.pi, luminous_weights(scene.bands)])


def _seed(solution: Solution) -> int:
    """Of the tables' own random numbers."""
    return int(solution.record["options"]["seed"]) ^ 0x1B56C4E9
