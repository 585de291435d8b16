"""How much of the light of each space leaves the scene, and where."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, FRONT, NONE
from hradiosity.space.check.probe import LIT, MATTER, cosine_directions, directions, outcome_of, points_on, trace
from hradiosity.space.check.subject import Subject

WALKERS = 1 << 14
"""Walkers of all spaces together, shared evenly."""
LEAST_WALKERS = 1 << 11
STEPS = 6
_STREAM = 31

Exits = dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]
"""Origins and directions (n, 3) of the rays that leave, by space."""


class _Walkers(NamedTuple):
    """Rays about to be traced.

    origin, direction : (n, 3) float64
    patch : (n,) int32, left behind, or NONE
    space : (n,) int64, or NONE where only the next surface will tell
    """

    origin: NDArray[np.float64]
    direction: NDArray[np.float64]
    patch: NDArray[np.int32]
    space: NDArray[np.int64]


def escapes(subject: Subject) -> tuple[NDArray[np.float64], Exits]:
    """(n_spaces,) share of rays that leave the scene, and those rays.

    Walkers start at lamps and are scattered by every surface, whatever its reflectance. They visit only places that
    light reaches, unlike rays from all of a surface, which may go on beyond a wall.
    """
    n = len(subject.lit.open)
    rng = subject.random(_STREAM)
    walkers = _start(subject, rng)
    total, left = np.zeros(n), np.zeros(n)
    gone: list[_Walkers] = []
    for _ in range(STEPS):
        hits = trace(subject, walkers.origin, walkers.direction, walkers.patch)
        outcome = outcome_of(subject, hits, walkers.direction)
        known = walkers.space != NONE
        counts, leaves = known & (outcome != MATTER), known & (hits.patch == NONE)
        total += np.bincount(walkers.space[counts], minlength=n)
        left += np.bincount(walkers.space[leaves], minlength=n)
        gone.append(
            _Walkers(walkers.origin[leaves], walkers.direction[leaves], walkers.patch[leaves], walkers.space[leaves])
        )
        stays = np.flatnonzero((outcome == LIT) & (hits.patch != NONE))
        target, side = hits.patch[stays], hits.side[stays]
        reached = walkers.origin[stays] + hits.t[stays, None].astype(np.float64) * walkers.direction[stays]
        walkers = _scattered(subject, reached, target, side, rng)
    # Where no ray met anything but matter, nothing is known, and nothing is to be said about cracks.
    share = np.where(total > 0.0, left / np.maximum(total, 1.0), 1.0)
    out = _joined(gone)
    return share, {int(s): (out.origin[out.space == s], out.direction[out.space == s]) for s in np.unique(out.space)}


def leaving_points(
    origin: NDArray[np.float64], direction: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, 3) where rays from within leave a box [m]."""
    wall = np.where(direction > 0.0, high, low) - origin
    reach = np.divide(wall, direction, out=np.full_like(wall, np.inf), where=direction != 0.0).min(axis=1)
    return np.asarray(origin + np.maximum(reach, 0.0)[:, None] * direction)


def _scattered(
    subject: Subject,
    point: NDArray[np.float64],
    patch: NDArray[np.int32],
    side: NDArray[np.integer],
    rng: np.random.Generator,
) -> _Walkers:
    """Walkers that leave surfaces in random directions."""
    facing = subject.normal[patch] * np.where(side == BACK, -1.0, 1.0)[:, None]
    direction = cosine_directions(rng, facing, 1)[:, 0]
    space = subject.lit.space[patch, side].astype(np.int64)
    return _Walkers(point + subject.offset * facing, direction, patch, space)


def _start(subject: Subject, rng: np.random.Generator) -> _Walkers:
    """Walkers at the lamps of each space, by area; at point sources; on all surfaces of a space lit by the sky."""
    n = len(subject.lit.open)
    each = max(WALKERS // n, LEAST_WALKERS)
    emitters = subject.scene.emitters
    both = np.array([lamp.two_sided for lamp in subject.scene.luminaires], np.bool_)[emitters.luminaire]
    is_face = emitters.patch != NONE
    lamps = np.concatenate([2 * emitters.patch[is_face] + FRONT, 2 * emitters.patch[is_face & both] + BACK])
    sides = subject.lit.space.ravel()
    point = emitters.position[~is_face]
    drawn = []
    for space in range(n):
        own = lamps[sides[lamps] == space]
        if len(own) == 0 and len(point) == 0:
            own = np.flatnonzero(sides == space)
        drawn.append(_by_area(subject, own.astype(np.int64), each, rng))
    side = np.concatenate(drawn)
    patch = (side // 2).astype(np.int32)
    faces = _scattered(subject, points_on(subject, patch, rng), patch, side % 2, rng)
    around = directions(rng, len(point), each).reshape(-1, 3)
    nothing = np.full(len(around), NONE)
    points = _Walkers(np.repeat(point, each, axis=0), around, nothing.astype(np.int32), nothing.astype(np.int64))
    return _joined([faces, points])


def _joined(parts: Sequence[_Walkers]) -> _Walkers:
    return _Walkers(
        np.concatenate([part.origin for part in parts]),
        np.concatenate([part.direction for part in parts]),
        np.concatenate([part.patch for part in parts]),
        np.concatenate([part.space for part in parts]),
    )


def _by_area(subject: Subject, side: NDArray[np.int64], n: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """(n,) sides drawn in proportion to their area; none if there are no sides."""
    if len(side) == 0:
        return np.zeros(0, np.int64)
    sums = np.cumsum(subject.area[side // 2])
    drawn = np.searchsorted(sums, (np.arange(n) + rng.random(n)) / n * sums[-1], side="right")
    return np.asarray(side[np.minimum(drawn, len(side) - 1)])
