"""What is true, and how well that is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.model.scene import Scene
from hradiosity.readings.composition import Composition
from hradiosity.readings.interval import RunningMoments
from hradiosity.readings.numbers import ReadingNumbers
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.suites.coverage.scenes import CoverageScene
from hradiosity.suites.referee_cache import referee_samples, scene_digest

SEED = 0xC07E4
"""Of the unbiased paths: far from those of the runs that are compared with them."""


@dataclass(frozen=True)
class Truth:
    """The numbers of all readings, as `ReadingNumbers.of` names and shapes them.

    values : by name
    errors : standard errors, by name
    """

    values: Mapping[str, NDArray[np.float64]]
    errors: Mapping[str, NDArray[np.float64]]

    @staticmethod
    def quantile(level: float) -> float:
        """Half width of the truth's own interval over its standard error."""
        return student_quantile(level, SCRAMBLES - 1)


def truth_of(wanted: CoverageScene, scene: Scene, device: Device, cache: Path | None) -> Truth:
    """Exact where that is known, else by unbiased paths, which are kept in the folder `cache`."""
    numbers = ReadingNumbers(scene.sensors, scene.bands)
    if wanted.exact is not None:
        spectra, uncertain = wanted.exact(scene)
        values, off = numbers.of(spectra), numbers.of(spectra + uncertain)
        return Truth(values, {name: np.abs(off[name] - value) for name, value in values.items()})
    if cache is not None:
        cache.mkdir(parents=True, exist_ok=True)
    file = cache / f"{wanted.name}_{scene_digest(scene)[:16]}.npz" if cache is not None else None
    samples = referee_samples(scene, device, wanted.paths, seed=SEED, cache=file)
    planes = Composition(scene.sensors, scene)
    values = numbers.of(planes.readings(samples.irradiance))
    moments = {name: RunningMoments(value.shape) for name, value in values.items()}
    for spectra in samples.per_scramble:
        for name, value in numbers.of(planes.readings(spectra)).items():
            moments[name].add(value)
    return Truth(values, {name: spread.standard_error for name, spread in moments.items()})
