"""Faces that single precision can't hold well: slivers, tiny faces, parts far off."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.check.finding import Finding, at, numbers
from hradiosity.space.check.subject import Subject

SLIVER = 1e3
"""Length over width from which a face is a sliver."""
TINY = 1e-5
"""Edge of a square of equal area over the scene's size, below which a face is tiny."""
RATIO = 1e6
"""Size of the scene over the width of its narrowest face from which sizes are too different."""
UNRESOLVED = 1e-3
"""Step of single precision coordinates over the width of a face, above which its shape is lost."""
FAR = 30.0
"""A part is far off when it is farther from the middle than this many radii of the central three quarters."""
_CENTRAL = 0.75
_STEP = 2.0**-23


def shape_findings(subject: Subject) -> Iterator[Finding]:
    """Slivers, tiny faces, faces finer than coordinates, parts that are far off and a range of sizes too wide."""
    sliver = subject.longest_edge > SLIVER * subject.height
    yield from _slivers(subject, sliver)
    yield from _tiny(subject, ~sliver)
    yield from _far_parts(subject)
    yield from _unresolved(subject, ~sliver)
    yield from _ratio(subject, ~sliver)


def _of_objects(
    subject: Subject, faulty: NDArray[np.bool_], badness: NDArray[np.float64]
) -> Sequence[NDArray[np.int64]]:
    """The faulty patches of each object that has any, the worst one first."""
    patch = np.flatnonzero(faulty)
    owner = subject.scene.patches.object[patch]
    order = np.lexsort((-badness[patch], owner))
    return np.split(patch[order], np.flatnonzero(np.diff(owner[order])) + 1) if len(patch) else []


def _faces(count: int) -> str:
    return "1 face" if count == 1 else f"{count} faces"


def _slivers(subject: Subject, sliver: NDArray[np.bool_]) -> Iterator[Finding]:
    aspect = subject.longest_edge / np.maximum(subject.height, np.finfo(float).tiny)
    for mine in _of_objects(subject, sliver, aspect):
        worst, count = int(mine[0]), len(mine)
        place, name = subject.centroid[worst], subject.name(worst)
        yield Finding(
            "sliver",
            "warning",
            name,
            place,
            float(subject.longest_edge[worst]),
            f"{_faces(count)} of '{name}' more than {SLIVER:g} times as long as wide, the worst "
            f"{subject.longest_edge[worst]:.3g} m × {subject.height[worst]:.2g} m at {at(place)}",
            "light on such faces is inaccurate, and rays may slip past them",
            "merge them with their neighbours before exporting",
            numbers(mine),
        )


def _tiny(subject: Subject, candidates: NDArray[np.bool_]) -> Iterator[Finding]:
    edge = np.sqrt(subject.area)
    for mine in _of_objects(subject, candidates & (edge < TINY * subject.size), -edge):
        worst, count = int(mine[0]), len(mine)
        place, name = subject.centroid[worst], subject.name(worst)
        yield Finding(
            "tiny-face",
            "info",
            name,
            place,
            float(edge[worst]),
            f"{_faces(count)} of '{name}' tiny beside the scene: {1e3 * edge[worst]:.2g} mm at {at(place)}",
            "each costs as much time as a wall and changes next to nothing",
            "leave such detail out",
            numbers(mine),
        )


def _far_parts(subject: Subject) -> Iterator[Finding]:
    """Objects whose nearest point is far from where nearly everything is."""
    middle = np.median(subject.corners.reshape(-1, 3), axis=0)
    low, high = subject.corners.min(axis=1), subject.corners.max(axis=1)
    near = np.linalg.norm(np.maximum(np.maximum(low - middle, middle - high), 0.0), axis=1)
    central = np.linalg.norm(subject.centroid - middle, axis=1)
    radius = max(float(np.quantile(central, _CENTRAL, method="lower")), float(np.median(subject.longest_edge)))
    n_objects = len(subject.scene.objects)
    nearest = np.full(n_objects, np.inf)
    np.minimum.at(nearest, subject.scene.patches.object, near)
    for number in np.flatnonzero(np.isfinite(nearest) & (nearest > FAR * radius)):
        own = np.flatnonzero(subject.scene.patches.object == number)
        place, name = subject.centroid[own].mean(axis=0), subject.scene.objects[number]
        yield Finding(
            "far-part",
            "warning",
            name,
            place,
            float(nearest[number]),
            f"'{name}' is {nearest[number]:.3g} m from the rest of the scene, which has a radius of {radius:.3g} m",
            f"it enlarges the scene, so that rays resolve no more than {1e3 * subject.offset:.2g} mm",
            "delete it or bring it nearer: it may be a leftover of the drawing",
            numbers(own),
        )


def _unresolved(subject: Subject, candidates: NDArray[np.bool_]) -> Iterator[Finding]:
    local = np.abs(subject.corners - subject.bvh.local_origin).max(axis=(1, 2))
    lost = _STEP * local / np.maximum(subject.height, np.finfo(float).tiny)
    for mine in _of_objects(subject, candidates & (lost > UNRESOLVED), lost):
        worst, count = int(mine[0]), len(mine)
        place, name = subject.centroid[worst], subject.name(worst)
        yield Finding(
            "unresolved-detail",
            "warning",
            name,
            place,
            float(subject.height[worst]),
            f"{_faces(count)} of '{name}' finer than coordinates can hold in a scene of {subject.size:.3g} m: "
            f"{1e3 * subject.height[worst]:.2g} mm wide at {at(place)}, coordinates there have steps of "
            f"{1e3 * _STEP * local[worst]:.1g} mm",
            f"their shape is off by up to {100 * min(lost[worst], 1.0):.1g} %",
            "leave out what is far away, or such detail",
            numbers(mine),
        )


def _ratio(subject: Subject, candidates: NDArray[np.bool_]) -> Iterator[Finding]:
    narrow = np.where(candidates, subject.height, np.inf)
    worst = int(narrow.argmin())
    if subject.size <= RATIO * narrow[worst]:
        return
    widest = int(subject.longest_edge.argmax())
    place = subject.centroid[worst]
    yield Finding(
        "size-range",
        "warning",
        subject.name(worst),
        place,
        float(narrow[worst]),
        f"'{subject.name(worst)}' has a face {1e3 * narrow[worst]:.2g} mm wide at {at(place)}, in a scene of "
        f"{subject.size:.3g} m ('{subject.name(widest)}' is {subject.longest_edge[widest]:.3g} m long): a ratio above "
        f"{RATIO:g}",
        "such detail is lost in single precision",
        "is a unit wrong? leave one of the two out",
        (worst,),
    )
