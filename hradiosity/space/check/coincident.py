"""Surfaces in one place: duplicates, lamps in the plane of a ceiling, sheets modelled twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, FRONT
from hradiosity.space.check.finding import Finding, Severity, at, numbers
from hradiosity.space.check.subject import Subject
from hradiosity.space.coplanar import Coplanar, coplanar_pairs

_WHOLE = 0.99
"""Common share of both areas from which two faces are one and the same."""
DUPLICATE, LAMP, SAME, CONTRARY, SHEET = range(5)
"""What two surfaces in one place are: the keys of `WORDS`."""


class _Words(NamedTuple):
    kind: str
    severity: Severity
    what: str
    effect: str
    fix: str


WORDS = {
    DUPLICATE: _Words(
        "duplicate-faces",
        "warning",
        "are the same faces twice",
        "both reflect the same light, and rays meet only one of them",
        "delete one of the two",
    ),
    LAMP: _Words(
        "lamp-in-surface",
        "warning",
        "lie in one plane and face the same way, and one of them is a lamp",
        "the lamp may be hidden by the surface, and pictures show patches of both",
        "move the lamp 1 mm off the surface, or cut the surface out around it",
    ),
    SAME: _Words(
        "coincident-surfaces",
        "warning",
        "lie in one plane and face the same way",
        "which of them a ray meets is left to rounding (z-fighting)",
        "move one by 1 mm, or cut it where they overlap",
    ),
    CONTRARY: _Words(
        "coincident-back-to-back",
        "info",
        "lie in one plane back to back and differ",
        "a run moves each a few millionths of the scene to the side of its own object, or to where it faces",
        "if that is the wrong side: give the wall a thickness",
    ),
    SHEET: _Words(
        "sheet-modelled-twice",
        "info",
        "are a sheet modelled by two equal faces back to back",
        "the second face costs time and changes nothing",
        "keep one of them: materials reflect on both sides",
    ),
}


def coincident_findings(subject: Subject) -> Iterator[Finding]:
    """One finding for each pair of objects with surfaces in one place that light reaches."""
    pairs, seen, case = lit_pairs(subject)
    owner = subject.scene.patches.object.astype(np.int64)
    a, b = owner[pairs.first[seen]], owner[pairs.second[seen]]
    n = len(subject.scene.objects)
    key = (case * n + np.minimum(a, b)) * n + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    for same in np.split(order, np.flatnonzero(np.diff(key[order])) + 1) if len(seen) else []:
        yield _finding(subject, pairs, seen[same], WORDS[int(case[same[0]])])


def lit_pairs(subject: Subject) -> tuple[Coplanar, NDArray[np.int64], NDArray[np.int64]]:
    """All pairs of patches in one place; which of them light reaches; and the case of each of these, as in `WORDS`."""
    pairs = coplanar_pairs(subject.scene.patches)
    seen = np.flatnonzero(_compete(subject, pairs))
    return pairs, seen, _case(subject, pairs)[seen]


def smaller_of(subject: Subject, pairs: Coplanar) -> NDArray[np.int64]:
    """(m,) the smaller patch of each pair; of equal ones the second."""
    first_is_smaller = subject.area[pairs.first] < (1.0 - 1e-9) * subject.area[pairs.second]
    return np.where(first_is_smaller, pairs.first, pairs.second)


def _compete(subject: Subject, pairs: Coplanar) -> NDArray[np.bool_]:
    """(m,) both patches show a lit side in one direction.

    Matter behind one of them covers that direction: a box on a floor, two boxes that touch.
    """
    solid = subject.scene.patches.solid >= 0
    lit = subject.lit.lit
    compete = np.zeros(len(pairs.first), np.bool_)
    for side in (FRONT, BACK):
        other = np.where(pairs.same_facing, side, 1 - side)
        matter = (solid[pairs.first] & (side == BACK)) | (solid[pairs.second] & (other == BACK))
        compete |= ~matter & lit[pairs.first, side] & lit[pairs.second, other]
    return compete


def _case(subject: Subject, pairs: Coplanar) -> NDArray[np.int64]:
    """(m,) which of the cases in `WORDS`."""
    first, second = pairs.first, pairs.second
    whole = pairs.area >= _WHOLE * np.maximum(subject.area[first], subject.area[second])
    lamp = subject.emits[first] | subject.emits[second]
    material = subject.scene.patches.material
    unlike = (material[first] != material[second]) | ~subject.reflects_behind[first] | lamp
    alike = ~lamp | (subject.emits[first] & subject.emits[second])
    same = np.where(whole & alike, DUPLICATE, np.where(lamp, LAMP, SAME))
    return np.where(pairs.same_facing, same, np.where(unlike, CONTRARY, SHEET))


def _finding(subject: Subject, pairs: Coplanar, rows: NDArray[np.int64], words: _Words) -> Finding:
    """All overlaps of two objects as one finding, at the largest."""
    worst = rows[pairs.area[rows].argmax()]
    one, two = subject.name(int(pairs.first[worst])), subject.name(int(pairs.second[worst]))
    both = f"'{one}' and '{two}'" if one != two else f"faces of '{one}'"
    area, place = float(pairs.area[rows].sum()), pairs.place[worst]
    count = f" in {len(rows)} pairs of faces" if len(rows) > 1 else ""
    message = f"{both} {words.what}: {area:.3g} m²{count}, the largest at {at(place)}"
    size = float(np.sqrt(pairs.area[worst]))
    patches = numbers(smaller_of(subject, pairs)[rows])
    return Finding(words.kind, words.severity, one, place, size, message, words.effect, words.fix, patches)
