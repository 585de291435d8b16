"""Sensors that can't mean what they read: inside solids, covered, cut in two, turned round, in the dark."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Sensor
from hradiosity.space.check.finding import Finding, Severity, at
from hradiosity.space.check.inside import enclosing_solids
from hradiosity.space.check.probe import DARK, LIT, MISSED, Views, cosine_directions, look, most_frequent, trace
from hradiosity.space.check.subject import Subject
from hradiosity.space.visibility import trace_any

RAYS = 24
"""Rays from each reading."""
COVERED_WITHIN = 1e-3
"""A surface nearer than this in front of a reading covers it [m]."""
_MOST = 0.5
"""Share of rays that decides where a reading without light is."""
_STREAM = 1


@dataclass(frozen=True)
class SensorViews:
    """What all readings of a scene see.

    sensor : (n,) int64, the sensor each reading belongs to
    position, normal : (n, 3) float64
    views : Views of the readings, cosine distributed
    """

    sensor: NDArray[np.int64]
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    views: Views


@dataclass(frozen=True)
class _Verdict:
    """What is wrong with some readings of a sensor, in words that follow the sensor's name."""

    kind: str
    severity: Severity
    what: str
    effect: str
    fix: str


def look_from_sensors(subject: Subject) -> SensorViews:
    """Trace `RAYS` rays from each reading, as far off it as rays of the solver start."""
    sensors = subject.scene.sensors
    position = np.concatenate([np.zeros((0, 3)), *(s.position for s in sensors)])
    normal = np.concatenate([np.zeros((0, 3)), *(s.normal for s in sensors)])
    number = np.repeat(np.arange(len(sensors)), [len(s.position) for s in sensors])
    directions = cosine_directions(subject.random(_STREAM), normal, RAYS)
    return SensorViews(number, position, normal, look(subject, position + subject.offset * normal, directions))


def sensor_findings(subject: Subject, seen: SensorViews) -> Iterator[Finding]:
    """Readings inside solids, covered or cut in two by a surface, on the wrong side, outside, or in a dark space."""
    if len(seen.position) == 0:
        return
    solid = enclosing_solids(subject, seen.position + subject.offset * seen.normal, seen.views)
    inside = solid != NONE
    covered, cover, distance = _covered(subject, seen)
    covered &= ~inside
    cut = np.where(inside | covered, NONE, _crossing(subject, seen))
    dark = ~inside & ~covered & (seen.views.share(LIT) == 0.0)
    dark[dark] = ~_sees_lamp(subject, seen, np.flatnonzero(dark))
    behind = _looks_back(subject, seen, np.flatnonzero(dark))
    for number, sensor in enumerate(subject.scene.sensors):
        own = seen.sensor == number
        yield from _inside(subject, seen, sensor, np.flatnonzero(own & inside), solid)
        yield from _under(subject, seen, sensor, np.flatnonzero(own & covered), cover, distance)
        yield from _cut(subject, seen, sensor, np.flatnonzero(own & (cut != NONE)), cut)
        yield from _in_the_dark(seen, sensor, np.flatnonzero(own & dark), behind)


def _covered(subject: Subject, seen: SensorViews) -> tuple[NDArray[np.bool_], NDArray[np.int32], NDArray[np.float64]]:
    """Whether a surface lies straight in front within `COVERED_WITHIN`; which, and how far [m]."""
    hits = trace(subject, seen.position + subject.offset * seen.normal, seen.normal)
    distance = hits.t.astype(np.float64) + subject.offset
    return (hits.patch != NONE) & (distance < COVERED_WITHIN), hits.patch, distance


def _crossing(subject: Subject, seen: SensorViews) -> NDArray[np.int32]:
    """(all readings,) patch that passes through the place that a reading's rays start from, or NONE.

    Four short lines through that place, along the reading's own plane, meet it.
    """
    normal = seen.normal
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    place = seen.position + subject.offset * normal
    found = np.full(len(place), NONE, np.int32)
    for along, across in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)):
        way = 2.0 * subject.offset * (along * first + across * second)
        hits = trace(subject, place - 0.5 * way, way)
        found = np.where((found == NONE) & (hits.t <= 1.0), hits.patch, found)
    return found


