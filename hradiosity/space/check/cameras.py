"""Cameras that see nothing: inside solids, inside walls, in the dark."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.scene import View
from hradiosity.space.check.finding import Finding, Severity, at
from hradiosity.space.check.inside import enclosing_solids
from hradiosity.space.check.probe import LIT, MISSED, Views, directions, look
from hradiosity.space.check.subject import Subject

_RAYS = 512
_MOST = 0.5
_WALL = 0.5
"""A dark gap that is somewhere narrower than this is the inside of a wall [m]."""
_STREAM = 11


def camera_findings(subject: Subject) -> Iterator[Finding]:
    """Cameras inside solids or walls (faults), and cameras that see nothing lit (warnings)."""
    views = subject.scene.views
    if not views:
        return
    around = directions(subject.random(_STREAM), len(views), _RAYS // 2)
    around = np.concatenate([around, -around], axis=1)
    position = np.array([view.position for view in views])
    seen = look(subject, position, around)
    ahead = look(subject, position, _ahead(subject, views))
    solid = enclosing_solids(subject, position, seen)
    for number, view in enumerate(views):
        if solid[number] != NONE:
            name = subject.name_of_solid(int(solid[number]))
            fix = f"move it out of '{name}', or turn the faces of '{name}' if it is the room"
            yield _finding(view, "camera-in-solid", "fault", f"is inside '{name}'", fix)
        elif ahead.share(LIT)[number] > 0.0:
            continue
        elif seen.share(MISSED)[number] < _MOST and (width := _width(seen, number)) < _WALL:
            near = np.argsort(seen.distance[number])[: _RAYS // 8]
            names = {subject.name(int(p)) for p in seen.patch[number][near] if p >= 0}
            walls = " and ".join(f"'{name}'" for name in sorted(names)[:2])
            what = f"is inside a wall or gap {width:.2g} m wide, between faces of {walls}, where no light gets"
            yield _finding(view, "camera-in-wall", "fault", what, "move it into the room")
        else:
            what = "sees nothing that light reaches"
            yield _finding(view, "camera-dark", "warning", what, "move it into the room, or turn it")


def _ahead(subject: Subject, views: tuple[View, ...]) -> NDArray[np.float64]:
    """(n, k, 3) directions within each picture, uniform over it."""
    rng = subject.random(_STREAM + 1)
    rays = np.empty((len(views), _RAYS, 3))
    for number, view in enumerate(views):
        right = np.cross(view.direction, view.up)
        right /= np.linalg.norm(right)
        up = np.cross(right, view.direction)
        half = np.tan(np.radians(view.field_of_view) / 2.0)
        x, y = half * (2.0 * rng.random((2, _RAYS)) - 1.0)
        rays[number] = view.direction + x[:, None] * right + (view.height / view.width) * y[:, None] * up
    return rays


def _width(seen: Views, number: int) -> float:
    """Free length of the shortest line through the camera [m]; directions come in opposite pairs."""
    distance = seen.distance[number]
    return float((distance[: _RAYS // 2] + distance[_RAYS // 2 :]).min())


def _finding(view: View, kind: str, severity: Severity, what: str, fix: str) -> Finding:
    message = f"camera '{view.name}' at {at(view.position)} {what}"
    return Finding(kind, severity, view.name, view.position, 0.0, message, "its picture is black", fix)
