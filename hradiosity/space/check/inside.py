"""Which points lie inside which solids, exactly: by the solid angle that the solid's faces subtend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.space.check.probe import MATTER, Views
from hradiosity.space.check.subject import Subject

_BATCH = 1 << 18
"""Faces looked at from a point at a time."""


def enclosing_solids(subject: Subject, position: NDArray[np.float64], views: Views) -> NDArray[np.int64]:
    """(n,) solid that each place is inside of, or NONE, among those whose back some ray of the place met.

    A count of rays would not do: where solids touch other surfaces, rays from inside may meet those instead.

    Parameters
    ----------
    subject : Subject
    position : (n, 3) float64 [m]
    views : Views
        From these places.
    """
    place, ray = np.nonzero(views.outcome == MATTER)
    solid = subject.scene.patches.solid[views.patch[place, ray]]
    pairs = np.unique(np.column_stack([place, solid]), axis=0).astype(np.int64).reshape(-1, 2)
    inside = contains(subject, position[pairs[:, 0]], pairs[:, 1])
    found = np.full(len(position), NONE, np.int64)
    found[pairs[inside, 0]] = pairs[inside, 1]
    return found


def contains(subject: Subject, point: NDArray[np.float64], solid: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(n,) whether solid k contains point k: its faces then fill the whole sphere around the point, else nothing."""
    patches = subject.scene.patches
    member = np.argsort(patches.solid, kind="stable")
    ordered = patches.solid[member]
    first = np.searchsorted(ordered, solid, "left")
    count = np.searchsorted(ordered, solid, "right") - first
    angle = np.zeros(len(point))
    ends = np.cumsum(count)
    for start in range(0, int(ends[-1]) if len(ends) else 0, _BATCH):
        work = np.arange(start, min(start + _BATCH, int(ends[-1])))
        pair = np.searchsorted(ends, work, "right")
        patch = member[first[pair] + work - (ends[pair] - count[pair])]
        corner = subject.corners[patch] - point[pair, None]
        seen = _solid_angle(corner[:, 0], corner[:, 1], corner[:, 2]) + np.where(
            patches.is_triangle[patch], 0.0, _solid_angle(corner[:, 0], corner[:, 2], corner[:, 3])
        )
        angle += np.bincount(pair, seen, minlength=len(point))
    return np.abs(angle) > 2.0 * np.pi


def _solid_angle(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) signed solid angle [sr] of triangles (n, 3) from the origin; Van Oosterom and Strackee (1983), eq. 8."""
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    return np.asarray(2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb))
