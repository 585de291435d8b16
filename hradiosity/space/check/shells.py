"""Bodies that are inside out or not closed, and one-sided materials that are seen from behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, FRONT, NONE
from hradiosity.model.solids import find_solids
from hradiosity.model.welding import weld
from hradiosity.space.check.finding import Finding, at, numbers
from hradiosity.space.check.probe import LIT, cosine_directions, outcome_of, points_on, trace
from hradiosity.space.check.subject import Subject

_LEAST_FACES = 4
_MOST_OPEN = 1.0 / 3.0
"""Share of edges without neighbour up to which an object is taken for a body with a hole, not for a few sheets."""
_WELD = 2e-6
_RAYS, _STREAM = 64, 15
"""Rays from the front of a face that seems to look the wrong way."""
_COUNTS = 0.01
"""Share of a space's surfaces from which on faces that look the wrong way are a fault: that much of its reflections."""


def shell_findings(subject: Subject) -> Iterator[Finding]:
    """Bodies inside out, bodies with holes, and one-sided backs in the light."""
    patches = subject.scene.patches
    shells = find_solids(subject.corners, patches.is_triangle, patches.object)
    yield from _inside_out(subject, shells.inward)
    yield from _with_holes(subject, (patches.solid == NONE) & (shells.solid == NONE) & (shells.inward == NONE))
    yield from _black_backs(subject)


def _inside_out(subject: Subject, inward: NDArray[np.int32]) -> Iterator[Finding]:
    """Closed shells that face inwards but are lit from outside only: not rooms."""
    n = int(inward.max(initial=NONE)) + 1
    owned = inward >= 0
    lit_inside = np.bincount(inward[owned & subject.lit.lit[:, FRONT]], minlength=n) > 0
    lit_outside = np.bincount(inward[owned & subject.lit.lit[:, BACK]], minlength=n) > 0
    for number in np.flatnonzero(lit_outside & ~lit_inside):
        mine = np.flatnonzero(inward == number)
        name, corners = subject.name(int(mine[0])), subject.corners[mine].reshape(-1, 3)
        yield Finding(
            "inside-out",
            "warning",
            name,
            0.5 * (corners.min(axis=0) + corners.max(axis=0)),
            float(np.linalg.norm(np.ptp(corners, axis=0))),
            f"'{name}' is closed but its {len(mine)} faces point inwards, and light reaches it from outside only",
            "it isn't taken for a solid: what it covers of a floor stays lit, and one-sided materials are black",
            "turn its faces round",
            numbers(mine),
        )


def _with_holes(subject: Subject, loose: NDArray[np.bool_]) -> Iterator[Finding]:
    """Objects most of whose edges join two faces, and which bulge outwards."""
    patch = np.flatnonzero(loose)
    if len(patch) == 0:
        return
    owner = subject.scene.patches.object[patch]
    n = len(subject.scene.objects)
    lonely, edges, place = _open_edges(subject.corners[patch], owner, n)
    faces = np.bincount(owner, minlength=n)
    is_body = (lonely > 0) & (lonely <= _MOST_OPEN * edges) & (faces >= _LEAST_FACES)
    is_body &= _bulge(subject, patch, owner, n) > 0.0
    for number in np.flatnonzero(is_body):
        name, corners = subject.scene.objects[number], subject.corners[patch[owner == number]].reshape(-1, 3)
        yield Finding(
            "open-body",
            "info",
            name,
            place[number],
            float(np.linalg.norm(np.ptp(corners, axis=0))),
            f"'{name}' is not closed: {lonely[number]} of its {edges[number]} edges have no second face, around "
            f"{at(place[number])}",
            "it isn't taken for a solid: light may get inside, and what it covers stays lit",
            "close it if it is meant to be a solid body",
            numbers(patch[owner == number]),
        )


