"""Which rays from the host started inside a solid."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, Patches
from hradiosity.space.bvh import Bvh
from hradiosity.space.visibility import Hits, trace_closest

SLACK: Final = 2.0**-17
"""Surfaces closer than this, relative to the scene's half extent, may be met in either order."""


def starts_inside(
    bvh: Bvh,
    patches: Patches,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    skip_patch: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Whether each ray meets the back of a solid first, or at one place with another surface.

    Parameters
    ----------
    bvh : Bvh
    patches : Patches
    origin : (n, 3) float64 [m]
    direction : (n, 3) float64, of any length but 0
    skip_patch : (n,) int64, patch that the ray leaves

    Returns
    -------
    (n,) bool

    Notes
    -----
    Where a solid's face lies in a wall, rounding decides which of them a ray meets; a second ray past that place finds
    the other, as ``hr_leaves_solid`` does in kernels.
    """
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    hits = trace_closest(bvh, origin, unit, skip_patch=skip_patch)
    inside = _meets_solid_back(hits, patches)
    again = np.flatnonzero((hits.patch >= 0) & ~inside)
    if not len(again):
        return inside
    met, distance = hits.patch[again], hits.t[again].astype(np.float64)
    cosine = np.abs(np.einsum("ij,ij->i", unit[again], patches.normal[met]))
    slack = SLACK * bvh.scale / np.maximum(cosine, 1e-6)
    before = np.minimum(slack, distance)
    start = origin[again] + (distance - before)[:, None] * unit[again]
    others = trace_closest(bvh, start, unit[again], before + slack, skip_patch=met)
    same = patches.solid[met] == patches.solid[np.maximum(others.patch, 0)]
    inside[again] = _meets_solid_back(others, patches) & ~same
    return inside


def _meets_solid_back(hits: Hits, patches: Patches) -> NDArray[np.bool_]:
    """(n,) the ray ended on the back of a solid."""
    return np.asarray((hits.patch >= 0) & (hits.side == BACK) & (patches.solid[np.maximum(hits.patch, 0)] >= 0))
