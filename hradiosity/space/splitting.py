"""Flat shapes cut along segments inside them: binary partitions in the plane."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.polygons import triangulate

_ON_LINE: Final = 1e-9
"""Corners this near to a line lie on it, relative to the shape's size."""
_PARALLEL: Final = 1e-5
"""Sine of the angle below which a cut is laid parallel to an edge, so that parallelograms stay such."""
_OBLIQUE: Final = 0.5
"""Worth of a segment that is parallel to no edge, beside one that is: its cut leaves triangles."""


@dataclass(frozen=True)
class Tiles:
    """Parallelograms and triangles in the planes of the shapes that they were cut from.

    shape : (n,) int64
    origin, edge_u, edge_v : (n, 2) float64 [m]
    is_triangle : (n,) bool
    """

    shape: NDArray[np.int64]
    origin: NDArray[np.float64]
    edge_u: NDArray[np.float64]
    edge_v: NDArray[np.float64]
    is_triangle: NDArray[np.bool_]


@dataclass(order=True)
class _Part:
    """A convex part of a shape, with the segments inside it and its next cut; the best comes first.

    rank : minus what the cut is worth [m], then a number of its own
    """

    rank: tuple[float, int]
    shape: int = field(compare=False)
    polygon: NDArray[np.float64] = field(compare=False)
    segments: NDArray[np.float64] = field(compare=False)
    place: NDArray[np.float64] = field(compare=False)
    along: NDArray[np.float64] = field(compare=False)


def split_shapes(
    outlines: NDArray[np.float64],
    shape: NDArray[np.int64],
    segments: NDArray[np.float64],
    *,
    narrowest: float,
    most: int,
) -> tuple[Tiles, bool]:
    """Cut shapes along the lines of segments; the cuts that are worth most are made first.

    Each cut goes through a whole part and along the whole of one segment in it, so that parts stay convex. A cut is
    worth the segment's length times the share that it has of the cut.

    Parameters
    ----------
    outlines : (n, 4, 2) float64
        Corners of parallelograms and triangles, counter-clockwise; a triangle repeats its last corner [m].
    shape : (m,) int64
        Shape of each segment.
    segments : (m, 2, 2) float64 [m]
    narrowest : float
        No part is made narrower than this across the cut, and what is left of a segment counts from this length [m].
    most : int
        Bound on the number of cuts.

    Returns
    -------
    Tiles
        Of all shapes, in their order.
    bool
        Whether all cuts were made.
    """
    numbers = count()
    waiting: list[_Part] = []
    done: list[tuple[int, NDArray[np.float64]]] = []

    def put(owner: int, polygon: NDArray[np.float64], inside: NDArray[np.float64]) -> None:
        part = _with_best_cut(owner, polygon, inside, narrowest, next(numbers))
        if part is None:
            done.append((owner, polygon))
        else:
            heapq.heappush(waiting, part)

    order = np.argsort(shape, kind="stable")
    first = np.searchsorted(shape[order], np.arange(len(outlines) + 1))
    for i, outline in enumerate(outlines):
        put(i, _without_repeats(outline), segments[order[first[i] : first[i + 1]]])
    for _ in range(most):
        if not waiting:
            break
        part = heapq.heappop(waiting)
        for polygon in _halves(part):
            put(part.shape, polygon, part.segments)
    done.extend((part.shape, part.polygon) for part in waiting)
    return _tiles(done), not waiting


