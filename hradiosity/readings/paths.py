"""Unbiased light at single points, all bands at once: what everything else is checked against.

Paths share rays, emitters and random numbers with the solver, and neither elements nor exchange nor merged bands.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.model.scene import Scene
from hradiosity.readings.interval import RunningMoments
from hradiosity.readings.path_scene import RefereeScene, prepare_referee
from hradiosity.transport.device_scene import DeviceScene

SCRAMBLES = 16
"""Independent randomisations of the paths; their spread gives the standard error."""
DEPTH_LIMIT = 4096
"""Bounces after which a path is given up, and its weight reported."""
ROUND_PATHS = 1 << 19
"""Paths of one round, about: a second or two of work on a few cores."""
MIN_ITEMS = 1024
"""Work-items of a round that keep a device busy."""


@dataclass(frozen=True)
class PathSums:
    """Sums over the paths of a round.

    irradiance : (n_scrambles, n_points, n_bands) float64 [W m⁻² per band] times paths
    enclosed : (n_points,) paths whose first ray ended inside a solid
    lost_weight : weight of the paths that were given up at the depth limit
    rays : traced, shadow rays included
    """

    irradiance: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    lost_weight: float
    rays: int


@dataclass(frozen=True)
class RefereeSamples:
    """Unbiased irradiance.

    per_scramble : (n_scrambles, n_points, n_bands) float64 [W m⁻² per band], independent estimates
    enclosed : (n_points,) share of the view that ends inside a solid
    paths : from each reading, all scrambles together
    lost_weight : mean weight a path still had when it was given up; bounds what is missing, relative to the light
        at the end of such paths
    rays : traced
    """

    per_scramble: NDArray[np.float64]
    enclosed: NDArray[np.float64]
    paths: int
    lost_weight: float
    rays: int

    @property
    def irradiance(self) -> NDArray[np.float64]:
        """(n_points, n_bands) mean [W m⁻² per band]."""
        mean: NDArray[np.float64] = self.per_scramble.mean(axis=0)
        return mean

    @property
    def standard_error(self) -> NDArray[np.float64]:
        """(n_points, n_bands) of the mean [W m⁻² per band]."""
        return self.moments().standard_error

    def moments(self) -> RunningMoments:
        """Moments over the scrambles."""
        moments = RunningMoments(self.per_scramble.shape[1:])
        for sample in self.per_scramble:
            moments.add(sample)
        return moments


def trace_round(
    referee: RefereeScene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    *,
    first_path: int,
    n_paths: int,
    seed: int,
    scrambles: int = SCRAMBLES,
    depth_limit: int = DEPTH_LIMIT,
    response: NDArray[np.float32] | None = None,
) -> PathSums:
    """Paths `first_path` … `first_path + n_paths − 1` of each reading and scramble.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    first_path, n_paths : int
        Multiples of the number of paths per direct sample, a power of two, keep both in step.
    response : (n, 12) float32, optional
        How directions weigh, see `hradiosity.model.sensor_kinds`.
    """
    scene = referee.scene
    device, n = scene.device, len(position)
    if n == 0:
        return PathSums(np.zeros((scrambles, 0, referee.n_bands)), np.zeros(0), 0.0, 0)
    points = {
        "position": device.upload(scene.bvh.to_local(position)),
        "normal": device.upload(normal, np.float32),
    }
    points["response"] = points["position"] if response is None else device.upload(response)
    weighing = {} if response is None else {"HR_RESPONSE": 1}
    direct = _trace_direct(referee, points, n, first_path, n_paths, seed, scrambles, weighing)
    chunks = min(n_paths, -(-MIN_ITEMS // max(n * scrambles, 1)))
    n_items = n * scrambles * chunks
    irradiance = device.empty((n_items, 8 * referee.n_groups), np.float32)
    tally = device.empty((n_items, 3), np.float32)
    device.kernel("referee", "referee_paths", HR_GROUPS=referee.n_groups, **weighing)(
        n_items,
        **scene.geometry,
        **scene.emitters,
        **referee.arguments,
        **points,
        irradiance=irradiance,
        tally=tally,
        n_scrambles=scrambles,
        n_chunks=chunks,
        n_emitters=scene.n_emitters,
        first_path=first_path,
        n_paths=n_paths,
        direct_chance=referee.direct_share,
        depth_limit=depth_limit,
        seed=seed,
        scale=scene.scale,
    )
    counts = device.fetch(tally).astype(np.float64)
    sums = device.fetch(irradiance)[:, : referee.n_bands]
    reflected = sums.reshape(n, scrambles, chunks, -1).sum(axis=2, dtype=np.float64)
    return PathSums(
        irradiance=(direct + reflected).transpose(1, 0, 2),
        enclosed=counts[:, 0].reshape(n, -1).sum(axis=1),
        lost_weight=float(counts[:, 1].sum()),
        rays=int(counts[:, 2].sum() + n * scrambles * scene.n_emitters * n_paths * referee.direct_share),
    )


def trace_referee(
    on_device: DeviceScene,
    scene: Scene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    *,
    paths: int,
    seed: int,
    scrambles: int = SCRAMBLES,
    depth_limit: int = DEPTH_LIMIT,
    response: NDArray[np.float32] | None = None,
) -> RefereeSamples:
    """Unbiased irradiance at points, with its standard error.

    Each path starts at the reading, bounces with cosine-distributed directions and is lit at each hit by one emitter;
    Russian roulette ends it. Light from area emitters is weighed between both ways of finding it.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    paths : int
        From each reading, all scrambles together; rounded up to as many in each scramble.

    Raises
    ------
    ValueError
        When a patch emits twice.
    """
    referee = prepare_referee(on_device, scene)
    total = PathTotals(len(position), len(scene.bands), scrambles)
    for first, count in rounds(referee, len(position), paths, scrambles):
        total.add(
            trace_round(
                referee,
                position,
                normal,
                first_path=first,
                n_paths=count,
                seed=seed,
                scrambles=scrambles,
                depth_limit=depth_limit,
                response=response,
            ),
            count,
        )
    return total.samples()


def rounds(referee: RefereeScene, n_points: int, paths: int, scrambles: int = SCRAMBLES) -> list[tuple[int, int]]:
    """First path and number of paths, per scramble, of the rounds that make up `paths` paths from each reading."""
    step = max(1, round(1.0 / referee.direct_share))
    wanted = -(-max(paths, 1) // (scrambles * step)) * step
    usual = 1 << int(np.log2(max(ROUND_PATHS // max(n_points * scrambles, 1), 1)))
    size = max(step, usual)
    return [(first, min(size, wanted - first)) for first in range(0, wanted, size)]


class PathTotals:
    """Adds up rounds.

    Parameters
    ----------
    n_points, n_bands, scrambles : int
    """

    def __init__(self, n_points: int, n_bands: int, scrambles: int = SCRAMBLES) -> None:
        self._irradiance = np.zeros((scrambles, n_points, n_bands))
        self._enclosed = np.zeros(n_points)
        self._lost = 0.0
        self.rays = 0
        self.paths = 0

    def add(self, sums: PathSums, n_paths: int) -> None:
        """Take a round of `n_paths` paths per reading and scramble into account."""
        self._irradiance += sums.irradiance
        self._enclosed += sums.enclosed
        self._lost += sums.lost_weight
        self.rays += sums.rays
        self.paths += n_paths

    def samples(self) -> RefereeSamples:
        """Means so far.

        Raises
        ------
        RuntimeError
            Before the first round.
        """
        if not self.paths:
            raise RuntimeError("no path was traced yet")
        scrambles, n_points = self._irradiance.shape[:2]
        return RefereeSamples(
            per_scramble=self._irradiance / self.paths,
            enclosed=self._enclosed / (self.paths * scrambles),
            paths=self.paths * scrambles,
            lost_weight=self._lost / max(self.paths * scrambles * n_points, 1),
            rays=self.rays,
        )


def _trace_direct(
    referee: RefereeScene,
    points: dict[str, DeviceArray],
    n: int,
    first_path: int,
    n_paths: int,
    seed: int,
    scrambles: int,
    weighing: Mapping[str, int],
) -> NDArray[np.float64]:
    """(n, n_scrambles, n_bands) direct light times `n_paths`, less what the paths' first rays count."""
    scene = referee.scene
    if scene.n_emitters == 0:
        return np.zeros((n, scrambles, referee.n_bands))
    n_samples = max(1, round(n_paths * referee.direct_share))
    direct = scene.device.empty((n, scrambles, scene.n_emitters), np.float32)
    scene.device.kernel("referee", "referee_direct", HR_GROUPS=referee.n_groups, **weighing)(
        n * scrambles * scene.n_emitters,
        **scene.geometry,
        **scene.emitters,
        **points,
        direct=direct,
        n_scrambles=scrambles,
        n_emitters=scene.n_emitters,
        first_sample=round(first_path * referee.direct_share),
        n_samples=n_samples,
        direct_chance=referee.direct_share,
        seed=seed,
        scale=scene.scale,
    )
    mean = scene.device.fetch(direct).astype(np.float64) * (n_paths / n_samples)
    emission = referee.emission[:, : referee.n_bands].astype(np.float64)
    light: NDArray[np.float64] = np.einsum("xse,eb->xsb", mean, emission)
    return light
