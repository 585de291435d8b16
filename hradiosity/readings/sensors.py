"""Light at single points: direct light there, and short paths that look the solution up where they end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.estimate import MESH
from hradiosity.plan import SpectralColumns
from hradiosity.space.hierarchy import COVERED, LONG, NONE
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.direct import direct_at_points

UNIFORM_SHARE = 0.1
"""Part of the probability with which an emitter is drawn at a hit that does not depend on the solution."""
BATCH_PATHS = 1 << 22
"""Paths kept on the device at a time."""
SUMMED_PATHS = 1024
"""Paths that one work-item sums in single precision."""
LIT_HITS, MOST_LIT_HITS = 2, 32
"""Hits of a path that may be lit explicitly: of most paths, and of the few that come into corners, contacts, slots."""


@dataclass(frozen=True)
class PathSamples:
    """What the paths of a batch of readings met; band-free, so another lamp or paint needs no new ray.

    paint, emitter : (n_paths, lit_hits) uint32 on the device: paint at each hit that is lit explicitly
        (0xFFFFFFFF for none), emitter drawn there
    gain : (n_paths, lit_hits) float32 on the device: irradiance at that hit for unit emission of that emitter,
        over the probability that it was drawn
    row : (n_paths,) uint32 on the device: row element, or an outcome, where the path ends
    weight : (n_paths,) float32 on the device: 1 over the density with which its first direction was drawn
    start : (n_points + 1,) uint32, first path of each point; its paths follow one another
    n_samples : paths that each point's mean is over
    """

    paint: DeviceArray
    emitter: DeviceArray
    gain: DeviceArray
    row: DeviceArray
    weight: DeviceArray
    start: NDArray[np.uint32]
    lit_hits: int
    n_samples: int

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.start) - 1


@dataclass(frozen=True)
class PathRules:
    """Where paths end.

    lookup : number of the first hit at which the solution may be looked up
    near_factor : it never is at a hit nearer than so many sizes of its element
    """

    lookup: int = 3
    near_factor: float = 0.5


@dataclass(frozen=True)
class Points:
    """Places on the device: position (n, 3) float32 in the ray structure's frame [m], normal (n, 3) float32 unit."""

    position: DeviceArray
    normal: DeviceArray
    n: int


def upload_points(scene: DeviceScene, position: NDArray[np.float64], normal: NDArray[np.float64]) -> Points:
    """Points of the world frame [m] with unit normals."""
    device = scene.device
    return Points(device.upload(scene.bvh.to_local(position)), device.upload(normal, np.float32), len(position))


@dataclass(frozen=True)
class SurfaceLight:
    """The solution as paths look it up.

    reflectance : (n_paints, 8 n_groups) float32 on the device, see `hradiosity.transport.glow.Glow`
    glow : (n_paints, 8 n_groups) float32 on the device, exitance of paints that shine; None if none does
    emission : (n_emitters, 8 n_groups) float32, exitance or intensity of each emitter; and the same on the device
    reflected : (n_rows, 8 n_groups) float32 on the device, ρE of each row element, and its glow
    row_size : (n_rows,) float32 on the device, edge of each element [m]; infinite for those that were found wholly
        covered and thus have no light to look up, below 0 where it may be looked up at the first hit already
    sky : (8 n_groups,) float32 on the device, π · radiance
    emitter_choice : (n_rows, n_emitters) float32 on the device, summed probability of drawing an emitter
    row_direct : (n_rows, n_emitters) float32 on the device, direct light of each element for unit emission
    weight : (8 n_groups,) float32 on the device, brightness of a unit of each column
    row_space : (n_rows,) int32, connected space that each element looks into
    change : (n_rows, 8 n_groups) float32 on the device, what a companion with coarser settings would add to
        `reflected`; None where there is none
    changed_by : part of the intervals that the change tells about, "mesh" or "exchange"
    """

    columns: SpectralColumns
    reflectance: DeviceArray
    glow: DeviceArray | None
    emission: NDArray[np.float32]
    emission_on_device: DeviceArray
    reflected: DeviceArray
    row_size: DeviceArray
    sky: DeviceArray
    emitter_choice: DeviceArray
    row_direct: DeviceArray
    weight: DeviceArray
    row_space: NDArray[np.int32]
    change: DeviceArray | None = None
    changed_by: str = MESH


