"""Which of many flat shapes overlap, and by how much."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_SHRINK = 1e-6
"""One of two shapes is shrunk by this, so that edges that coincide are counted once; the area is off by twice this."""
_FINEST = 20
"""Cells are at most 2^20 times smaller than everything."""


def overlapping_boxes(
    low: NDArray[np.float64], high: NDArray[np.float64], group: NDArray[np.integer], slack: float
) -> NDArray[np.int64]:
    """Pairs of boxes of one group that overlap by more than ``slack`` in both directions.

    Boxes are sorted into grids whose cells are as large as they are, so that each lies in at most 2 × 2 cells; a box
    looks for partners in its own grid and in the coarser ones.

    Parameters
    ----------
    low, high : (n, 2) float64
    group : (n,) int, below 2^20
    slack : float

    Returns
    -------
    (m, 2) int64
        Each pair once, the lower number first.
    """
    n = len(low)
    if n < 2:
        return np.zeros((0, 2), np.int64)
    start = low.min(axis=0)
    whole = float((high.max(axis=0) - start).max())
    if whole <= 0.0:
        return np.zeros((0, 2), np.int64)
    extent = np.maximum((high - low).max(axis=1), whole * 2.0**-_FINEST)
    level = np.ceil(np.log2(extent / whole)).astype(np.int64)
    found = []
    for coarse in np.unique(level):
        cell = whole * 2.0 ** float(coarse)
        owner, own_key = _cells((low - start) / cell, (high - start) / cell, group, np.flatnonzero(level == coarse))
        asker, asked_key = _cells((low - start) / cell, (high - start) / cell, group, np.flatnonzero(level <= coarse))
        order = np.argsort(own_key, kind="stable")
        owner, own_key = owner[order], own_key[order]
        first = np.searchsorted(own_key, asked_key, "left")
        count = np.searchsorted(own_key, asked_key, "right") - first
        a = np.repeat(asker, count)
        b = owner[np.repeat(first - (np.cumsum(count) - count), count) + np.arange(len(a))]
        kept = (a < b) | (level[a] < coarse)
        a, b = a[kept], b[kept]
        common = np.minimum(high[a], high[b]) - np.maximum(low[a], low[b])
        close = (common > slack).all(axis=1)
        found.append(np.minimum(a, b)[close] * n + np.maximum(a, b)[close])
    pair = np.unique(np.concatenate(found))
    return np.column_stack([pair // n, pair % n])


def _cells(
    low: NDArray[np.float64], high: NDArray[np.float64], group: NDArray[np.integer], box: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Boxes, once for each cell they lie in, and the cells' numbers; a box is at most one cell large."""
    first, last = np.floor(low[box]).astype(np.int64), np.floor(high[box]).astype(np.int64)
    boxes, keys = [], []
    for x in (0, 1):
        for y in (0, 1):
            in_cell = ((x == 0) | (last[:, 0] > first[:, 0])) & ((y == 0) | (last[:, 1] > first[:, 1]))
            here = box[in_cell]
            boxes.append(here)
            column, row = first[in_cell, 0] + x, first[in_cell, 1] + y
            keys.append((group[here].astype(np.int64) << 42) + (column << 21) + row)
    return np.concatenate(boxes), np.concatenate(keys)


def overlap_areas(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area that convex quadrilaterals have in common, pair by pair.

    By Green's theorem over the edges of each that lie in the other. A triangle repeats a corner.

    Parameters
    ----------
    a, b : (m, 4, 2) float64
        Corners in order, in either sense.

    Returns
    -------
    (m,) float64
        Relative error 2e-6 from `_SHRINK`.
    """
    origin = a[:, :1]
    a, b = _counter_clockwise(a - origin), _counter_clockwise(b - origin)
    centre = b.mean(axis=1, keepdims=True)
    b = centre + (1.0 - _SHRINK) * (b - centre)
    return np.maximum(0.5 * (_edges_inside(a, b) + _edges_inside(b, a)), 0.0)


def _counter_clockwise(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    clockwise = _cross(polygon, np.roll(polygon, -1, axis=1)).sum(axis=1) < 0.0
    return np.where(clockwise[:, None, None], polygon[:, ::-1], polygon)


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _edges_inside(polygon: NDArray[np.float64], window: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) sum over the parts of edges inside a convex window of start × end; Cyrus and Beck's clipping."""
    start, end = polygon, np.roll(polygon, -1, axis=1)
    along = np.roll(window, -1, axis=1) - window
    first = _cross(along[:, None], start[:, :, None] - window[:, None])
    last = _cross(along[:, None], end[:, :, None] - window[:, None])
    change = last - first
    cut = np.divide(-first, change, out=np.zeros_like(first), where=change != 0.0)
    entry = np.where(change > 0.0, cut, np.where((change == 0.0) & (first < 0.0), np.inf, 0.0)).max(axis=2)
    leave = np.where(change < 0.0, cut, 1.0).min(axis=2)
    part = np.maximum(np.minimum(leave, 1.0) - np.maximum(entry, 0.0), 0.0)
    return np.asarray((part * _cross(start, end)).sum(axis=1))
