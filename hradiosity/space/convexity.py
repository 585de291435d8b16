"""Proof that nothing can stand between any two points of a scene."""

from __future__ import annotations

import numpy as np

from hradiosity.model.geometry import Patches


def is_convex(patches: Patches) -> bool:
    """True when every corner lies in front of every patch's plane, so that nothing can stand between two points.

    Tolerance: 1e-6 of the scene's size. Scenes of more than 512 patches are not tried.
    """
    if len(patches) > 512:
        return False
    corners = patches.corners().reshape(-1, 3)
    height = np.einsum("pd,cpd->pc", patches.normal, corners[:, None, :] - patches.origin[None])
    low, high = patches.bounds()
    return bool(height.min() >= -1e-6 * float(np.linalg.norm(high - low)))