def _open_edges(
    corners: NDArray[np.float64], owner: NDArray[np.int32], n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Of each object: edges with one face only, edges at all, and the middle of the former (n, 3)."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size = float(np.linalg.norm(high - low))
    vertex = weld(corners.reshape(-1, 3), _WELD * size).reshape(-1, 4)
    start, end = vertex, np.roll(vertex, -1, axis=1)
    real = start != end
    middle = (0.5 * (corners + np.roll(corners, -1, axis=1)))[real]
    belongs = np.repeat(owner[:, None], 4, axis=1)[real]
    n_vertices = int(vertex.max()) + 1
    ends = np.minimum(start, end)[real] * n_vertices + np.maximum(start, end)[real]
    order = np.lexsort((ends, belongs))
    new = (np.diff(ends[order], prepend=-1) != 0) | (np.diff(belongs[order], prepend=-1) != 0)
    first = np.flatnonzero(new)
    alone = np.diff(np.append(first, len(order))) == 1
    edge = order[first]
    lonely = np.bincount(belongs[edge[alone]], minlength=n)
    total = np.stack([np.bincount(belongs[edge[alone]], middle[edge[alone], k], minlength=n) for k in range(3)], axis=1)
    return lonely, np.bincount(belongs[edge], minlength=n), total / np.maximum(lonely, 1)[:, None]


def _bulge(subject: Subject, patch: NDArray[np.int64], owner: NDArray[np.int32], n: int) -> NDArray[np.float64]:
    """(n,) for each object the sum of area × distance in front of its middle: above 0 when faces point outwards."""
    centroid, area = subject.centroid[patch], subject.area[patch]
    total = np.maximum(np.bincount(owner, area, minlength=n), np.finfo(float).tiny)
    middle = np.stack([np.bincount(owner, area * centroid[:, k], minlength=n) for k in range(3)], axis=1)
    out = np.einsum("ij,ij->i", centroid - (middle / total[:, None])[owner], subject.normal[patch])
    return np.bincount(owner, area * out, minlength=n).astype(np.float64)


def _black_backs(subject: Subject) -> Iterator[Finding]:
    """One-sided materials whose black back is in the light; a fault where their fronts are in the dark and it counts.

    Then the paint is never seen: the faces look the wrong way.
    """
    seen = subject.lit.lit[:, BACK] & ~subject.reflects_behind
    reversed_ = seen & ~subject.lit.lit[:, FRONT]
    reversed_[np.flatnonzero(reversed_)] = _front_in_the_dark(subject, np.flatnonzero(reversed_))
    reversed_ &= _share_of_space(subject, reversed_) >= _COUNTS
    owner = subject.scene.patches.object
    for faces, finding in ((reversed_, _reversed), (seen & ~reversed_, _black_back)):
        patch = np.flatnonzero(faces)
        for number in np.unique(owner[patch]):
            yield finding(subject, patch[owner[patch] == number])


def _front_in_the_dark(subject: Subject, patch: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether no ray from the front of a patch meets a lit side, by more rays than the lit sides are found with."""
    rng = subject.random(_STREAM)
    start = points_on(subject, np.repeat(patch, _RAYS), rng) + subject.offset * np.repeat(
        subject.normal[patch], _RAYS, axis=0
    )
    way = cosine_directions(rng, subject.normal[patch], _RAYS).reshape(-1, 3)
    hits = trace(subject, start, way, np.repeat(patch, _RAYS).astype(np.int32))
    return np.asarray((outcome_of(subject, hits, way) != LIT).reshape(-1, _RAYS).all(axis=1))


def _share_of_space(subject: Subject, patches: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(n,) which share of the lit area of the space behind each patch the marked patches have with their backs."""
    space = subject.lit.space
    n = len(subject.lit.open)
    sides = space >= 0
    total = np.bincount(space[sides], np.broadcast_to(subject.area[:, None], space.shape)[sides], n)
    marked = patches & sides[:, BACK]
    own = np.bincount(space[marked, BACK], subject.area[marked], n)
    share = np.divide(own, total, out=np.zeros(n), where=total > 0.0)
    return np.where(sides[:, BACK], np.append(share, 0.0)[space[:, BACK]], 0.0)


def _reversed(subject: Subject, faces: NDArray[np.int64]) -> Finding:
    """Faces of one object that look the wrong way."""
    name, place, material, area = _largest(subject, faces)
    count = "1 face" if len(faces) == 1 else f"{len(faces)} faces"
    return Finding(
        "reversed-faces",
        "fault",
        name,
        place,
        float(np.sqrt(area)),
        f"{count} of '{name}' ({area:.3g} m²), the largest at {at(place)}, have the one-sided material '{material}' on "
        "their front, which is in the dark, and light on their back",
        "their paint would never be seen, and their backs are black",
        "turn the faces round (check --repair does), or make the material two-sided",
        numbers(faces),
    )


def _black_back(subject: Subject, faces: NDArray[np.int64]) -> Finding:
    """Faces of one object whose back is seen as well."""
    name, place, material, area = _largest(subject, faces)
    return Finding(
        "black-back",
        "warning",
        name,
        place,
        float(np.sqrt(area)),
        f"light reaches {area:.3g} m² of the back of '{name}' at {at(place)}, and its material '{material}' "
        "is one-sided",
        "the back is black and absorbs that light",
        "turn the faces round, or make the material two-sided",
        numbers(faces),
    )


def _largest(subject: Subject, faces: NDArray[np.int64]) -> tuple[str, NDArray[np.float64], str, float]:
    """Object, place and material of the largest of some faces, and the area of all."""
    area = subject.area[faces]
    worst = int(faces[area.argmax()])
    material = subject.scene.materials[int(subject.scene.patches.material[worst])].name
    return subject.name(worst), subject.centroid[worst], material, float(area.sum())
