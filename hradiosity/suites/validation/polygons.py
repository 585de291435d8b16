"""The catalogue of form factors: pairs of polygons, points, disks, and pairs with something between them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.suites.validation import data
from hradiosity.suites.validation.measures import scaled
from hradiosity.suites.validation.scene_text import Light, Polygon, scene_text
from hradiosity.suites.validation.values import Bench, Case, Job, Measured, NotRun, Point
from hradiosity.transport.form_factor.interface import FormFactors, form_factor, form_factor_matrix

GROUP = "Form factors"
EXACT, NEAR_SINGULAR = 1e-6, 1e-4
SINGULAR = ("near-touching-plates", "sliver", "area-ratio", "horizon")
"""Categories with tiny edges or gaps, or with polygons that cross each other's plane."""
ROUND, BLOCKED, AT_A_POINT = 1e-4, 0.005, 0.001
SIDES = 32
"""Of the regular polygon that stands for a disk of its area; no more are possible."""
VISIBILITY = 5e-4
"""Half width to reach for the visible share, relative."""

Corners = NDArray[np.float64]


def cases() -> list[Case]:
    """One for each category."""
    pairs = _of_kind("polygon-polygon")
    categories = dict.fromkeys(entry["category"] for entry in pairs)
    by_category = [[entry for entry in pairs if entry["category"] == category] for category in categories]
    return [*(_pairs(entries) for entries in by_category), _cube(), _disks(), _blocked(), _points()]


def not_run() -> list[NotRun]:
    """Entries that are no pair of polygons."""
    reason = "patches of spheres are no polygons; the spheres as wholes are among the closed forms"
    return [NotRun(f"form-factors-{entry['id']}", reason) for entry in _of_kind("sphere")]


def _of_kind(kind: str) -> list[dict[str, Any]]:
    return [entry for entry in data.form_factors() if entry["kind"] == kind]


def _case(name: str, title: str, points: Sequence[Point], measure: Any, note: str = "") -> Case:
    """A case of numbers between 0 and 1."""
    return Case(f"form-factors-{name}", title, GROUP, "form factor", "1", tuple(points), measure, note=note)


def _known(entries: Sequence[Mapping[str, Any]], tolerance: float) -> list[Point]:
    return [Point(entry["id"], float(entry["F12"]), tolerance, entry["id"]) for entry in entries]


def _measured(found: FormFactors) -> list[Measured]:
    pairs = zip(np.atleast_1d(found.value), np.atleast_1d(found.error))
    return [Measured(float(value), float(error)) for value, error in pairs]


def _pairs(entries: Sequence[Mapping[str, Any]]) -> Case:
    category = entries[0]["category"]
    first, second = ([np.array(entry[key], np.float64) for entry in entries] for key in ("poly1", "poly2"))
    tolerance = NEAR_SINGULAR if category in SINGULAR else EXACT

    def measure(bench: Bench) -> list[Measured]:
        return _measured(form_factor(first, second, method="contour", device=bench.device))

    title = f"Pairs of polygons: {category.replace('-', ' ')}"
    return _case(category, title, _known(entries, tolerance), measure, "By the contour integral.")


def _cube() -> Case:
    (entry,) = _of_kind("cube")
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float64)
    side = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], np.float64)
    # Opposite faces: reversed, so that the front looks inwards too.
    faces = [square for axis, square in ((2, corner), (1, side)) for square in _opposite(square, axis)]
    faces += list(_opposite(np.roll(corner, 1, axis=1), 0))
    known = (float(entry["F12"]), float(entry["extra"]["adjacent"]), float(entry["extra"]["row_sum"]))

    def measure(bench: Bench) -> list[Measured]:
        found = form_factor_matrix(faces, method="contour", device=bench.device)
        return [Measured(float(v)) for v in (found.value[0, 1], found.value[0, 2], found.value[0].sum())]

    names = ("opposite", "adjacent", "row sum")
    points = [Point(name, value, EXACT, name) for name, value in zip(names, known)]
    return _case("cube", "Faces of a cube", points, measure, "By the contour integral.")


def _opposite(square: Corners, axis: int) -> tuple[Corners, Corners]:
    """A face of the unit cube at coordinate 0, and that at 1, both fronts inwards."""
    moved = square[::-1].copy()
    moved[:, axis] += 1.0
    return square, moved


def _disks() -> Case:
    entries = _of_kind("disk-disk")
    pairs = [_disk_pair(*(float(entry["shape"][key]) for key in ("r1", "r2", "h"))) for entry in entries]
    first, second = ([pair[k] for pair in pairs] for k in range(2))

    def measure(bench: Bench) -> list[Measured]:
        return _measured(form_factor(first, second, method="contour", device=bench.device))

    note = f"Regular polygons of {SIDES} corners and of the disks' areas stand for the disks; by the contour integral."
    return _case("disk", "Coaxial disks", _known(entries, ROUND), measure, note)


def _disk_pair(radius: float, other: float, distance: float) -> tuple[Corners, Corners]:
    angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
    scale = math.sqrt(2.0 * math.pi / (SIDES * math.sin(2.0 * math.pi / SIDES)))
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)]) * scale
    return circle * radius, circle[::-1] * other + [0.0, 0.0, distance]


def _blocked() -> Case:
    entries = _of_kind("polygon-polygon-with-blocker")

    def measure(bench: Bench) -> list[Measured]:
        found = []
        for entry in entries:
            gap = float(entry["shape"]["gap"])
            width = float(entry["shape"]["blocker"].split("square ")[1].split(" ")[0])
            lower, upper, between = _square(1.0, 0.0), _square(1.0, gap)[::-1], _square(width, gap / 2)
            factor = form_factor(
                lower, upper, occluders=[between], visibility_tolerance=VISIBILITY, device=bench.device
            )
            found += _measured(factor)
        return found

    title = "Opposed squares with a square between them"
    return _case("occluded", title, _known(entries, BLOCKED), measure, "Visibility is sampled, as a ratio.")


def _square(width: float, height: float) -> Corners:
    """About the axis, front upwards."""
    half = 0.5 * width
    return np.array([[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]])


def _points() -> Case:
    """Receiving points: each a scene of one luminous polygon, since sensors are such points."""
    entries = _of_kind("point-polygon")
    jobs = tuple(_point_job(entry) for entry in entries)

    def measure(bench: Bench) -> list[Measured]:
        return [scaled(bench.solve(job), 1.0)[0] for job in jobs]

    return Case(
        name="form-factors-points",
        title="From a point to a polygon",
        group=GROUP,
        quantity="form factor",
        unit="1",
        points=tuple(_known(entries, AT_A_POINT)),
        measure=measure,
        jobs=jobs,
        note="Each is a scene of one polygon of exitance 1 lm m⁻², read by a sensor.",
    )


def _point_job(entry: Mapping[str, Any]) -> Job:
    place, normal, corners = (np.array(entry[key], np.float64) for key in ("point", "normal", "poly2"))
    if np.cross(corners[1] - corners[0], corners[2] - corners[0]) @ (place - corners[0]) < 0.0:
        corners = corners[::-1]
    polygon = Polygon(corners.tolist(), "black", "lamp")
    lamp = Light("luminous_exitance_lm_m2", 1.0)
    return Job(scene_text(entry["id"], [polygon], {"black": 0.0}, [(place.tolist(), normal.tolist())], lamp=lamp))
