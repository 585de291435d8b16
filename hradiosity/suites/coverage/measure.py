"""Solves scenes with many seeds and keeps their numbers beside the true ones."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import Estimate
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.readings.numbers import OF_SENSORS
from hradiosity.solution import Readings
from hradiosity.suites.compare import counted_bands
from hradiosity.suites.coverage.scenes import CoverageScene
from hradiosity.suites.coverage.truth import Truth, truth_of

FIXED_SCALE = {"chromaticity": 1.0, "duv": 1.0}
"""What errors of numbers are relative to that have no zero of their own; those of others are so to the true value."""
INDEX = re.compile(r"r[afg]|r\d+")
"""Names of indices, whose errors are relative to 100."""
DARK = 0.05
"""Errors of readings that are darker than this share of the mean of their sensor are relative to that."""


@dataclass(frozen=True)
class Numbers:
    """All numbers of one kind in a scene that have a true value.

    name : of the kind
    truth, truth_error : (n,) float64, true values and their standard errors
    scale : (n,) float64, what errors are relative to
    estimates : of each seed, arrays (n,)
    reading : (n,) int64, which reading each belongs to; -1 for those of whole sensors
    """

    name: str
    truth: NDArray[np.float64]
    truth_error: NDArray[np.float64]
    scale: NDArray[np.float64]
    estimates: tuple[Estimate, ...]
    reading: NDArray[np.int64]


@dataclass(frozen=True)
class SceneNumbers:
    """What all seeds found in one scene.

    replicates, cpu_seconds : mean over the seeds
    """

    wanted: CoverageScene
    scene: Scene
    kinds: Mapping[str, Numbers]
    replicates: float
    cpu_seconds: float


def measure(
    wanted: CoverageScene, options: Options, seeds: Sequence[int], device: Device, cache: Path | None
) -> SceneNumbers:
    """Solve one scene with each seed.

    Parameters
    ----------
    options : Options
        Its seed is not used.
    cache : Path, optional
        Folder that keeps unbiased readings.
    """
    scene = wanted.load()
    truth = truth_of(wanted, scene, device, cache)
    found, replicates, cpu = [], [], []
    for seed in seeds:
        solver = make_solver(scene, replace(options, seed=seed), device)
        for _ in solver.states():
            pass
        found.append(estimates_of(solver.solution().readings, scene))
        replicates.append(solver.replicates)
        cpu.append(solver.cpu_seconds)
    kinds = {name: _numbers(name, scene, truth, [run[name] for run in found]) for name in found[0]}
    return SceneNumbers(wanted, scene, kinds, float(np.mean(replicates)), float(np.mean(cpu)))


def measure_all(
    scenes: Sequence[CoverageScene], options: Options, seeds: Sequence[int], device: Device, cache: Path | None
) -> Iterator[SceneNumbers]:
    """One scene after another."""
    for wanted in scenes:
        yield measure(wanted, options, seeds, device, cache)


def estimates_of(readings: Mapping[str, Readings], scene: Scene) -> dict[str, Estimate]:
    """Every kind of number of all sensors, one after another."""
    of_sensors = [readings[sensor.name].numbers for sensor in scene.sensors]
    return {name: _joined([numbers[name] for numbers in of_sensors]) for name in of_sensors[0]}


def _joined(estimates: Sequence[Estimate]) -> Estimate:
    def together(arrays: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        return np.concatenate([np.atleast_1d(array) for array in arrays])

    return replace(
        estimates[0],
        value=together([e.value for e in estimates]),
        standard_error=together([e.standard_error for e in estimates]),
        others={part: together([e.others[part] for e in estimates]) for part in estimates[0].others},
    )


def _numbers(name: str, scene: Scene, truth: Truth, found: Sequence[Estimate]) -> Numbers:
    """Those of one kind that count: with light, in bands with light, of sensors with several readings."""
    value = truth.values[name]
    counts = np.isfinite(value) & (value != 0.0)
    size = np.array([sensor.n_readings for sensor in scene.sensors])
    if name in OF_SENSORS:
        counts &= size > 1
    elif name == "irradiance":
        counts &= counted_bands(value)
    reading = np.arange(len(value)).reshape(-1, *[1] * (value.ndim - 1)) if name not in OF_SENSORS else np.array(-1)
    return Numbers(
        name=name,
        truth=value[counts],
        truth_error=truth.errors[name][counts],
        scale=_scale(name, value, size)[counts],
        estimates=tuple(_counted(estimate, counts) for estimate in found),
        reading=np.broadcast_to(reading, value.shape)[counts],
    )


def _scale(name: str, value: NDArray[np.float64], size: NDArray[np.int64]) -> NDArray[np.float64]:
    if INDEX.fullmatch(name):
        return np.full_like(value, 100.0)
    if name in FIXED_SCALE:
        return np.full_like(value, FIXED_SCALE[name])
    if name in OF_SENSORS:
        return np.abs(value)
    ends = np.cumsum(size)[:-1]
    means = [np.broadcast_to(part.mean(axis=0), part.shape) for part in np.split(value, ends)]
    scale: NDArray[np.float64] = np.maximum(np.abs(value), DARK * np.abs(np.concatenate(means)))
    return scale


def _counted(estimate: Estimate, counts: NDArray[np.bool_]) -> Estimate:
    return replace(
        estimate,
        value=estimate.value[counts],
        standard_error=estimate.standard_error[counts],
        others={part: array[counts] for part, array in estimate.others.items()},
    )