def emitter_choice(direct: NDArray[np.float32], emission: NDArray[np.float32]) -> NDArray[np.float32]:
    """Summed probabilities of drawing each emitter at a hit, in proportion to the light it sends to that element.

    Parameters
    ----------
    direct : (n_rows, n_emitters) float32
        Irradiance of each element for unit emission; estimates below 0 count as 0.
    emission : (n_emitters, n_columns) float32

    Returns
    -------
    (n_rows, n_emitters) float32
        Ascending; a tenth of the probability is shared evenly, so that no emitter is ever left out, and the last
        entry is above 1.
    """
    n = direct.shape[1]
    if n == 0:
        return np.zeros((len(direct), 0), np.float32)
    light = np.maximum(direct, 0.0) * emission.mean(axis=1, dtype=np.float64)[None, :]
    total = light.sum(axis=1, keepdims=True)
    share = np.divide(light, total, out=np.full(light.shape, 1.0 / n), where=total > 0.0)
    sums = np.cumsum((1.0 - UNIFORM_SHARE) * share + UNIFORM_SHARE / n, axis=1).astype(np.float32)
    sums[:, -1] = 1.0
    return sums


def trace_paths(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    points: Points,
    n_samples: int,
    seed: int,
    rules: PathRules,
    *,
    guide: DeviceArray | None = None,
    only: NDArray[np.int64] | None = None,
    last_chance: bool = False,
) -> PathSamples:
    """Trace `n_samples` paths from each point, or those of them whose numbers are in `only` with room for more hits.

    A path that meets more hits than it has room for is left out and marked LONG; with `last_chance` it looks the
    solution up at the last of them instead. First directions follow the `guide`, tables of
    `hradiosity.readings.guide` on the device, if there is one.
    """
    device = scene.device
    number = np.arange(points.n * n_samples, dtype=np.uint32) if only is None else only.astype(np.uint32)
    lit_hits = LIT_HITS if only is None else MOST_LIT_HITS
    paint, emitter = (device.empty((len(number), lit_hits), np.uint32) for _ in range(2))
    gain = device.empty((len(number), lit_hits), np.float32)
    row = device.empty((len(number),), np.uint32)
    weight = device.empty((len(number),), np.float32)
    device.kernel("paths", "trace_paths", HR_LIT_HITS=lit_hits, HR_GUIDED=int(guide is not None))(
        len(number),
        **scene.geometry,
        **elements.cells,
        **scene.emitters,
        position=points.position,
        normal=points.normal,
        patch_solid=scene.solid,
        side_paint=elements.side_paint,
        row_size=light.row_size,
        emitter_choice=light.emitter_choice,
        row_direct=light.row_direct,
        row_sight=elements.sight(scene),
        guide=light.weight if guide is None else guide,
        path_number=device.upload(number),
        path_paint=paint,
        path_emitter=emitter,
        path_gain=gain,
        path_row=row,
        path_weight=weight,
        n_samples=n_samples,
        n_emitters=scene.n_emitters,
        occlusion=int(scene.occlusion),
        lookup=rules.lookup,
        near_factor=rules.near_factor,
        last_chance=int(last_chance),
        seed=seed,
        scale=scene.scale,
    )
    start = np.searchsorted(number, np.arange(points.n + 1, dtype=np.int64) * n_samples).astype(np.uint32)
    return PathSamples(paint, emitter, gain, row, weight, start, lit_hits, n_samples)


