"""Lamps whose light does not get into the room."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, FRONT, NONE
from hradiosity.space.check.finding import Finding, at, numbers
from hradiosity.space.check.inside import enclosing_solids
from hradiosity.space.check.probe import Views, cosine_directions, directions, look, most_frequent, points_on, trace
from hradiosity.space.check.subject import Subject

COVERED_WITHIN = 1e-3
"""A surface nearer than this in front of a lamp takes its light [m]."""
_POINTS = 32
_RAYS_OF_POINT = 128
_MOST = 0.5
"""Share of points or rays from which the whole lamp is concerned."""
_LOST = 0.01
"""Share of a lamp's light that may go into covered parts without a word."""
_MARGIN = 1e-3
_STREAM = 21


@dataclass(frozen=True)
class _Faces:
    """Shining faces of area lamps, each with `_POINTS` points on it.

    object : (n,) int64
    patch : (n,) int64
    area : (n,) float64, shining area [m²]
    inside : (n,) share of the points that lie inside a solid
    covered : (n,) share of the points with a surface right in front
    escapes : (n,) share of the light that leaves the scene
    room_behind : (n,) share of rays to the other side that meet something; 0 for lamps that shine to both sides
    culprit : (n,) int64, object of the solid or of the covering surface; NONE if there is none
    """

    object: NDArray[np.int64]
    patch: NDArray[np.int64]
    area: NDArray[np.float64]
    inside: NDArray[np.float64]
    covered: NDArray[np.float64]
    escapes: NDArray[np.float64]
    room_behind: NDArray[np.float64]
    culprit: NDArray[np.int64]


def lamp_findings(subject: Subject) -> Iterator[Finding]:
    """Lamps inside solids, lamps covered by a surface, lamps with their back to the room, lamps without power."""
    yield from _point_sources(subject)
    yield from _area_lamps(subject)
    emitters = subject.scene.emitters
    for number in np.unique(emitters.luminaire):
        lamp = subject.scene.luminaires[number]
        if not lamp.exitance.any() and not lamp.intensity.any():
            place = emitters.position[np.flatnonzero(emitters.luminaire == number)[0]]
            message = f"luminaire '{lamp.name}' gives no light in any band"
            yield Finding(
                "lamp-off", "warning", lamp.name, place, 0.0, message, "it lights nothing", "look at its flux"
            )


def _point_sources(subject: Subject) -> Iterator[Finding]:
    """Points inside solids."""
    source = np.flatnonzero(subject.scene.emitters.patch == NONE)
    if len(source) == 0:
        return
    position = subject.scene.emitters.position[source]
    views = look(subject, position, directions(subject.random(_STREAM), len(source), _RAYS_OF_POINT))
    solid = enclosing_solids(subject, position, views)
    for row in np.flatnonzero(solid != NONE):
        lamp = subject.scene.luminaires[int(subject.scene.emitters.luminaire[source[row]])].name
        yield _in_solid(
            f"a point source with luminaire '{lamp}'", lamp, position[row], 0.0, subject.name_of_solid(int(solid[row]))
        )


def _name(subject: Subject, number: int) -> str:
    return subject.scene.objects[number]


def _in_solid(what: str, name: str, place: NDArray[np.float64], size: float, solid: str) -> Finding:
    return Finding(
        "lamp-in-solid",
        "fault",
        name,
        place,
        size,
        f"{what} is inside '{solid}', at {at(place)}",
        "its light gets nowhere",
        f"move it out; or turn the faces of '{solid}' inwards if it is the room (a box: `inside = true`)",
    )


def _area_lamps(subject: Subject) -> Iterator[Finding]:
    """Findings of area lamps, one of each sort for each object."""
    if not subject.emits.any():
        return
    faces = _trace_faces(subject)
    lost = np.maximum(faces.inside, faces.covered)
    order = np.argsort(faces.object, kind="stable")
    for mine in np.split(order, np.flatnonzero(np.diff(faces.object[order])) + 1):
        area = faces.area[mine]
        worst = int(mine[(area * lost[mine]).argmax()])
        name, place = _name(subject, int(faces.object[worst])), subject.centroid[faces.patch[worst]]
        size = float(np.sqrt(area.sum()))
        share = float((area * lost[mine]).sum() / area.sum())
        in_solid = float((area * faces.inside[mine]).sum() / area.sum())
        patches = numbers(faces.patch[mine])
        away = bool(((faces.escapes[mine] > 0.99) & (faces.room_behind[mine] > _MOST)).all())
        if in_solid > 0.99:
            solid = _name(subject, int(faces.culprit[worst]))
            yield replace(_in_solid(f"lamp '{name}'", name, place, size, solid), patches=patches)
        elif share > _LOST and faces.culprit[worst] != NONE:
            into = _name(subject, int(faces.culprit[worst]))
            yield replace(_partly_lost(name, place, size, share, into), patches=patches)
        elif away:
            yield Finding(
                "lamp-turned-away",
                "warning",
                name,
                place,
                size,
                f"lamp '{name}' at {at(place)} has its back to the room: all of its light leaves the scene",
                "it lights nothing",
                "turn it round: it shines where the normal of its face points",
                patches,
            )


