"""Rays from places of interest, and what they meet: lit sides, dark sides, the inside of a solid, or nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK
from hradiosity.space.check.subject import Subject
from hradiosity.space.visibility import Hits, trace_closest

MISSED, LIT, DARK, MATTER = range(4)
"""What a ray meets: nothing, a side that light reaches, one that it does not, the back of a solid (it was inside)."""


@dataclass(frozen=True)
class Views:
    """What k rays from each of n places meet.

    outcome : (n, k) uint8, MISSED, LIT, DARK or MATTER
    patch : (n, k) int32, the patch met, or NONE
    side : (n, k) uint8, of that patch
    distance : (n, k) float64 [m]; inf for a miss
    direction : (n, k, 3) float64
    """

    outcome: NDArray[np.uint8]
    patch: NDArray[np.int32]
    side: NDArray[np.uint8]
    distance: NDArray[np.float64]
    direction: NDArray[np.float64]

    def share(self, outcome: int) -> NDArray[np.float64]:
        """(n,) share of a place's rays with this outcome."""
        return np.asarray((self.outcome == outcome).mean(axis=1))


def trace(
    subject: Subject, origin: NDArray[np.float64], direction: NDArray[np.float64], skip: NDArray[np.int32] | None = None
) -> Hits:
    """First hits of rays (n, 3); passes through patch ``skip`` (n,)."""
    return trace_closest(subject.bvh, origin, direction, skip_patch=skip)


def outcome_of(subject: Subject, hits: Hits, direction: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(n,) what rays along (n, 3) met; the sky counts as a lit side."""
    met = np.maximum(hits.patch, 0)
    empty = np.full(len(met), MISSED, np.uint8)
    if subject.scene.sky is not None:
        empty[direction[:, 2] > 0.0] = LIT
    if len(subject.scene.patches) == 0:
        return empty
    matter = (hits.side == BACK) & (subject.scene.patches.solid[met] >= 0)
    is_lit = subject.lit.lit[met, hits.side]
    return np.where(hits.patch < 0, empty, np.where(matter, MATTER, np.where(is_lit, LIT, DARK))).astype(np.uint8)


def look(subject: Subject, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> Views:
    """Views from n places along k directions each: origin (n, 3) [m], direction (n, k, 3)."""
    n, k, _ = direction.shape
    hits = trace(subject, np.repeat(origin, k, axis=0), direction.reshape(-1, 3))
    return Views(
        outcome_of(subject, hits, direction.reshape(-1, 3)).reshape(n, k),
        hits.patch.reshape(n, k),
        hits.side.reshape(n, k),
        hits.t.astype(np.float64).reshape(n, k),
        direction,
    )


def directions(rng: np.random.Generator, n: int, k: int) -> NDArray[np.float64]:
    """(n, k, 3) random unit vectors."""
    vectors = rng.standard_normal((n, k, 3))
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-12))


def cosine_directions(rng: np.random.Generator, normal: NDArray[np.float64], k: int) -> NDArray[np.float64]:
    """(n, k, 3) directions with the density of the cosine about each normal (n, 3): a unit vector plus the normal."""
    vectors = directions(rng, len(normal), k) + normal[:, None, :]
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-12))


def points_on(
    subject: Subject, patch: NDArray[np.integer], rng: np.random.Generator, margin: float = 0.0
) -> NDArray[np.float64]:
    """(n, 3) one uniform random point on each of these patches [m], off its edges by a share ``margin`` of its size."""
    patches = subject.scene.patches
    uv = rng.random((len(patch), 2))
    fold = patches.is_triangle[patch] & (uv.sum(axis=1) > 1.0)
    uv[fold] = 1.0 - uv[fold]
    point = patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
    return np.asarray(point + margin * (subject.centroid[patch] - point))


def most_frequent(values: NDArray[np.integer]) -> int:
    """The value that occurs most often; the lowest of equals. At least one value."""
    found, count = np.unique(values, return_counts=True)
    return int(found[count.argmax()])
