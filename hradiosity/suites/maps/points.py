"""Points spread evenly over patch sides, and the unbiased light there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import BACK
from hradiosity.model.scene import Scene, Sensor
from hradiosity.radiosity.referee import RefereeState
from hradiosity.suites.referee_cache import referee_samples

_PLASTIC = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps along u and v of an even sequence of points (Roberts' generalised golden ratio in two dimensions)."""
_LEVEL = 1e-3
"""Of the scene's height: what lies that close to its lowest part is the floor."""
_INSIDE = 0.5
"""A point more of whose view ends inside solids lies under one of them."""


@dataclass(frozen=True)
class MapPoints:
    """Where a map is looked at, each point for the same area.

    side : (n,) int64, 2 · patch + side
    u, v : (n,) float32, along the edges of the patch
    position, normal : (n, 3) float64 [m], [1]
    """

    side: NDArray[np.int64]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    position: NDArray[np.float64]
    normal: NDArray[np.float64]


@dataclass(frozen=True)
class MapTruth:
    """Unbiased illuminance at the points.

    points : those of them that are not inside of something
    lux : (n,) float64
    noise : (n,) float64, standard error of `lux`
    paths : from each point
    """

    points: MapPoints
    lux: NDArray[np.float64]
    noise: NDArray[np.float64]
    paths: int


def floor_sides(scene: Scene, lit: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lit sides that look up from the lowest level of the scene.

    Parameters
    ----------
    scene : Scene
    lit : (n_sides,) bool
    """
    patches = scene.patches
    low, high = (bound[2] for bound in patches.bounds())
    level = patches.corners()[:, :, 2].max(axis=1) < low + _LEVEL * max(high - low, 1e-300)
    up = np.where(np.arange(2) == BACK, -1.0, 1.0) * patches.normal[:, 2:]
    floor: NDArray[np.int64] = np.flatnonzero((level[:, None] & (up > 0.99)).ravel() & lit)
    return floor


def spread_points(scene: Scene, sides: NDArray[np.int64], count: int) -> MapPoints:
    """About `count` points, as many on each side as its area asks for.

    Raises
    ------
    ValueError
        When there is no side.
    """
    if not len(sides):
        raise ValueError(f"{scene.name}: no side to draw a map of")
    patches = scene.patches
    until = np.cumsum(patches.area[sides // 2])
    place = (np.arange(count) + 0.5) / count * until[-1]
    side = sides[np.minimum(np.searchsorted(until, place), len(sides) - 1)]
    patch = side // 2
    u, v = ((0.5 + np.arange(1, count + 1)[:, None] * _PLASTIC) % 1.0).T
    over = patches.is_triangle[patch] & (u + v > 1.0)
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    position = patches.origin[patch] + u[:, None] * patches.edge_u[patch] + v[:, None] * patches.edge_v[patch]
    normal = patches.normal[patch] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
    return MapPoints(side, u.astype(np.float32), v.astype(np.float32), position, normal)


def unbiased_map(
    scene: Scene,
    device: Device,
    points: MapPoints,
    paths: int,
    *,
    cache: Path | None = None,
    progress: Callable[[RefereeState], None] | None = None,
) -> MapTruth:
    """Illuminance by unbiased paths; parameters as those of `referee_samples`."""
    asked = replace(scene, sensors=(Sensor("map", points.position, points.normal),), variants=())
    samples = referee_samples(asked, device, paths, cache=cache, progress=progress)
    lux = np.einsum("spb,b->sp", samples.per_scramble, luminous_weights(scene.bands))
    free = samples.enclosed < _INSIDE
    kept = MapPoints(*(getattr(points, name)[free] for name in ("side", "u", "v", "position", "normal")))
    noise = lux.std(axis=0, ddof=1) / np.sqrt(len(lux))
    return MapTruth(kept, lux.mean(axis=0)[free], noise[free], samples.paths)