def _partly_lost(name: str, place: NDArray[np.float64], size: float, share: float, into: str) -> Finding:
    return Finding(
        "lamp-covered",
        "warning",
        name,
        place,
        size,
        f"{100 * share:.3g} % of the light of lamp '{name}' goes straight into '{into}', which covers it: {at(place)}",
        "that light is lost, and the flux in the room is smaller by it",
        "move the lamp off the surface, or let only its free faces shine",
    )


def _trace_faces(subject: Subject) -> _Faces:
    """Rays from points on all shining faces, ahead and behind."""
    emitters = subject.scene.emitters
    area_lamp = emitters.patch != NONE
    both = np.array([lamp.two_sided for lamp in subject.scene.luminaires], np.bool_)[emitters.luminaire][area_lamp]
    front = emitters.patch[area_lamp].astype(np.int64)
    patch = np.concatenate([front, front[both]])
    side = np.concatenate([np.full(len(front), FRONT), np.full(int(both.sum()), BACK)])
    rng = subject.random(_STREAM + 1)
    normal = subject.normal[patch] * np.where(side == BACK, -1.0, 1.0)[:, None]
    point = points_on(subject, np.repeat(patch, _POINTS), rng, _MARGIN)
    facing = np.repeat(normal, _POINTS, axis=0)
    ahead = look(subject, point + subject.offset * facing, cosine_directions(rng, facing, 1))
    behind = trace(subject, point - subject.offset * facing, cosine_directions(rng, -facing, 1)[:, 0])
    covering = _covering(subject, point, facing, np.repeat(patch, _POINTS))
    shape = (len(patch), _POINTS)
    solid = _solids_around(subject, point + subject.offset * facing, ahead)
    owner = np.where(solid != NONE, subject.owner_of_solid[solid], subject.scene.patches.object[covering])
    owner = np.where((solid != NONE) | (covering != NONE), owner, NONE).reshape(shape)
    has_one_side = ~np.isin(patch, front[both])
    return _Faces(
        object=subject.scene.patches.object[patch].astype(np.int64),
        patch=patch,
        area=subject.area[patch],
        inside=(solid != NONE).reshape(shape).mean(axis=1),
        covered=(covering != NONE).reshape(shape).mean(axis=1),
        escapes=np.isinf(ahead.distance).reshape(shape).mean(axis=1),
        room_behind=np.where(has_one_side, (behind.patch != NONE).reshape(shape).mean(axis=1), 0.0),
        culprit=_culprits(owner),
    )


def _covering(
    subject: Subject, point: NDArray[np.float64], normal: NDArray[np.float64], patch: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Patch that lies within `COVERED_WITHIN` straight in front of each point, or NONE.

    Rays start a little behind the lamp's face, so that a surface in contact with it is met too. One that faces the same
    way in the same plane is not in front of it but in its place: `coincident` names that.
    """
    back = 4.0 * subject.offset
    hits = trace(subject, point - back * normal, normal, patch.astype(np.int32))
    distance = hits.t.astype(np.float64) - back
    met = hits.patch
    against = np.einsum("ij,ij->i", subject.normal[np.maximum(met, 0)], normal) < 0.0
    covers = (met != NONE) & (distance < COVERED_WITHIN) & (against | (distance > subject.offset))
    return np.where(covers, met, NONE).astype(np.int32)


def _solids_around(subject: Subject, point: NDArray[np.float64], ahead: Views) -> NDArray[np.int64]:
    """(n,) solid around each point, or NONE; `_POINTS` points at a time share what their rays met."""
    pooled = Views(
        outcome=np.repeat(ahead.outcome.reshape(-1, _POINTS), _POINTS, axis=0),
        patch=np.repeat(ahead.patch.reshape(-1, _POINTS), _POINTS, axis=0),
        side=np.repeat(ahead.side.reshape(-1, _POINTS), _POINTS, axis=0),
        distance=np.repeat(ahead.distance.reshape(-1, _POINTS), _POINTS, axis=0),
        direction=np.repeat(ahead.direction.reshape(-1, _POINTS, 3), _POINTS, axis=0),
    )
    return enclosing_solids(subject, point, pooled)


def _culprits(owner: NDArray[np.integer]) -> NDArray[np.int64]:
    """(n,) most frequent of the objects (n, k); NONE where there are none."""
    culprit = np.full(len(owner), NONE, np.int64)
    for row in np.flatnonzero((owner != NONE).any(axis=1)):
        culprit[row] = most_frequent(owner[row][owner[row] != NONE])
    return culprit