def reflected_light(
    scene: DeviceScene, paths: PathSamples, light: SurfaceLight
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the paths bring, sky seen directly included.

    Returns
    -------
    irradiance : (n_points, 8 n_groups) float64
    brightness : (n_points, 2) float64
        Sums of each path's brightness (`SurfaceLight.weight` times its spectrum) and of its square.
    """
    device = scene.device
    groups = light.columns.n_groups
    batch, of_point = _summed_batches(paths.start)
    n_batches = len(batch) - 1
    irradiance = device.empty((n_batches, 8 * groups), np.float32)
    brightness = device.empty((n_batches, 2), np.float32)
    device.kernel(
        "path_sums", "sum_paths", HR_GROUPS=groups, HR_LIT_HITS=paths.lit_hits, HR_GLOW=int(light.glow is not None)
    )(
        n_batches,
        path_start=device.upload(batch),
        path_paint=paths.paint,
        path_emitter=paths.emitter,
        path_gain=paths.gain,
        path_row=paths.row,
        path_weight=paths.weight,
        reflectance=light.reflectance,
        glow=light.reflectance if light.glow is None else light.glow,
        emission=light.emission_on_device,
        reflected=light.reflected,
        sky=light.sky,
        weight=light.weight,
        irradiance=irradiance,
        brightness=brightness,
    )
    sums, squares = (device.fetch(part).astype(np.float64) for part in (irradiance, brightness))
    return np.add.reduceat(sums, of_point) / paths.n_samples, np.add.reduceat(squares, of_point)


def changed_light(
    scene: DeviceScene, paths: PathSamples, light: SurfaceLight, change: DeviceArray
) -> NDArray[np.float64]:
    """(n_points, 8 n_groups) irradiance that `change`, (n_rows, 8 n_groups) on the device, adds where paths end."""
    device = scene.device
    groups = light.columns.n_groups
    batch, of_point = _summed_batches(paths.start)
    irradiance = device.empty((len(batch) - 1, 8 * groups), np.float32)
    device.kernel("path_sums", "sum_lookups", HR_GROUPS=groups, HR_LIT_HITS=paths.lit_hits)(
        len(batch) - 1,
        path_start=device.upload(batch),
        path_paint=paths.paint,
        path_row=paths.row,
        path_weight=paths.weight,
        reflectance=light.reflectance,
        change=change,
        irradiance=irradiance,
    )
    return np.add.reduceat(device.fetch(irradiance).astype(np.float64), of_point) / paths.n_samples


def _summed_batches(start: NDArray[np.uint32]) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Paths cut into batches that belong to one point: first path of each batch and the end, first batch of each point.

    Each point has one batch at least, so that points without paths sum to 0.
    """
    counts = np.diff(start.astype(np.int64))
    batches = np.maximum(-(-counts // SUMMED_PATHS), 1)
    of_point = np.cumsum(batches) - batches
    number = np.arange(int(batches.sum())) - np.repeat(of_point, batches)
    first = np.repeat(start[:-1].astype(np.int64), batches) + SUMMED_PATHS * number
    return np.append(first, start[-1]).astype(np.uint32), of_point


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
    *,
    light_samples: NDArray[np.int64],
    gather_samples: NDArray[np.int64],
    rules: PathRules,
    seed: int,
    guide: NDArray[np.float32] | None = None,
) -> ReadingSamples:
    """Irradiance at points: E = D + ⟨ρ(y₁) (D(y₁) + ρ(y₂) (D(y₂) + …))⟩ over cosine-distributed directions.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    light_samples : (n,) int64
        Shadow rays to each emitter.
    gather_samples : (n,) int64
        Paths; 0 leaves reflected light out.
    rules : PathRules
    guide : (n, entries) float32, optional
        Tables of `hradiosity.readings.guide`.
    """
    n = len(position)
    used = light.columns.n_columns
    emission = light.emission[:, :used]
    irradiance = np.zeros((n, used))
    for count in np.unique(light_samples):
        part = np.flatnonzero(light_samples == count)
        direct = direct_at_points(scene, position[part], normal[part], int(count), seed + int(count))
        irradiance[part] = np.einsum("xe,ec->xc", direct.astype(np.float64), emission)
    enclosed, some_row = np.zeros(n), np.full(n, -1)
    change = np.zeros((n, used))
    for part, count in _batches(gather_samples):
        batch_seed = (seed + int(part[0])) & 0xFFFFFFFF
        points = upload_points(scene, position[part], normal[part])
        tables = None if guide is None else scene.device.upload(guide[part])
        gathered = _gather(scene, elements, light, points, count, batch_seed, rules, tables)
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
    guide: DeviceArray | None,
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


def _batches(samples: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], int]]:
    """Points with one number of paths each, few enough at a time for the device."""
    for count in np.unique(samples[samples > 0]):
        points = np.flatnonzero(samples == count)
        size = max(1, BATCH_PATHS // int(count))
        for first in range(0, len(points), size):
            yield points[first : first + size], int(count)