def _without_repeats(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(outline[(outline != _following(outline)).any(axis=1)], np.float64)


def _with_best_cut(
    owner: int, polygon: NDArray[np.float64], segments: NDArray[np.float64], narrowest: float, number: int
) -> _Part | None:
    """The part with its best cut; None if no cut is left."""
    if not len(segments):
        return None
    side = _following(polygon) - polygon
    side /= np.hypot(side[:, 0], side[:, 1])[:, None]
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    first, last = _inside(start, step, polygon, side)
    entry, leave = np.maximum(first, 0.0), np.minimum(last, 1.0)
    scale = np.hypot(step[:, 0], step[:, 1])
    kept = np.flatnonzero((leave - entry) * scale >= narrowest)
    if not len(kept):
        return None
    start, step, scale, entry, leave = start[kept], step[kept], scale[kept], entry[kept], leave[kept]
    segments = np.stack([start + entry[:, None] * step, start + leave[:, None] * step], axis=1)
    along, parallel = _snapped(step / scale[:, None], side)
    place = 0.5 * (segments[:, 0] + segments[:, 1])
    offset = _across(along[:, None], polygon[None] - place[:, None])
    worth = np.where(parallel, 1.0, _OBLIQUE) * scale * (leave - entry) ** 2 / (last - first)[kept]
    worth[np.minimum(offset.max(axis=1), -offset.min(axis=1)) < narrowest] = 0.0
    best = int(worth.argmax())
    if worth[best] <= 0.0:
        return None
    return _Part((-float(worth[best]), number), owner, polygon, segments, place[best], along[best])


def _following(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """The next corner, or value, of each."""
    return np.concatenate([polygon[1:], polygon[:1]])


def _across(along: NDArray[np.float64], offset: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance to the left of a direction."""
    return np.asarray(along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0])


def _inside(
    start: NDArray[np.float64], step: NDArray[np.float64], polygon: NDArray[np.float64], side: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Parameters between which start + t step lies in a convex polygon; the first exceeds the last if nowhere."""
    height = _across(side, start[:, None] - polygon)
    rise = _across(side, step[:, None])
    flat = np.abs(rise) <= 1e-12 * (np.abs(step[:, 0]) + np.abs(step[:, 1]))[:, None]
    cut = -height / np.where(flat, 1.0, rise)
    entry = np.where(flat, np.where(height < 0.0, np.inf, -np.inf), np.where(rise > 0.0, cut, -np.inf))
    leave = np.where(~flat & (rise < 0.0), cut, np.inf)
    return np.asarray(entry.max(axis=1)), np.asarray(leave.min(axis=1))


def _snapped(along: NDArray[np.float64], side: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Directions (m, 2), those of an edge where they are nearly parallel to one, and whether they are."""
    sine = np.abs(_across(along[:, None], side[None]))
    nearest = sine.argmin(axis=1)
    parallel = sine.min(axis=1) <= _PARALLEL
    return np.where(parallel[:, None], side[nearest], along), parallel


def _halves(part: _Part) -> Iterator[NDArray[np.float64]]:
    """What lies to the left and to the right of a part's cut."""
    polygon = part.polygon
    offset = _across(part.along, polygon - part.place)
    offset[np.abs(offset) <= _ON_LINE * np.abs(polygon - polygon[0]).max()] = 0.0
    following = _following(offset)
    crosses = offset * following < 0.0
    share = np.divide(offset, offset - following, out=np.zeros_like(offset), where=crosses)
    point = polygon + share[:, None] * (_following(polygon) - polygon)
    both = np.stack([polygon, point], axis=1)
    for sign in (1.0, -1.0):
        yield both[np.stack([sign * offset >= 0.0, crosses], axis=1)]


def _tiles(parts: list[tuple[int, NDArray[np.float64]]]) -> Tiles:
    """Parallelograms as they are, other shapes as triangles; in the order of the shapes."""
    owner, corners, triangular = [], [], []
    for shape, polygon in sorted(parts, key=lambda part: part[0]):
        if len(polygon) == 4 and _is_parallelogram(polygon):
            found = _turned(polygon)[None, [0, 1, 3]]
        elif len(polygon) == 3:
            found = polygon[None]
        else:
            found = polygon[triangulate(np.column_stack([polygon, np.zeros(len(polygon))]))]
        corners.append(found)
        owner.append(np.full(len(found), shape))
        triangular.append(np.full(len(found), not (len(polygon) == 4 and len(found) == 1)))
    corner = np.concatenate([np.zeros((0, 3, 2)), *corners])
    return Tiles(
        np.concatenate([np.zeros(0, np.int64), *owner]),
        corner[:, 0],
        corner[:, 1] - corner[:, 0],
        corner[:, 2] - corner[:, 0],
        np.concatenate([np.zeros(0, bool), *triangular]),
    )


def _is_parallelogram(polygon: NDArray[np.float64]) -> bool:
    misfit = polygon[0] - polygon[1] + polygon[2] - polygon[3]
    return float(np.abs(misfit).max()) <= _ON_LINE * float(np.abs(polygon - polygon[0]).max())


def _turned(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """The corners in order, the first side the one that runs most nearly along the first axis."""
    side = _following(polygon) - polygon
    best = int((side[:, 0] / np.linalg.norm(side, axis=1)).argmax())
    return np.roll(polygon, -best, axis=0)
