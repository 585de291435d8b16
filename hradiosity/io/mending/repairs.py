"""From findings to changes of a scene: what can be put right without asking, and how."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.mending.scene_copy import CannotMend, SceneCopy
from hradiosity.io.mending.stitching import open_edges, stitched
from hradiosity.model.geometry import NONE
from hradiosity.model.solids import find_solids
from hradiosity.space.check import Finding, Subject
from hradiosity.space.check.coincident import DUPLICATE, LAMP, SHEET, WORDS, lit_pairs, smaller_of
from hradiosity.space.check.finding import at
from hradiosity.space.coplanar import Coplanar

APART: Final = 1e-3
"""How far surfaces in one place are moved apart [m], in scenes up to 250 m."""
_APART_IN_LARGE: Final = 4e-6
"""The same over the size of larger scenes: four times what counts as one place."""
WIDEST_CRACK: Final = 1e-3
"""Cracks up to this width are closed, and slivers up to it taken out [m]."""
_WIDTHS: Final = (1e-6, 1e-5, 1e-4)
"""Widths over an object's size that are tried first; the least one that closes it is taken."""
_FLAT: Final = 1e-6
_AREA_KEPT: Final = 1e-2
"""Share of the area that closing cracks between objects may change."""


@dataclass(frozen=True)
class Repair:
    """One change.

    kind : of the finding that it mends
    objects : that it is about
    done : in words
    apply : makes the change and names the object that it changed; raises `CannotMend` where there is no safe one
    """

    kind: str
    objects: tuple[str, ...]
    done: str
    apply: Callable[[SceneCopy], str]


def repairs(subject: Subject, findings: Sequence[Finding]) -> Iterator[Repair]:
    """Changes for all findings that can be mended, those that leave something out first."""
    yield from _coincident(subject)
    for finding in findings:
        turned_lamp = finding.kind == "lamp-turned-away" and _is_sheet(subject, finding.object)
        if finding.kind in ("inside-out", "reversed-faces") or turned_lamp:
            own = _local(subject, finding.object, np.array(finding.patches, dtype=np.int64))
            total = int(np.count_nonzero(subject.scene.patches.object == subject.scene.objects.index(finding.object)))
            what = "the" if len(own) == total else f"{len(own)} of the {total}"
            done = f"turned {what} faces of '{finding.object}' round"
            change = partial(_turn, name=finding.object, patches=own, total=total)
            yield Repair(finding.kind, (finding.object,), done, change)
    for finding in findings:
        if finding.kind in ("open-body", "leak", "sliver"):
            what = "took slivers out of" if finding.kind == "sliver" else "closed cracks of"
            done = f"{what} '{finding.object}'"
            change = partial(_stitch, name=finding.object, slivers=_sliver_width(subject, finding))
            if finding.kind == "leak":
                change = partial(_close_together, name=finding.object)
            yield Repair(finding.kind, (finding.object,), done, change)


def _coincident(subject: Subject) -> Iterator[Repair]:
    """One repair for each pair of objects that have surfaces in one place."""
    pairs, seen, case = lit_pairs(subject)
    owner = subject.scene.patches.object.astype(np.int64)
    a, b = owner[pairs.first[seen]], owner[pairs.second[seen]]
    n = len(subject.scene.objects)
    key = (case * n + np.minimum(a, b)) * n + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    for same in np.split(order, np.flatnonzero(np.diff(key[order])) + 1) if len(seen) else []:
        kind = int(case[same[0]])
        rows = seen[same]
        if kind in (DUPLICATE, SHEET):
            yield _left_out(subject, pairs, rows, kind)
        else:
            yield _moved(subject, pairs, rows, kind)


def _left_out(subject: Subject, pairs: Coplanar, rows: NDArray[np.int64], kind: int) -> Repair:
    """One of two equal faces goes: of the later object, unless a sensor lies on it."""
    owner = subject.scene.patches.object
    first, second = (subject.name(int(side[rows[0]])) for side in (pairs.first, pairs.second))
    gone = np.unique(smaller_of(subject, pairs)[rows] if first == second else pairs.second[rows])
    other = np.unique(pairs.first[rows])

    def apply(scene: SceneCopy) -> str:
        chosen, name = gone, subject.name(int(gone[0]))
        if first != second and (scene.is_read_by_sensors(second) or len(np.unique(owner[gone])) > 1):
            chosen, name = other, first
        if len(np.unique(owner[chosen])) > 1 or (first != second and scene.is_read_by_sensors(name)):
            raise CannotMend("a sensor lies on it")
        total = int((owner == owner[chosen[0]]).sum())
        is_solid = bool((subject.scene.patches.solid[chosen] != NONE).any())
        if len(chosen) < total and is_solid:
            raise CannotMend(f"'{name}' would no longer be solid")
        scene.drop(name, _local(subject, name, chosen), total)
        return name

    count = "1 face" if len(gone) == 1 else f"{len(gone)} faces"
    done = f"left out {count} of '{second}' that lie on faces of '{first}', the first at {at(pairs.place[rows[0]])}"
    return Repair(WORDS[kind].kind, (first, second), done, apply)


