"""Spots that many lines pass: where light that matters is drawn together, as in a door, a slot or a window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.aims import Lines

SIZES: Final = (128, 64, 32)
"""Cells along the longest edge of the scene, of the grids that lines are counted in."""
MOST_SPOTS: Final = 24
LEAST_SHARE: Final = 0.005
"""Part of all lines, by their weight, that a further spot has to catch."""
ENOUGH: Final = 0.95
"""Part of them that is enough."""
RADIUS: Final = 0.6
"""Of a spot, in cells."""


@dataclass(frozen=True)
class Spots:
    """Balls that lines pass.

    ball : (n_spots, 4) float64, centre and radius [m]
    caught : (n_spots,) float64, weight of the lines that each catches and those before it do not
    """

    ball: NDArray[np.float64]
    caught: NDArray[np.float64]


def find_spots(lines: Lines, weight: NDArray[np.float64], extent: float) -> list[Spots]:
    """Few spots that catch most of the lines, in several sizes.

    Parameters
    ----------
    lines : Lines
    weight : (n,) float64
        What it is worth to catch each.
    extent : float
        Longest edge of the scene [m].
    """
    return [_greedy(lines, weight, extent / cells) for cells in SIZES]


def passes(
    ball: NDArray[np.float64], origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Whether half-lines (n, 3) from outside meet balls (m, 4), and 1 − cos of half the angle that these fill there.

    Both (n, m); the second is 0 from inside of a ball.
    """
    away = ball[None, :, :3] - origin[:, None]
    along = np.einsum("nmc,nc->nm", away, direction)
    square = np.einsum("nmc,nmc->nm", away, away)
    radius2 = ball[None, :, 3] ** 2
    sine2 = radius2 / np.maximum(square, np.finfo(np.float64).tiny)
    cone = np.where(sine2 < 1.0, sine2 / (1.0 + np.sqrt(np.maximum(1.0 - sine2, 0.0))), 0.0)
    return (along > 0.0) & (square - along**2 < radius2) & (cone > 0.0), cone


def _greedy(lines: Lines, weight: NDArray[np.float64], cell: float) -> Spots:
    """The spot that catches most, then the one that catches most of what is left, and so on."""
    line, place, point = _counted(lines, cell)
    left = weight.copy()
    balls: list[NDArray[np.float64]] = []
    caught: list[float] = []
    total = float(weight.sum())
    while len(balls) < MOST_SPOTS and left.sum() > (1.0 - ENOUGH) * total:
        votes = np.bincount(place, left[line])
        best = int(votes.argmax())
        inside = np.flatnonzero(place == best)
        centre = np.average(point[inside], axis=0, weights=left[line[inside]])
        ball = np.append(centre, RADIUS * cell)
        met = _meets(ball, lines)
        gain = float(left[met].sum())
        if gain < LEAST_SHARE * total:
            break
        balls.append(ball)
        caught.append(gain)
        left[met] = 0.0
    return Spots(np.array(balls).reshape(-1, 4), np.array(caught))


def _counted(lines: Lines, cell: float) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Which lines pass which cells of a grid: line and number of the cell, once each, and a point of the line there."""
    steps = np.ceil(2.0 * lines.length / cell).astype(np.int64)
    line = np.repeat(np.arange(len(steps)), steps)
    number = np.arange(len(line)) - np.repeat(np.cumsum(steps) - steps, steps)
    along = (number + 0.5) * 0.5 * cell
    point = lines.origin[line] + np.minimum(along, lines.length[line])[:, None] * lines.direction[line]
    index = np.floor((point - point.min(axis=0)) / cell).astype(np.int64)
    shape = index.max(axis=0) + 1
    key = (index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2]
    new = np.append(True, (key[1:] != key[:-1]) | (line[1:] != line[:-1]))
    place = np.unique(key[new], return_inverse=True)[1].ravel()
    return line[new], place, point[new]


def _meets(ball: NDArray[np.float64], lines: Lines) -> NDArray[np.bool_]:
    """(n,) whether lines come into a ball before they end."""
    away = ball[:3] - lines.origin
    along = np.clip(np.einsum("nc,nc->n", away, lines.direction), 0.0, lines.length)
    apart: NDArray[np.bool_] = ((away - along[:, None] * lines.direction) ** 2).sum(axis=1) < ball[3] ** 2
    return apart
