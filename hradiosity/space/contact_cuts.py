"""Patches cut where others stand on them, so that no element reaches from one space into another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Note, Scene
from hradiosity.space.contacts import Contacts, find_contacts, outlines, plane_axes
from hradiosity.space.splitting import split_shapes

ELEMENTS: Final = 4000
"""The side of a square that is one part in so many of all area is the unit of lengths here: about an element's edge."""
NARROWEST: Final = 0.125
"""No piece is narrower than this share of the unit, and an edge as far from a plane still stands on it."""
SHEET: Final = 0.125
"""Shortest line of contact with a sheet that is worth a cut; light may be on one side of it and none on the other."""
SOLID: Final = 3.0
"""The same for a solid: rays that start inside it are left out anyway, so that only what parts a room matters."""
_LEAST_EDGE: Final = 0.03125
"""Shorter edges of sheets count for nothing, even where they make up a long line."""
_FREE: Final = 256
_MOST: Final = 4096
"""No more cuts are made than there are patches, but these in any scene, and those in none."""


@dataclass(frozen=True)
class CutScene:
    """A scene with its patches cut.

    scene : Scene
    parent : (n_pieces,) int64, the patch that each piece was cut from; rising
    """

    scene: Scene
    parent: NDArray[np.int64]


def cut_at_contacts(scene: Scene) -> CutScene:
    """The scene with its patches cut along the lines on which other patches stand; emitting patches stay whole.

    Pieces keep material, object, surface and solid. Where nothing is to be cut it is the same scene.
    """
    uncut = CutScene(scene, np.arange(len(scene.patches)))
    patches = scene.patches
    area = patches.area
    unit = float(np.sqrt(area.sum() / ELEMENTS))
    contacts = _worthwhile(patches, _bases(scene, area, NARROWEST * unit), unit)
    if len(contacts.patch) == 0:
        return uncut
    which, shape = np.unique(contacts.patch, return_inverse=True)
    axes = plane_axes(patches)
    tiles, finished = split_shapes(
        outlines(patches, axes, which),
        shape,
        np.stack([contacts.start, contacts.end], axis=1),
        narrowest=NARROWEST * unit,
        most=min(max(len(patches), _FREE), _MOST),
    )
    parent = which[tiles.shape]
    pieces = _taken(patches, parent)
    at = axes[parent]
    pieces = replace(
        pieces,
        origin=pieces.origin + np.einsum("ma,mad->md", tiles.origin, at),
        edge_u=np.einsum("ma,mad->md", tiles.edge_u, at),
        edge_v=np.einsum("ma,mad->md", tiles.edge_v, at),
        is_triangle=tiles.is_triangle,
    )
    whole = np.bincount(parent, minlength=len(patches)) <= 1
    return uncut if whole.all() else _joined(scene, whole, pieces, parent, finished)


def _bases(scene: Scene, area: NDArray[np.float64], narrowest: float) -> NDArray[np.bool_]:
    """(n,) patches that emit nothing and are wide enough to be cut in two."""
    patches = scene.patches
    edges = np.stack([patches.edge_u, patches.edge_v, patches.edge_u - patches.edge_v])
    longest = np.linalg.norm(edges, axis=2).max(axis=0)
    bases = np.asarray(area > 2.0 * narrowest * longest, bool)
    bases[scene.emitters.patch[scene.emitters.patch != NONE]] = False
    return bases


def _worthwhile(patches: Patches, bases: NDArray[np.bool_], unit: float) -> Contacts:
    """Contacts that are long enough to be worth a cut."""
    shortest = np.where(patches.solid != NONE, SOLID, _LEAST_EDGE) * unit
    contacts = find_contacts(patches, bases, shortest, NARROWEST * unit)
    return contacts.keep(contacts.length >= np.where(contacts.solid, SOLID, SHEET) * unit)


def _joined(
    scene: Scene,
    whole: NDArray[np.bool_],
    pieces: Patches,
    parent: NDArray[np.int64],
    finished: bool,
) -> CutScene:
    """The scene with pieces in the places of the patches that were cut."""
    cut = ~whole[parent]
    origin_of = np.concatenate([np.flatnonzero(whole), parent[cut]])
    order = np.argsort(origin_of, kind="stable")
    patches = _taken(_stacked(_taken(scene.patches, whole), _taken(pieces, cut)), order)
    emitters = scene.emitters
    place = np.searchsorted(origin_of[order], np.maximum(emitters.patch, 0))
    emitters = replace(emitters, patch=np.where(emitters.patch == NONE, NONE, place).astype(np.int32))
    n_cut = int((~whole).sum())
    message = f"{n_cut} patches were cut into {int(cut.sum())} where others stand on them"
    if not finished:
        message += "; further lines of contact were left, since there are too many"
    note = Note("info", "surfaces", message)
    scene = replace(scene, patches=patches, emitters=emitters, notes=(*scene.notes, note))
    return CutScene(scene, origin_of[order])


def _taken(patches: Patches, which: NDArray[np.integer] | NDArray[np.bool_]) -> Patches:
    """Some of the patches, or some of them several times."""
    return Patches(**{name: array[which] for name, array in vars(patches).items()})


def _stacked(one: Patches, other: Patches) -> Patches:
    return Patches(**{name: np.concatenate([array, vars(other)[name]]) for name, array in vars(one).items()})