def _moved(subject: Subject, pairs: Coplanar, rows: NDArray[np.int64], kind: int) -> Repair:
    """One of two objects is shifted along the normal of its face: the lamp, else the smaller one."""
    worst = rows[pairs.area[rows].argmax()]
    patches = [int(pairs.first[worst]), int(pairs.second[worst])]
    area = np.bincount(subject.scene.patches.object, subject.area, minlength=len(subject.scene.objects))
    patches.sort(key=lambda patch: float(area[subject.scene.patches.object[patch]]))
    if kind == LAMP:
        patches.sort(key=lambda patch: not subject.emits[patch])
    names = [subject.name(patch) for patch in patches]
    distance = max(APART, _APART_IN_LARGE * subject.size)

    def apply(scene: SceneCopy) -> str:
        if names[0] == names[1]:
            raise CannotMend("both faces belong to one object")
        for patch, name in zip(patches, names, strict=True):
            if _is_sheet(subject, name) or _is_closed(subject, name):
                scene.move(name, distance * subject.normal[patch])
                return name
        raise CannotMend("neither is a sheet or a closed body that could be moved as a whole")

    done = f"moved '{names[0]}' by {1e3 * distance:g} mm off '{names[1]}', at {at(pairs.place[worst])}"
    return Repair(WORDS[kind].kind, (names[0], names[1]), done, apply)


def _turn(scene: SceneCopy, *, name: str, patches: NDArray[np.int64], total: int) -> str:
    """Let faces of an object look the other way."""
    if len(patches) < total and not scene.is_mesh(name):
        raise CannotMend("only some of its faces look the wrong way")
    scene.turn(name, patches)
    return name


def _stitch(scene: SceneCopy, *, name: str, slivers: float) -> str:
    """Close a mesh object, or take its slivers out."""
    if not scene.is_mesh(name):
        raise CannotMend("its corners stand in the scene file")
    scene.reshape([name], partial(_better, slivers=slivers))
    return name


def _close_together(scene: SceneCopy, *, name: str) -> str:
    """Close a room, alone or, where its walls are objects of their own, with all others of its mesh."""
    if not scene.is_mesh(name):
        raise CannotMend("its corners stand in the scene file")
    try:
        scene.reshape([name], partial(_better, slivers=0.0))
    except CannotMend:
        scene.reshape(scene.mesh_objects(name), _fewest_open)
    return name


def _fewest_open(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Triangles stitched by the least distance that leaves the fewest edges open.

    Raises
    ------
    CannotMend
        When no distance closes any, or surface would get lost.
    """
    size = float(np.linalg.norm(np.ptp(points[triangles.ravel()], axis=0)))
    best, fewest = None, len(open_edges(stitched(points, triangles, 1e-9 * size)[1])[0])
    for width in sorted({min(width * size, WIDEST_CRACK) for width in (*_WIDTHS, 1.0)}):
        new = stitched(points, triangles, width)
        number = len(open_edges(new[1])[0])
        if number < fewest and abs(_area(*new[:2]) / _area(points, triangles) - 1.0) < _AREA_KEPT:
            best, fewest = new, number
    if best is None:
        raise CannotMend(f"its gaps are wider than {1e3 * WIDEST_CRACK:.2g} mm or no cracks")
    return best


def _better(
    points: NDArray[np.float64], triangles: NDArray[np.int64], slivers: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Triangles without open edges, by the least distance that does it; else without slivers only.

    Raises
    ------
    CannotMend
        When neither gets better.
    """
    size = float(np.linalg.norm(np.ptp(points[triangles.ravel()], axis=0)))
    widths = [width * size for width in _WIDTHS if slivers < width * size < WIDEST_CRACK]
    most = min(WIDEST_CRACK, 1e-2 * size)
    for width in ([1.01 * slivers] if slivers > 0.0 else []) + widths + [most]:
        new = stitched(points, triangles, width)
        if len(new[1]) and not len(open_edges(new[1])[0]) and _area(*new[:2]) > 0.5 * _area(points, triangles):
            return new
    if slivers > 0.0:
        new = stitched(points, triangles, 1.01 * slivers)
        if len(open_edges(new[1])[0]) <= len(open_edges(triangles)[0]):
            return new
    raise CannotMend(f"its gaps are wider than {1e3 * most:.2g} mm or no cracks")


def _area(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> float:
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _sliver_width(subject: Subject, finding: Finding) -> float:
    """Height of the widest sliver of a finding [m]; 0 if there is none that may go."""
    if finding.kind != "sliver":
        return 0.0
    own = np.array(finding.patches, dtype=np.int64)
    own = own[subject.scene.patches.is_triangle[own] & (subject.height[own] <= WIDEST_CRACK)]
    return float(subject.height[own].max(initial=0.0))


def _local(subject: Subject, name: str, patches: NDArray[np.int64]) -> NDArray[np.int64]:
    """Places of patches among those of their object."""
    own = np.flatnonzero(subject.scene.patches.object == subject.scene.objects.index(name))
    return np.searchsorted(own, np.unique(patches)).astype(np.int64)


def _is_sheet(subject: Subject, name: str) -> bool:
    """Whether all faces of an object lie in one plane and face the same way."""
    own = np.flatnonzero(subject.scene.patches.object == subject.scene.objects.index(name))
    normal = subject.normal[own]
    height = (subject.corners[own] - subject.corners[own[0], 0]) @ normal[0]
    return bool((normal @ normal[0] > 1.0 - _FLAT).all() and np.abs(height).max() <= _FLAT * subject.size)


def _is_closed(subject: Subject, name: str) -> bool:
    """Whether all faces of an object belong to closed shells, whichever way they face."""
    patches = subject.scene.patches
    own = np.flatnonzero(patches.object == subject.scene.objects.index(name))
    shells = find_solids(subject.corners[own], patches.is_triangle[own], patches.object[own])
    return bool(((shells.solid != NONE) | (shells.inward != NONE)).all())
