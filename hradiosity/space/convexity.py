"""Proof that nothing can stand between any two points of a scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches


def is_convex(patches: Patches, points: NDArray[np.float64]) -> bool:
    """True when every corner and every point lies in front of every patch's plane: nothing can stand between any two.

    Tolerance: 1e-6 of the scene's size. Scenes of more than 512 patches are not tried.

    Parameters
    ----------
    patches : Patches
    points : (n, 3) float64
        Other places that light comes from or goes to: point sources, readings [m].
    """
    if len(patches) > 512:
        return False
    if len(patches) == 0:
        return True
    low, high = patches.bounds()
    places = np.concatenate([patches.corners().reshape(-1, 3), points])
    lowest = min(float(((places - o) @ n).min()) for o, n in zip(patches.origin, patches.normal))
    return lowest >= -1e-6 * float(np.linalg.norm(high - low))
