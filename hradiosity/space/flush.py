"""Sides of patches that a solid stands flush against: a box on a floor, a cupboard at a wall, two boxes that touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, FRONT, Patches
from hradiosity.space.coplanar import coplanar_pairs


def flush_reach(patches: Patches) -> NDArray[np.float32]:
    """(n, 2) how far rays can have come inside a solid when they leave it where front or back lie [m]; 0 for none.

    A ray leaves a solid along a face's normal, so it meets the front of a patch that faces the other way, and the back
    of one that faces the same way. Which of the two surfaces is nearer is then left to rounding. Faces of the patch's
    own solid don't count.
    """
    reach = np.zeros((len(patches), 2), np.float32)
    if not (patches.solid >= 0).any():
        return reach
    pairs = coplanar_pairs(patches)
    side = np.where(pairs.same_facing, BACK, FRONT)
    diameter = _diameters(patches)
    for patch, face in ((pairs.first, pairs.second), (pairs.second, pairs.first)):
        stands = (patches.solid[face] >= 0) & (patches.solid[face] != patches.solid[patch])
        longest = diameter[patches.solid[face[stands]]]
        np.maximum.at(reach, (patch[stands], side[stands]), longest)
    return reach


def _diameters(patches: Patches) -> NDArray[np.float32]:
    """(n_solids,) diagonal of each solid's bounding box, and a thousandth for rounding [m]."""
    matter = patches.solid >= 0
    corners, solid = patches.corners()[matter], patches.solid[matter]
    low = np.full((int(solid.max()) + 1, 3), np.inf)
    high = -low
    np.minimum.at(low, solid, corners.min(axis=1))
    np.maximum.at(high, solid, corners.max(axis=1))
    used = np.isfinite(low)
    extent = np.subtract(high, low, out=np.zeros_like(low), where=used)
    return np.asarray(1.001 * np.linalg.norm(extent, axis=1), np.float32)
