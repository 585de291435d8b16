"""Lamps, paints and sky of a scene in the columns of its plan, on the host and on the device."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.transport.glow import Glow, glow_of

EQUAL_ENERGY_WEIGHT = 1.0
"""Brightness of a watt of any wavelength beside its lumens, so that no band counts for nothing [lm W⁻¹]."""


@dataclass(frozen=True)
class SceneLight:
    """What a whole run has of lamps and paints; all have 8 n_groups columns, float32, where nothing else is said.

    emission : (n_emitters, …), exitance or intensity of each emitter that is sampled
    reflectance : (n_materials, …)
    glow : lamps that are left to the rays that meet them
    exitance : (n_paints, …), what paints shine with that no shadow ray looks for
    brightness : (8 n_groups,) float64, of a unit of each column
    sky : (8 n_groups,), π · radiance
    emission_on_device, reflectance_on_device, weight_on_device, sky_on_device : the same, reflectance by paint
    exitance_on_device : the same; None if no paint shines
    """

    emission: NDArray[np.float32]
    reflectance: NDArray[np.float32]
    glow: Glow
    exitance: NDArray[np.float32]
    brightness: NDArray[np.float64]
    sky: NDArray[np.float32]
    emission_on_device: DeviceArray
    reflectance_on_device: DeviceArray
    weight_on_device: DeviceArray
    sky_on_device: DeviceArray
    exitance_on_device: DeviceArray | None

    @classmethod
    def of(cls, device: Device, scene: Scene, sampled: Scene, plan: Plan) -> SceneLight:
        """Of a scene, and of the part of it whose emitters are sampled (`hradiosity.transport.glow.sampled_scene`)."""
        columns = plan.columns
        emission = columns.padded(columns.emission[sampled.emitters.luminaire])
        reflectance = columns.padded(columns.reflectance * plan.interreflection)
        glow = glow_of(scene, columns, plan.weak_emitters)
        exitance, sky = columns.padded(glow.exitance), columns.padded(columns.sky)
        # Paths without an emitter to draw read row 0 and multiply it by 0: what lies beyond a buffer may be NaN.
        dark = np.zeros((1, emission.shape[1]), np.float32)
        luminous = np.einsum("cb,b->c", columns.summed, luminous_weights(scene.bands))
        brightness = luminous + EQUAL_ENERGY_WEIGHT * columns.summed.sum(axis=1)
        # Only ratios matter, and squares of very strong or weak light would leave single precision.
        brightness /= brightness.max(initial=np.finfo(float).tiny)
        weight = columns.padded(brightness)
        return cls(
            emission=emission,
            reflectance=reflectance,
            glow=glow,
            exitance=exitance,
            brightness=weight.astype(np.float64),
            sky=sky,
            emission_on_device=device.upload(emission if len(emission) else dark),
            reflectance_on_device=device.upload(reflectance[glow.material]),
            weight_on_device=device.upload(weight),
            sky_on_device=device.upload(sky),
            exitance_on_device=device.upload(exitance) if glow.shines else None,
        )
