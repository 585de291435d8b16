"""Surfaces as they come out of the tables of a scene file, before they are joined into one array."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.lines import Location
from hradiosity.model.geometry import NONE, Patches


@dataclass(frozen=True)
class Piece:
    """Patches of one or several tables of the scene file.

    objects : names
    locations : where the table of each object stands
    patches : ``object``, ``surface`` and ``solid`` count within the piece
    luminaire : (n,) int32, index of the luminaire's table, or NONE
    face : (n,) names of box faces; empty strings elsewhere
    """

    objects: tuple[str, ...]
    locations: tuple[Location, ...]
    patches: Patches
    luminaire: NDArray[np.int32]
    face: NDArray[np.str_]


@dataclass(frozen=True)
class Surfaces:
    """All patches of a scene with what the tables say about each.

    patches : Patches
    objects : names that ``patches.object`` counts
    locations : where the table of each object stands
    luminaire : (n,) int32, index of the luminaire's table, or NONE
    face : (n,) names of box faces; empty strings elsewhere
    """

    patches: Patches
    objects: tuple[str, ...]
    locations: tuple[Location, ...]
    luminaire: NDArray[np.int32]
    face: NDArray[np.str_]

    def keep(self, kept: NDArray[np.bool_]) -> "Surfaces":
        """Only some of the patches; objects stay, also those without patches."""
        patches = select(self.patches, kept)
        return Surfaces(patches, self.objects, self.locations, self.luminaire[kept], self.face[kept])


def select(patches: Patches, kept: NDArray[np.bool_]) -> Patches:
    """Some of the patches."""
    return Patches(
        patches.origin[kept],
        patches.edge_u[kept],
        patches.edge_v[kept],
        patches.is_triangle[kept],
        patches.material[kept],
        patches.object[kept],
        patches.surface[kept],
        patches.solid[kept],
    )


def is_degenerate(patches: Patches) -> NDArray[np.bool_]:
    """(n,) whether a patch has no area: its height is below 1e-9 of its longest edge."""
    corners = patches.corners()
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1, initial=0.0)
    return np.asarray(patches.area <= 1e-9 * longest**2)


def _numbered(per_piece: Sequence[NDArray[np.int32]]) -> NDArray[np.int32]:
    """Join arrays of numbers so that those of different pieces differ; NONE stays."""
    joined: list[NDArray[np.int32]] = []
    first = 0
    for numbers in per_piece:
        joined.append(np.where(numbers == NONE, NONE, numbers + first).astype(np.int32))
        first += int(numbers.max(initial=NONE)) + 1
    return np.concatenate(joined) if joined else np.zeros(0, dtype=np.int32)


def join(pieces: Sequence[Piece]) -> Surfaces:
    """All pieces in one."""
    object_count = np.cumsum([0, *(len(piece.objects) for piece in pieces)])
    parts = [piece.patches for piece in pieces]
    objects = [part.object + first for part, first in zip(parts, object_count[:-1], strict=True)]
    empty = np.zeros((0, 3))
    patches = Patches(
        np.concatenate([empty, *(part.origin for part in parts)]),
        np.concatenate([empty, *(part.edge_u for part in parts)]),
        np.concatenate([empty, *(part.edge_v for part in parts)]),
        np.concatenate([np.zeros(0, dtype=bool), *(part.is_triangle for part in parts)]),
        np.concatenate([np.zeros(0, dtype=np.int32), *(part.material for part in parts)]),
        np.concatenate([np.zeros(0), *objects]).astype(np.int32),
        _numbered([part.surface for part in parts]),
        _numbered([part.solid for part in parts]),
    )
    return Surfaces(
        patches,
        tuple(name for piece in pieces for name in piece.objects),
        tuple(location for piece in pieces for location in piece.locations),
        np.concatenate([np.zeros(0, dtype=np.int32), *(piece.luminaire for piece in pieces)]),
        np.concatenate([np.zeros(0, dtype=np.str_), *(piece.face for piece in pieces)]),
    )
