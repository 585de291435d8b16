"""Short paths from points that look the solution up where they end, and the light that they bring."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.readings.guide import DeviceGuides
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.space.hierarchy import NONE
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

SUMMED_PATHS = 1024
"""Paths that one work-item sums in single precision."""
LIT_HITS, LATE_LIT_HITS, MOST_LIT_HITS = 2, 7, 32
"""Hits of a path that may be lit explicitly: of most paths, of those that look the solution up late, and of the few
that come into corners, contacts, slots."""


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
    first_near_factor : the same at the first hit, whose element a reading that is near sees from one side only
    """

    lookup: int = 1
    near_factor: float = 0.5
    first_near_factor: float = 2.0


@dataclass(frozen=True)
class Points:
    """Places on the device: position (n, 3) float32 in the ray structure's frame [m], normal (n, 3) float32 unit.

    response : (n, 12) float32, how directions weigh, see `hradiosity.model.sensor_kinds`; None: all alike
    """

    position: DeviceArray
    normal: DeviceArray
    n: int
    response: DeviceArray | None = None


def upload_points(
    scene: DeviceScene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    response: NDArray[np.float32] | None = None,
) -> Points:
    """Points of the world frame [m] with unit normals."""
    device = scene.device
    weighing = None if response is None else device.upload(response)
    place = device.upload(scene.bvh.to_local(position))
    return Points(place, device.upload(normal, np.float32), len(position), weighing)


def room_for(lookup: int) -> int:
    """Hits of a path that may be lit explicitly when it looks the solution up at that hit."""
    if lookup <= LIT_HITS + 1:
        return LIT_HITS
    return LATE_LIT_HITS if lookup <= LATE_LIT_HITS else MOST_LIT_HITS


def trace_paths(
    scene: DeviceScene,
    elements: DeviceElements,
    light: SurfaceLight,
    points: Points,
    n_samples: int,
    seed: int,
    rules: PathRules,
    *,
    guide: DeviceGuides | None = None,
    only: NDArray[np.int64] | None = None,
    last_chance: bool = False,
) -> PathSamples:
    """Trace `n_samples` paths from each point, or those of them whose numbers are in `only` with room for more hits.

    A path that meets more hits than it has room for is left out and marked LONG; with `last_chance` it looks the
    solution up at the last of them instead. First directions follow the `guide`, if there is one.
    """
    device = scene.device
    number = np.arange(points.n * n_samples, dtype=np.uint32) if only is None else only.astype(np.uint32)
    lit_hits = room_for(rules.lookup) if only is None else MOST_LIT_HITS
    paint, emitter = (device.empty((len(number), lit_hits), np.uint32) for _ in range(2))
    gain = device.empty((len(number), lit_hits), np.float32)
    row = device.empty((len(number),), np.uint32)
    weight = device.empty((len(number),), np.float32)
    weighing = {} if points.response is None else {"HR_RESPONSE": 1}
    path_number = device.upload(number)
    guided = 0 if guide is None else guide.kind
    directions = {
        "guide": light.weight,
        "guide_first": path_number,
        "guide_key": path_number,
        "guide_block": light.weight,
        **({} if guide is None else guide.arguments),
    }
    device.kernel("paths", "trace_paths", HR_LIT_HITS=lit_hits, HR_GUIDED=guided, **weighing)(
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
        **directions,
        response=points.position if points.response is None else points.response,
        path_number=path_number,
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
        first_near_factor=rules.first_near_factor,
        last_chance=int(last_chance),
        seed=seed,
        scale=scene.scale,
    )
    start = np.searchsorted(number, np.arange(points.n + 1, dtype=np.int64) * n_samples).astype(np.uint32)
    return PathSamples(paint, emitter, gain, row, weight, start, lit_hits, n_samples)


def lit_hits_of(device: Device, paths: PathSamples) -> NDArray[np.int64]:
    """(n_paths,) hits that were lit explicitly."""
    return np.asarray((device.fetch(paths.paint) != NONE).sum(axis=1))


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
