"""Speed of rays against Embree on the same rays: ``python -m hradiosity.suites.bench_rays [--json FILE]``.

Speeds are per CPU-second of the process, all threads added, so that the number of cores does not matter; with
``POCL_MAX_PTHREAD_COUNT=1`` in the environment both programs run on one thread. The programs take turns, and each
one's best turn counts. Embree is called through embreex, which hands it one ray after the other; ours is the whole
host call with its copies, and the kernel alone, with the rays already on the device.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.model.geometry import Patches
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_any, trace_closest
from hradiosity.suites.bench.figure import RATIO, SPEED, Figure, figure_of
from hradiosity.suites.bench.session import Session, cpu_seconds
from hradiosity.suites.bench_rooms import DENSE, SPARSE, furnished_room

_OFFSET = 1e-4
"""Rays start this far [m] in front of their surface, in both programs."""


@dataclass(frozen=True)
class Rays:
    """origin, direction : (n, 3) float32 [m]; t_max : (n,) float32, in lengths of the direction."""

    origin: NDArray[np.float32]
    direction: NDArray[np.float32]
    t_max: NDArray[np.float32]


@dataclass(frozen=True)
class Speed:
    """One kind of rays in one room; speeds in Mray per CPU-second, `ratio` is ours to Embree's.

    agreement : share of rays for which both programs say the same
    """

    triangles: int
    rays: str
    embree: float
    call: float
    kernel: float
    ratio_call: float
    ratio_kernel: float
    agreement: float


class EmbreeRoom:
    """The same triangles in Embree."""

    def __init__(self, patches: Patches) -> None:
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh

        corners = patches.corners().astype(np.float32)
        second = np.flatnonzero(~patches.is_triangle)
        triangles = np.concatenate([corners[:, [0, 1, 3]], corners[second][:, [2, 3, 1]]])
        self.patch_of = np.concatenate([np.arange(len(patches)), second, [-1]])
        self.scene = rtcore_scene.EmbreeScene()
        self._mesh = TriangleMesh(self.scene, triangles)
        self.n_triangles = len(triangles)

    def closest(self, rays: Rays) -> NDArray[np.int64]:
        """Patch that each ray meets first, -1 for none."""
        patch: NDArray[np.int64] = self.patch_of[self.scene.run(rays.origin, rays.direction, query="INTERSECT")]
        return patch

    def any(self, rays: Rays) -> NDArray[np.bool_]:
        """Whether each ray meets anything before t_max."""
        found = self.scene.run(rays.origin, rays.direction, dists=rays.t_max.copy(), query="OCCLUDED")
        is_blocked: NDArray[np.bool_] = np.not_equal(found, -1)
        return is_blocked


def surface_points(
    patches: Patches, n: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 3) uniform in area, just off the front, and normals (n, 3) there."""
    patch = rng.choice(len(patches), n, p=patches.area / patches.area.sum())
    u, v = rng.random((2, n))
    folded = patches.is_triangle[patch] & (u + v > 1)
    u, v = np.where(folded, 1 - u, u), np.where(folded, 1 - v, v)
    normal = patches.normal[patch]
    point = patches.origin[patch] + u[:, None] * patches.edge_u[patch] + v[:, None] * patches.edge_v[patch]
    return point + _OFFSET * normal, normal


def diffuse_rays(patches: Patches, n: int, rng: np.random.Generator) -> Rays:
    """Cosine-distributed directions from surfaces, without a limit: no two rays have anything in common."""
    point, normal = surface_points(patches, n, rng)
    direction = rng.normal(size=(n, 3))
    direction = normal + direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return Rays(point.astype(np.float32), direction.astype(np.float32), np.full(n, np.inf, np.float32))


def shadow_rays(patches: Patches, n: int, rng: np.random.Generator) -> Rays:
    """From surface point to surface point, both in front of each other."""
    (start, start_normal), (end, end_normal) = (surface_points(patches, 4 * n, rng) for _ in range(2))
    step = end - start
    facing = ((step * start_normal).sum(1) > 0) & ((step * end_normal).sum(1) < 0)
    chosen = np.flatnonzero(facing)[:n]
    return Rays(start[chosen].astype(np.float32), step[chosen].astype(np.float32), np.ones(len(chosen), np.float32))


def best_cpu_seconds(works: Sequence[Callable[[], object]], turns: int) -> list[float]:
    """Shortest time of each of `works` over `turns` turns, after one that is not counted."""
    return [min(seconds) for seconds in cpu_seconds(works, turns)]


def kernel_run(bvh: Bvh, kernel: str, rays: Rays) -> Callable[[], None]:
    """A launch over rays that are on the device already."""
    device, n = bvh.device, len(rays.origin)
    nobody = device.upload(np.full(n, 0xFFFFFFFF, np.uint32))
    arguments = bvh.kernel_arguments() | {
        "origin": device.upload(bvh.to_local(rays.origin)),
        "direction": device.upload(rays.direction),
        "t_max": device.upload(rays.t_max),
        "skip_patch": nobody,
    }
    if kernel == "trace_any":
        arguments |= {"skip_other": nobody, "is_hit": device.empty((n,), np.uint8)}
    else:
        arguments |= {"hit_patch": device.empty((n,), np.uint32), "hit_side": device.empty((n,), np.uint8)}
        arguments |= {"hit_t": device.empty((n,), np.float32), "hit_uv": device.empty((n, 2), np.float32)}
    launch = device.kernel("rays", kernel)

    def run() -> None:
        launch(n, **arguments)
        device.finish()

    return run


