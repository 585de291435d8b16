"""Furnished rooms to shoot rays in: desks, books and turned lamps in a box of 8 m × 6 m × 3 m."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches

Parts = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], bool]
"""origin, edge_u, edge_v, each (n, 3) [m], and whether they are triangles."""

_ROOM = np.array([8.0, 6.0, 3.0])


@dataclass(frozen=True)
class Furniture:
    """How much stands in the room; a desk has 60 triangles, a book 12, a lamp 4 rings²."""

    desks: int
    books: int
    lamps: int
    rings: int


SPARSE = Furniture(desks=14, books=130, lamps=9, rings=6)
"""About 4 000 triangles."""
DENSE = Furniture(desks=50, books=1500, lamps=20, rings=19)
"""About 50 000 triangles."""
HUGE = Furniture(desks=100, books=2867, lamps=19, rings=28)
"""100 000 triangles, the room's own included."""


def furnished_room(furniture: Furniture, seed: int = 1) -> Patches:
    """The room, its walls facing inward, with furniture strewn by `seed`."""
    rng = np.random.default_rng(seed)
    parts = [_boxes(0.5 * _ROOM[None], 0.5 * _ROOM[None], np.eye(3)[None], inward=True)]
    parts += [_desks(rng, furniture.desks), _books(rng, furniture.books)]
    parts += [_lamp(rng, furniture.rings) for _ in range(furniture.lamps)]
    origin, edge_u, edge_v = (np.concatenate([part[k] for part in parts]) for k in range(3))
    is_triangle = np.concatenate([np.full(len(part[0]), part[3]) for part in parts])
    zeros = np.zeros(len(origin), np.int32)
    return Patches(origin, edge_u, edge_v, is_triangle, zeros, zeros, zeros, zeros)


def _boxes(
    centre: NDArray[np.float64], half: NDArray[np.float64], axes: NDArray[np.float64], inward: bool = False
) -> Parts:
    """Boxes (n, 3), (n, 3) with the rows of axes (n, 3, 3) as their directions: 6 parallelograms each."""
    edges = 2.0 * half[:, :, None] * axes
    middle = 0.5 * edges.sum(axis=1)
    corner = np.stack([centre - middle, centre + middle], axis=1)
    after, last = np.roll(edges, -1, axis=1), np.roll(edges, -2, axis=1)
    origin = np.repeat(corner, 3, axis=1)
    edge_u, edge_v = np.concatenate([last, -after], axis=1), np.concatenate([after, -last], axis=1)
    if inward:
        edge_u, edge_v = edge_v, edge_u
    return origin.reshape(-1, 3), edge_u.reshape(-1, 3), edge_v.reshape(-1, 3), False


def _turned(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, 3) axes turned about z."""
    axes = np.zeros((len(angle), 3, 3))
    axes[:, 0, 0] = axes[:, 1, 1] = np.cos(angle)
    axes[:, 0, 1] = np.sin(angle)
    axes[:, 1, 0] = -axes[:, 0, 1]
    axes[:, 2, 2] = 1.0
    return axes


def _desks(rng: np.random.Generator, n: int) -> Parts:
    """Tops of 1.4 m × 0.7 m on four legs, turned at random."""
    axes = _turned(rng.uniform(0, 2 * np.pi, n))
    foot = rng.uniform([1, 1, 1e-3], [_ROOM[0] - 1, _ROOM[1] - 1, 5e-2], (n, 3))
    sign = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
    local = np.concatenate([[[0, 0, 0.71]], np.column_stack([0.65 * sign[:, 0], 0.3 * sign[:, 1], np.full(4, 0.35)])])
    half = np.array([[0.7, 0.35, 0.015]] + [[0.025, 0.025, 0.345]] * 4)
    centre = foot[:, None] + np.einsum("pk,nkx->npx", local, axes)
    return _boxes(centre.reshape(-1, 3), np.tile(half, (n, 1)), np.repeat(axes, 5, axis=0))


def _books(rng: np.random.Generator, n: int) -> Parts:
    """Boxes of 3 cm × 16 cm × 22 cm standing at random on shelf heights."""
    half = 0.5 * rng.uniform([0.015, 0.12, 0.18], [0.045, 0.2, 0.26], (n, 3))
    centre = rng.uniform([0.2, 0.2, 0], [_ROOM[0] - 0.2, _ROOM[1] - 0.2, 0], (n, 3))
    # No two stand at the very same height: which of two coincident faces a ray meets is a matter of convention.
    centre[:, 2] = 0.3 * rng.integers(0, 8, n) + rng.uniform(1e-3, 5e-2, n) + half[:, 2]
    return _boxes(centre, half, _turned(rng.uniform(0, 2 * np.pi, n)))


def _lamp(rng: np.random.Generator, rings: int) -> Parts:
    """A turned body of 2 rings × rings quadrangles, two triangles each."""
    height = np.linspace(0, 1, rings + 1)
    radius = 0.18 * np.sin(np.pi * height) * (1.2 + np.sin(9 * height))
    around = np.linspace(0, 2 * np.pi, 2 * rings + 1)[:-1]
    points = np.empty((rings + 1, 2 * rings, 3))
    points[..., 0] = radius[:, None] * np.cos(around)
    points[..., 1] = radius[:, None] * np.sin(around)
    points[..., 2] = 0.7 * height[:, None]
    points += rng.uniform([0.5, 0.5, 0.75], [_ROOM[0] - 0.5, _ROOM[1] - 0.5, 2.0])
    beside = np.roll(points, -1, axis=1)
    lower, low_right, upper, up_right = points[:-1], beside[:-1], points[1:], beside[1:]
    origin = np.concatenate([lower.reshape(-1, 3), up_right.reshape(-1, 3)])
    edge_u = np.concatenate([(low_right - lower).reshape(-1, 3), (upper - up_right).reshape(-1, 3)])
    edge_v = np.concatenate([(upper - lower).reshape(-1, 3), (low_right - up_right).reshape(-1, 3)])
    return origin, edge_u, edge_v, True
