"""Light at single points: direct light there, and short paths that look the solution up where they end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.effort import Effort
from hradiosity.readings.guide import DeviceGuides
from hradiosity.readings.path_tracing import (
    LIT_HITS,
    PathRules,
    PathSamples,
    Points,
    changed_light,
    reflected_light,
    room_for,
    trace_paths,
    upload_points,
)
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.space.hierarchy import COVERED, LONG, NONE
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_at_points

BATCH_PATHS = 1 << 22
"""Paths kept on the device at a time, fewer of those that look the solution up late."""


@dataclass(frozen=True)
class ReadingSamples:
    """Readings of one replicate.

    irradiance : (n_points, n_columns) float64, in the units of each column
    enclosed : (n_points,) float64, share of paths that began inside a solid
    change : (n_points, n_columns) float64, what a companion with coarser settings would add; None without one
    changed_by : see `SurfaceLight`
    some_row : (n_points,) int64, a row element that paths ended on; −1 where all ended elsewhere
    """

    irradiance: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    change: NDArray[np.float64] | None
    changed_by: str
    some_row: NDArray[np.int64]


def read_points(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    effort: Effort,
    *,
    rules: PathRules,
    seed: int,
    response: NDArray[np.float32] | None = None,
) -> ReadingSamples:
    """Irradiance at points: E = D + ⟨ρ(y₁) (D(y₁) + ρ(y₂) (D(y₂) + …))⟩ over cosine-distributed directions.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    effort : Effort
        No paths leave reflected light out.
    rules : PathRules
        But for lookups, which are the effort's.
    response : (n, 12) float32, optional
        How directions weigh, see `hradiosity.model.sensor_kinds`.
    """
    n = len(position)
    used = light.columns.n_columns
    emission = light.emission[:, :used]
    direct = direct_at_points(scene, position, normal, effort.light, seed, response=response, seen=effort.seen)
    irradiance = np.einsum("xe,ec->xc", direct.astype(np.float64), emission)
    enclosed, some_row = np.zeros(n), np.full(n, -1)
    change = np.zeros((n, used))
    for part, count, lookup in _batches(effort):
        batch_seed = (seed + int(part[0])) & 0xFFFFFFFF
        points = upload_points(scene, position[part], normal[part], None if response is None else response[part])
        guide = effort.guide.some(part).upload(scene.device)
        its_rules = replace(rules, lookup=lookup)
        gathered = _gather(scene, elements, light, points, count, batch_seed, its_rules, guide)
        irradiance[part] += gathered.irradiance[:, :used]
        enclosed[part], some_row[part] = gathered.enclosed, gathered.some_row
        if gathered.change is not None:
            change[part] = gathered.change[:, :used]
    return ReadingSamples(irradiance, enclosed, None if light.change is None else change, light.changed_by, some_row)


def _gather(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    points: Points,
    count: int,
    seed: int,
    rules: PathRules,
    guide: DeviceGuides | None,
) -> ReadingSamples:
    """Reflected light by `count` paths each; arrays with (n_points, 8 n_groups) columns."""
    paths = trace_paths(scene, elements, light, points, count, seed, rules, guide=guide)
    traced = [paths]
    row = scene.device.fetch(paths.row).reshape(points.n, count)
    some_row = _row_or_none(row).max(axis=1)
    long = np.flatnonzero(row == LONG)
    if len(long):
        more = trace_paths(scene, elements, light, points, count, seed, rules, guide=guide, only=long, last_chance=True)
        np.maximum.at(some_row, long // count, _row_or_none(scene.device.fetch(more.row)))
        traced.append(more)
    change = light.change
    return ReadingSamples(
        irradiance=np.sum([reflected_light(scene, some, light)[0] for some in traced], axis=0),
        enclosed=_enclosed(scene, paths, row),
        change=None
        if change is None
        else np.sum([changed_light(scene, some, light, change) for some in traced], axis=0),
        changed_by=light.changed_by,
        some_row=some_row,
    )


def _row_or_none(row: NDArray[np.uint32]) -> NDArray[np.int64]:
    """Numbers of row elements; −1 for other outcomes."""
    return np.where(row < LONG, row.astype(np.int64), -1)


def _enclosed(scene: DeviceScene, paths: PathSamples, row: NDArray[np.uint32]) -> NDArray[np.float64]:
    """(n_points,) share of the paths that began inside a solid."""
    if not (row == COVERED).any():
        return np.zeros(len(row))
    first_hit = scene.device.fetch(paths.paint)[:, 0].reshape(row.shape)
    return np.asarray(((first_hit == NONE) & (row == COVERED)).mean(axis=1))


def _batches(effort: Effort) -> Iterator[tuple[NDArray[np.int64], int, int]]:
    """Points with one number of paths and one lookup each, few enough at a time for the device."""
    kinds = np.column_stack([effort.gather, effort.lookup])
    for count, lookup in np.unique(kinds[effort.gather > 0], axis=0):
        points = np.flatnonzero((effort.gather == count) & (effort.lookup == lookup))
        size = max(1, BATCH_PATHS * LIT_HITS // (room_for(int(lookup)) * int(count)))
        for first in range(0, len(points), size):
            yield points[first : first + size], int(count), int(lookup)