def compare(patches: Patches, bvh: Bvh, n: int, turns: int) -> list[Speed]:
    """Closest and any-hit rays in one room."""
    embree = EmbreeRoom(patches)
    rng = np.random.default_rng(2)
    diffuse, shadow = diffuse_rays(patches, n, rng), shadow_rays(patches, n, rng)

    def closest(rays: Rays) -> NDArray[np.int32]:
        return trace_closest(bvh, rays.origin, rays.direction).patch

    def blocked(rays: Rays) -> NDArray[np.bool_]:
        return trace_any(bvh, rays.origin, rays.direction, rays.t_max)

    return [
        _speed("closest, diffuse", embree.n_triangles, diffuse, turns, embree.closest, closest, bvh, "trace_closest"),
        _speed("any, diffuse", embree.n_triangles, diffuse, turns, embree.any, blocked, bvh, "trace_any"),
        _speed("any, surface to surface", embree.n_triangles, shadow, turns, embree.any, blocked, bvh, "trace_any"),
    ]


def _speed(
    name: str,
    n_triangles: int,
    rays: Rays,
    turns: int,
    theirs: Callable[[Rays], NDArray[Any]],
    ours: Callable[[Rays], NDArray[Any]],
    bvh: Bvh,
    kernel: str,
) -> Speed:
    works = (lambda: theirs(rays), lambda: ours(rays), kernel_run(bvh, kernel, rays))
    embree, call, alone = (len(rays.origin) / seconds / 1e6 for seconds in best_cpu_seconds(works, turns))
    return Speed(
        triangles=n_triangles,
        rays=name,
        embree=embree,
        call=call,
        kernel=alone,
        ratio_call=call / embree,
        ratio_kernel=alone / embree,
        agreement=float((theirs(rays) == ours(rays)).mean()),
    )


def measure(session: Session) -> list[Figure]:
    """Speeds in the dense room, beside Embree where that is installed; ratios are taken turn by turn."""
    patches = furnished_room(DENSE)
    bvh = build_bvh(session.device, patches)
    rng = np.random.default_rng(2)
    n = 200_000 if session.quick else 1_000_000
    embree = EmbreeRoom(patches) if session.has_peer("embreex") else None
    diffuse, shadow = diffuse_rays(patches, n, rng), shadow_rays(patches, n, rng)
    figures = _measured("closest, diffuse", diffuse, bvh, "trace_closest", embree, session.turns)
    return figures + _measured("any, surface to surface", shadow, bvh, "trace_any", embree, session.turns)


def _measured(rays_name: str, rays: Rays, bvh: Bvh, kernel: str, embree: EmbreeRoom | None, turns: int) -> list[Figure]:
    """Figures of one kind of rays: the whole host call, the kernel alone, and the peer."""
    is_closest = kernel == "trace_closest"

    def call() -> object:
        if is_closest:
            return trace_closest(bvh, rays.origin, rays.direction)
        return trace_any(bvh, rays.origin, rays.direction, rays.t_max)

    works: dict[str, Callable[[], object]] = {"call": call, "kernel": kernel_run(bvh, kernel, rays)}
    if embree is not None:
        peer = embree.closest if is_closest else embree.any
        works["Embree"] = lambda: peer(rays)
    spent = dict(zip(works, cpu_seconds(list(works.values()), turns)))
    millions = len(rays.origin) / 1e6
    name = f"rays: {rays_name}, "
    figures = [figure_of(name + key, [millions / t for t in seconds], SPEED) for key, seconds in spent.items()]
    if embree is not None:
        ratios = [theirs / ours for theirs, ours in zip(spent["Embree"], spent["call"])]
        figures.append(figure_of(name + "call to Embree", ratios, RATIO))
    return figures


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--json", type=Path, help="write the figures there as well")
    parser.add_argument("--rays", type=int, default=200_000, help="rays a launch")
    parser.add_argument("--turns", type=int, default=6, help="the best of so many counts")
    options = parser.parse_args()
    device = Device()
    print(device.description)
    print(f"{'triangles':>9}  {'rays':<24} {'Embree':>7} {'call':>7} {'kernel':>7}  Mray/CPU-s   ratio call / kernel")
    speeds: list[Speed] = []
    for furniture in (SPARSE, DENSE):
        patches = furnished_room(furniture)
        build_bvh(device, patches)
        start = time.perf_counter()
        bvh = build_bvh(device, patches)
        seconds = time.perf_counter() - start
        for s in compare(patches, bvh, options.rays, options.turns):
            print(
                f"{s.triangles:9d}  {s.rays:<24} {s.embree:7.2f} {s.call:7.2f} {s.kernel:7.2f}  "
                f"{'':10}   {s.ratio_call:10.2f} / {s.ratio_kernel:.2f}   agree {s.agreement:.5f}"
            )
            speeds.append(s)
        print(f"{'':9}  built in {seconds:.3f} s, {bvh.depth} levels")
    if options.json:
        options.json.write_text(json.dumps([asdict(s) for s in speeds], indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
