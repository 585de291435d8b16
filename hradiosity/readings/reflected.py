"""Reflected light at many points that lie side by side: the same paths for the light of all replicates.

Readings have paths of their own in every replicate, guides, and a pilot that shares them out, which takes longer than
the some hundred paths that a point of a map needs. The noise of a set falls with the power of 0.6 of its number, since
its paths are evenly spread: few large sets are better than many small ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.estimate import student_quantile
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.spectrum import Bands
from hradiosity.readings.path_tracing import (
    PathRules,
    PathSamples,
    Points,
    changed_light,
    reflected_light,
    trace_paths,
    upload_points,
)
from hradiosity.readings.sensors import BATCH_PATHS
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.solution import ReflectedLux
from hradiosity.space.hierarchy import LONG
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

SETS = 2
"""Independent sets of paths, whose difference tells their noise; and of replicates, for that of the solution."""


@dataclass(frozen=True)
class MeanLight:
    """The light of several replicates on the same elements.

    halves : the mean of every other one of them, of the first and of the second
    changes : by part of the intervals, (n_rows, 8 n_groups) on the device: mean change by companions
    replicates : in all
    """

    halves: tuple[SurfaceLight, SurfaceLight]
    changes: dict[str, DeviceArray]
    replicates: int


def mean_light(device: Device, lights: Sequence[SurfaceLight]) -> MeanLight:
    """The mean light of two replicates or more; all but the mean is that of the first one."""
    halves = [_mean(device, [light.reflected for light in lights[first::SETS]]) for first in range(SETS)]
    changed: dict[str, list[DeviceArray]] = {}
    for light in lights:
        if light.change is not None:
            changed.setdefault(light.changed_by, []).append(light.change)
    first, second = (replace(lights[0], reflected=half, change=None) for half in halves)
    changes = {part: _mean(device, found) for part, found in changed.items()}
    return MeanLight((first, second), changes, len(lights))


def _mean(device: Device, arrays: Sequence[DeviceArray]) -> DeviceArray:
    mean = np.mean([device.fetch(array).astype(np.float64) for array in arrays], axis=0)
    return device.upload(mean, np.float32)


def reflected_lux(
    scene: DeviceScene,
    elements: DeviceElements,
    light: MeanLight,
    bands: Bands,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    n_paths: int,
    *,
    rules: PathRules,
    seed: int,
) -> ReflectedLux:
    """Illuminance at points but for what comes straight from emitters that shadow rays go to.

    Parameters
    ----------
    light : MeanLight
        On these elements.
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    n_paths : int
        From each point, both sets together.
    rules : PathRules
    seed : int
    """
    n, columns = len(position), light.halves[0].columns
    weights = columns.to_bands(np.eye(columns.n_columns)) @ luminous_weights(bands)
    each = max(1, n_paths // SETS)
    lux, unrelated = np.zeros((SETS, SETS, n)), np.zeros(n)
    changes = {part: np.zeros(n) for part in light.changes}
    size = max(1, BATCH_PATHS // each)
    for first in range(0, n, size):
        part = slice(first, min(first + size, n))
        points = upload_points(scene, position[part], normal[part])
        for number in range(SETS):
            own = (seed + 0x9E3779B1 * (number + 1) + first) & 0xFFFFFFFF
            traced = _traced(scene, elements, light.halves[0], points, each, own, rules)
            for half, its_light in enumerate(light.halves):
                spectra, moments = _summed(reflected_light(scene, some, its_light) for some in traced)
                lux[number, half, part] = _lux(spectra, weights)
                unrelated[part] += _relative_variance(moments, each) / SETS**2
            for name, change in light.changes.items():
                found = np.sum([changed_light(scene, some, light.halves[0], change) for some in traced], axis=0)
                changes[name][part] += _lux(found, weights) / SETS
    mean = lux.mean(axis=(0, 1))
    noise = shared_spread(lux.mean(axis=1), mean**2 * unrelated / (SETS * each))
    spread = shared_spread(lux.mean(axis=0), mean**2)
    sampling = student_quantile(0.95, light.replicates - 1) * np.hypot(noise, spread)
    squares = sampling**2 + np.sum([change**2 for change in changes.values()], axis=0)
    return ReflectedLux(mean, noise, np.sqrt(squares))


def _traced(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    points: Points,
    n_paths: int,
    seed: int,
    rules: PathRules,
) -> list[PathSamples]:
    """Paths from points; those that meet many hits once more, with room for them."""
    paths = trace_paths(scene, elements, light, points, n_paths, seed, rules)
    long = np.flatnonzero(scene.device.fetch(paths.row) == LONG)
    if not len(long):
        return [paths]
    return [paths, trace_paths(scene, elements, light, points, n_paths, seed, rules, only=long, last_chance=True)]


def _summed(
    parts: Iterable[tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sums of the first and of the second of pairs."""
    first, second = zip(*parts, strict=True)
    return np.sum(first, axis=0), np.sum(second, axis=0)


def _lux(columns: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) illuminance of (n, 8 n_groups) columns."""
    found: NDArray[np.float64] = np.einsum("xc,c->x", columns[:, : len(weights)], weights)
    return found


def _relative_variance(sums: NDArray[np.float64], n_paths: int) -> NDArray[np.float64]:
    """(n,) variance of the brightness of a path over the square of its mean, from sums (n, 2) of it and its square."""
    mean, square = sums[:, 0] / n_paths, sums[:, 1] / n_paths
    found: NDArray[np.float64] = np.divide(square, mean**2, out=np.ones_like(mean), where=mean > 0.0) - 1.0
    return np.maximum(found, 0.0)


def shared_spread(estimates: NDArray[np.float64], likely: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) standard error of the mean of independent estimates (m, n), whose variances are in proportion to `likely`.

    Two estimates tell next to nothing of one point, but thousands of points tell the factor that all have in common:
    of paths, how much better than by chance they are spread.
    """
    actual = float((estimates.var(axis=0, ddof=1) / len(estimates)).sum())
    expected = float(likely.sum())
    found: NDArray[np.float64] = np.sqrt(likely * (actual / expected if expected > 0.0 else 0.0))
    return found