def _sees_lamp(subject: Subject, seen: SensorViews, reading: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether the middle of some lamp is in front of a reading, shows its shining side, and nothing is between."""
    emitters, patches = subject.scene.emitters, subject.scene.patches
    n = len(emitters)
    if len(reading) == 0 or n == 0:
        return np.zeros(len(reading), np.bool_)
    origin = np.repeat(seen.position[reading] + subject.offset * seen.normal[reading], n, axis=0)
    to_lamp = np.tile(emitters.position, (len(reading), 1)) - origin
    in_front = np.einsum("ij,ij->i", to_lamp, np.repeat(seen.normal[reading], n, axis=0)) > 0.0
    both = np.array([lamp.two_sided for lamp in subject.scene.luminaires], np.bool_)[emitters.luminaire]
    facing = np.tile(patches.normal[np.maximum(emitters.patch, 0)], (len(reading), 1))
    shows = (np.einsum("ij,ij->i", to_lamp, facing) < 0.0) | np.tile(both | (emitters.patch == NONE), len(reading))
    ray = np.flatnonzero(in_front & shows)
    skip = np.tile(emitters.patch, len(reading))[ray]
    free = ~trace_any(subject.bvh, origin[ray], to_lamp[ray], 1.0, skip)
    sees = np.zeros(len(origin), np.bool_)
    sees[ray[free]] = True
    return np.asarray(sees.reshape(len(reading), n).any(axis=1))


def _looks_back(subject: Subject, seen: SensorViews, reading: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(all readings,) whether a dark one would see light if it were turned round."""
    turned = np.zeros(len(seen.position), np.bool_)
    if len(reading):
        normal = -seen.normal[reading]
        views = look(
            subject,
            seen.position[reading] + subject.offset * normal,
            cosine_directions(subject.random(_STREAM + 1), normal, RAYS),
        )
        turned[reading] = views.share(LIT) > _MOST
    return turned


def _inside(
    subject: Subject, seen: SensorViews, sensor: Sensor, bad: NDArray[np.int64], solid: NDArray[np.int64]
) -> Iterator[Finding]:
    """Readings inside solids: a fault when all are."""
    if len(bad) == 0:
        return
    name = subject.name_of_solid(most_frequent(solid[bad]))
    every = len(bad) == len(sensor.position)
    yield _finding(
        seen,
        sensor,
        bad,
        _Verdict(
            "sensor-in-solid",
            "fault" if every else "warning",
            f"enclosed, seeing only the inside of '{name}'",
            "no light gets there: the reading is 0",
            f"move it out of '{name}', or turn the faces of '{name}' if it is the room",
        ),
    )


def _under(
    subject: Subject,
    seen: SensorViews,
    sensor: Sensor,
    bad: NDArray[np.int64],
    cover: NDArray[np.int32],
    distance: NDArray[np.float64],
) -> Iterator[Finding]:
    """Readings right in front of a surface, one finding for each object that covers them."""
    owner = subject.scene.patches.object[np.maximum(cover[bad], 0)]
    for number in np.unique(owner):
        mine = bad[owner == number]
        name, gap = subject.scene.objects[number], float(distance[mine].min())
        up = float(np.median(seen.normal[mine, 2]))
        where = "under" if up > 0.7 else "above" if up < -0.7 else "in front of"
        yield _finding(
            seen,
            sensor,
            mine,
            _Verdict(
                "sensor-covered",
                "warning",
                f"{1e3 * gap:.1g} mm {where} '{name}' and facing it",
                f"it reads what leaves '{name}' and hardly anything of the room",
                "put it on the other side of the surface, or farther off",
            ),
        )


def _cut(
    subject: Subject, seen: SensorViews, sensor: Sensor, bad: NDArray[np.int64], patch: NDArray[np.int32]
) -> Iterator[Finding]:
    """Readings in edges, corners and on sheets seen edge-on, one finding for each object that cuts them."""
    owner = subject.scene.patches.object[np.maximum(patch[bad], 0)]
    for number in np.unique(owner):
        verdict = _Verdict(
            "sensor-in-edge",
            "warning",
            f"right in a surface of '{subject.scene.objects[number]}'",
            "rays start on both sides of that surface, so that it reads a part of the light only",
            "move it a millimetre away from the surface",
        )
        yield _finding(seen, sensor, bad[owner == number], verdict)


def _in_the_dark(
    seen: SensorViews, sensor: Sensor, bad: NDArray[np.int64], behind: NDArray[np.bool_]
) -> Iterator[Finding]:
    """Readings that no light reaches: turned round, outside of everything, or in a dark space."""
    outcome = seen.views
    outside = outcome.share(MISSED) > _MOST
    turned = bad[behind[bad]]
    beyond = bad[~behind[bad] & outside[bad]]
    closed = bad[~behind[bad] & ~outside[bad] & (outcome.share(DARK)[bad] > 0.0)]
    cases: Sequence[tuple[NDArray[np.int64], _Verdict]] = (
        (
            turned,
            _Verdict(
                "sensor-turned-round",
                "warning",
                "on the dark side of a surface: light is behind it",
                "it reads exactly 0",
                "reverse its normal, or move it to the other side of the surface",
            ),
        ),
        (
            beyond,
            _Verdict(
                "sensor-outside",
                "warning",
                "outside of everything that is lit: it sees nothing lit, and most of its view is empty",
                "it reads exactly 0",
                "move it into the room",
            ),
        ),
        (
            closed,
            _Verdict("sensor-dark", "info", "in a space that no light reaches", "it reads exactly 0", ""),
        ),
    )
    for rows, verdict in cases:
        if len(rows):
            yield _finding(seen, sensor, rows, verdict)


def _finding(seen: SensorViews, sensor: Sensor, bad: NDArray[np.int64], verdict: _Verdict) -> Finding:
    place = seen.position[bad[0]]
    n = len(sensor.position)
    subject = f"sensor '{sensor.name}' is" if n == 1 else f"{len(bad)} of {n} readings of sensor '{sensor.name}' are"
    message = f"{subject} {verdict.what}; " + ("at " if len(bad) == 1 else "the first at ") + at(place)
    size = float(np.linalg.norm(np.ptp(seen.position[bad], axis=0)))
    return Finding(verdict.kind, verdict.severity, sensor.name, place, size, message, verdict.effect, verdict.fix)
