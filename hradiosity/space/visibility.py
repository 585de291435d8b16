"""Rays from the host: which patch they meet first, and whether they meet any."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.space.bvh import Bvh

_NO_PATCH = 0xFFFFFFFF


@dataclass(frozen=True)
class Hits:
    """What n rays meet first.

    patch : (n,) int32, NONE (-1) for a ray that meets nothing
    side : (n,) uint8, FRONT (0) or BACK (1)
    t : (n,) float32, distance in lengths of the direction; inf for a miss
    u, v : (n,) float32, the point is ``origin + u edge_u + v edge_v`` of the patch
    """

    patch: NDArray[np.int32]
    side: NDArray[np.uint8]
    t: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]


def trace_closest(
    bvh: Bvh,
    origins: NDArray[np.floating[Any]],
    directions: NDArray[np.floating[Any]],
    t_max: ArrayLike = np.inf,
    skip_patch: ArrayLike | None = None,
) -> Hits:
    """First patch that each ray meets at 0 < t < t_max; of patches at the very same t the lowest number.

    Parameters
    ----------
    bvh : Bvh
    origins : (n, 3) [m], world; float64 keeps what is far from the world's origin exact
    directions : (n, 3) of any length but 0
    t_max : scalar or (n,), in lengths of the direction
    skip_patch : scalar or (n,) int, optional
        Patch that a ray passes through; NONE (-1) for none.

    Raises
    ------
    ValueError
        When the arrays do not have the same number of rays.
    """
    n = _number_of_rays(origins, directions)
    device = bvh.device
    patch = device.empty((n,), np.uint32)
    side = device.empty((n,), np.uint8)
    t = device.empty((n,), np.float32)
    uv = device.empty((n, 2), np.float32)
    device.kernel("rays", "trace_closest")(
        n,
        **bvh.kernel_arguments(),
        origin=device.upload(bvh.to_local(origins)),
        direction=device.upload(directions, np.float32),
        t_max=device.upload(_per_ray(t_max, n, np.float32)),
        skip_patch=device.upload(_patch_numbers(skip_patch, n)),
        hit_patch=patch,
        hit_side=side,
        hit_t=t,
        hit_uv=uv,
    )
    host_uv = device.fetch(uv)[:n]
    return Hits(
        patch=device.fetch(patch)[:n].view(np.int32),
        side=device.fetch(side)[:n],
        t=device.fetch(t)[:n],
        u=host_uv[:, 0] if n else np.empty(0, np.float32),
        v=host_uv[:, 1] if n else np.empty(0, np.float32),
    )


def trace_any(
    bvh: Bvh,
    origins: NDArray[np.floating[Any]],
    directions: NDArray[np.floating[Any]],
    t_max: ArrayLike = np.inf,
    skip_patch: ArrayLike | None = None,
    skip_other: ArrayLike | None = None,
) -> NDArray[np.bool_]:
    """Whether each ray meets anything at 0 < t < t_max; parameters as in `trace_closest`, with two patches to skip.

    Returns
    -------
    (n,) bool
    """
    n = _number_of_rays(origins, directions)
    device = bvh.device
    is_hit = device.empty((n,), np.uint8)
    device.kernel("rays", "trace_any")(
        n,
        **bvh.kernel_arguments(),
        origin=device.upload(bvh.to_local(origins)),
        direction=device.upload(directions, np.float32),
        t_max=device.upload(_per_ray(t_max, n, np.float32)),
        skip_patch=device.upload(_patch_numbers(skip_patch, n)),
        skip_other=device.upload(_patch_numbers(skip_other, n)),
        is_hit=is_hit,
    )
    return device.fetch(is_hit)[:n].astype(np.bool_)


def _number_of_rays(origins: NDArray[np.floating[Any]], directions: NDArray[np.floating[Any]]) -> int:
    n = len(origins)
    if np.shape(origins) != (n, 3) or np.shape(directions) != (n, 3):
        raise ValueError(
            f"origins and directions must both have shape (n, 3), have {np.shape(origins)} and {np.shape(directions)}"
        )
    return n


def _per_ray(values: ArrayLike, n: int, dtype: type[np.generic]) -> NDArray[np.generic]:
    array = np.asarray(values)
    if array.shape not in ((), (n,)):
        raise ValueError(f"a value for each of {n} rays is wanted, or a single one; shape is {array.shape}")
    return np.broadcast_to(array, (n,)).astype(dtype)


def _patch_numbers(patches: ArrayLike | None, n: int) -> NDArray[np.generic]:
    """Patch numbers as kernels see them: NONE (-1) becomes HR_NONE."""
    return _per_ray(_NO_PATCH if patches is None else np.asarray(patches).astype(np.int64) & _NO_PATCH, n, np.uint32)
