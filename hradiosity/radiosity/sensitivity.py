"""How much readings change with each reflectance and each lamp, which intervals do not cover.

One run for all readings and parameters, by tangents: each material a little lighter, each lamp off, as variants of one
scene that are solved with the same rays, so that their noise cancels. An adjoint solution would take a run for each
reading.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import Estimate
from hradiosity.model.scene import Scene, Variant
from hradiosity.model.variants import Factor, make_variant
from hradiosity.options import Options
from hradiosity.radiosity.photopic_bands import in_photopic_bands
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.state import State
from hradiosity.solution import VariantReadings

STEP: Final = 0.01
"""Relative change of a reflectance. See `_from_step` for why no smaller one is needed."""
HIGHEST: Final = 0.999
"""Reflectances that would be above this are made darker instead."""
AT_ONCE: Final = 24
"""Parameters that are solved together; more take several runs with the same rays."""
ELEMENTS, REPLICATES = 1000, 4
"""Less than a draft has: noise and mesh error are largely the same with the step and without."""
TOLERANCE: Final = 1e-5


@dataclass(frozen=True)
class Parameter:
    """Something that a scene states: the reflectance of a material, the flux of a luminaire, the light of the sky."""

    kind: Literal["reflectance", "flux", "sky"]
    name: str


@dataclass(frozen=True)
class Sensitivity:
    """Relative change of illuminance over that of one parameter: S = (ρ/E) ∂E/∂ρ, or (Φ/E) ∂E/∂Φ.

    A parameter that is off by 2 % changes a reading by 2 % · S. NaN where the scene gives no light.

    value, half_width : (n,) float64, of each reading of a sensor, and of its 95 % interval
    mean, mean_half_width : of the sensor's mean illuminance
    """

    value: NDArray[np.float64]
    half_width: NDArray[np.float64]
    mean: float
    mean_half_width: float


Sensitivities = Mapping[str, Mapping[Parameter, Sensitivity]]
"""By sensor name and parameter."""


def sensitivities(scene: Scene, options: Options | None = None, device: Device | None = None) -> Sensitivities:
    """Sensitivities of all readings to all reflectances and lamps.

    Parameters
    ----------
    scene : Scene
    options : Options, optional
        Their seed and forced effects count; elements and samples are few, which is enough for rates of change.
    device : Device, optional
    """
    run = SensitivityRun(scene, options or Options(), device or Device())
    for _ in run.states():
        pass
    return run.found()


class SensitivityRun:
    """The same, to be followed state by state.

    Parameters
    ----------
    scene : Scene
    options : Options
    device : Device

    Attributes
    ----------
    done, count : parameters that are done, and all of them
    """

    def __init__(self, scene: Scene, options: Options, device: Device) -> None:
        self._scene = in_photopic_bands(scene)
        self._device = device
        self._options = Options(
            elements=ELEMENTS,
            light_points=8,
            light_samples=512,
            gather_samples=1024,
            replicates=REPLICATES,
            tolerance=TOLERANCE,
            seed=options.seed,
            occlusion=options.occlusion,
            interreflection=options.interreflection,
            glow=options.glow,
        )
        used = np.unique(scene.patches.material)
        painted = [self._scene.materials[i] for i in used]
        self._steps = {m.name: STEP if (1.0 + STEP) * m.reflectance.max() <= HIGHEST else -STEP for m in painted}
        self._parameters = [
            *(Parameter("reflectance", m.name) for m in painted if m.reflectance.any()),
            *(Parameter("flux", lamp.name) for lamp in scene.luminaires),
            *([Parameter("sky", "sky")] if scene.sky is not None else []),
        ]
        self._found: dict[str, dict[Parameter, Sensitivity]] = {sensor.name: {} for sensor in scene.sensors}
        self.done, self.count = 0, len(self._parameters)

    def states(self) -> Iterator[State]:
        """Run, yielding after each stage."""
        for first in range(0, len(self._parameters), AT_ONCE):
            batch = self._parameters[first : first + AT_ONCE]
            variants = tuple(self._variant(first + k, parameter) for k, parameter in enumerate(batch))
            solver = RadiositySolver(replace(self._scene, variants=variants), self._options, self._device)
            yield from solver.states()
            solved = solver.solution().variants
            for variant, parameter in zip(variants, batch, strict=True):
                self._take(parameter, solved[variant.name])
            self.done += len(batch)

    def found(self) -> Sensitivities:
        """What is known so far."""
        return self._found

    def _variant(self, number: int, parameter: Parameter) -> Variant:
        scene, name = self._scene, str(number)
        if parameter.kind == "reflectance":
            return make_variant(scene, name, materials={parameter.name: Factor(1.0 + self._steps[parameter.name])})
        is_sky = parameter.kind == "sky"
        off = {lamp.name: Factor(0.0) for lamp in scene.luminaires if is_sky or lamp.name == parameter.name}
        return make_variant(scene, name, luminaires=off)

    def _take(self, parameter: Parameter, solved: VariantReadings) -> None:
        for sensor, differences in solved.differences.items():
            each, mean = (
                self._sensitivity(parameter, differences.numbers[f"relative_{name}"])
                for name in ("illuminance", "mean_illuminance")
            )
            self._found[sensor][parameter] = Sensitivity(*each, *(float(number) for number in mean))

    def _sensitivity(self, parameter: Parameter, change: Estimate) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Value and half width."""
        if parameter.kind == "flux":
            # Light is linear in what each lamp sends out: without it, just its share is missing.
            return -change.value, change.half_width
        if parameter.kind == "sky":
            return 1.0 + change.value, change.half_width
        return _from_step(change, self._steps[parameter.name])


def _from_step(change: Estimate, step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sensitivity and half width from the relative change E₁/E₀ − 1 that a step of a reflectance makes.

    (1 − E₀/E₁) / step is exact where light goes to and fro, E = c / (1 − kρ), which is where sensitivities are large;
    where light is reflected once, E = a + bρ, it is off by S · step of itself, and S is below 1 there.
    """
    larger = 1.0 + change.value
    return (1.0 - 1.0 / larger) / step, change.half_width / (larger**2 * abs(step))
