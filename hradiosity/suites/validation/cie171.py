"""CIE 171:2006, sections 5.2 to 5.7: direct light and one reflection."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from hradiosity.suites.validation import data
from hradiosity.suites.validation.measures import flux_on, of_readings, of_readings_over_last
from hradiosity.suites.validation.scene_text import (
    FACES,
    Entry,
    Light,
    Rectangle,
    Room,
    Solid,
    Source,
    scene_text,
    wall_with_opening,
)
from hradiosity.suites.validation.values import Bench, Case, Job, Measured, Point

GROUP = "CIE 171:2006"
DIRECT = 0.001
ONE_REFLECTION = 0.001
BEHIND_A_BOX = 0.005
AXIAL_INTENSITY = 1000.0
SPECK = 1e-3
"""Edge of the Lambertian square that stands for a point source [m]."""
FAR = 1e5
"""Distance from which a point source's light counts as parallel [m]; over 4 m it is uniform to 7e-5."""
FARTHER = 1e7
"""The same over 500 m, to 9e-5."""
LUMENS = 1e9
"""Of the distant source; only ratios are read."""


def cases() -> list[Case]:
    """Cheapest first."""
    return [
        _lambertian_point(),
        _panel(),
        _flux_shares(),
        _reflection("5.6-2", 4.0, FAR),
        _reflection("5.6-3", 500.0, FARTHER),
        _behind_a_box("5.7-wall"),
        _behind_a_box("5.7-floor"),
    ]


def points_of(case: Mapping[str, Any], tolerance: float) -> tuple[Point, ...]:
    """Known points of a case of the data; those on one face make a curve."""
    return tuple(
        Point(name, point["value"], tolerance, str(point.get("n", ""))) for name, point in case["points"].items()
    )


def _places(case: Mapping[str, Any]) -> list[tuple[Sequence[float], Sequence[float]]]:
    return [(point["p"], point["n"]) for point in case["points"].values()]


def _lambertian_point() -> Case:
    known = data.cie171()["5.2-lambertian"]
    half = SPECK / 2
    speck = Rectangle((-half, -half, 3.0), (0, SPECK, 0), (SPECK, 0, 0), "black", "lamp")
    lamp = Light("luminous_flux_lm", math.pi * AXIAL_INTENSITY)
    job = Job(scene_text("CIE 171 5.2", [speck], {"black": 0.0}, _places(known), lamp=lamp))
    return Case(
        name=known["id"],
        title="Point source with a cosine distribution over a floor",
        group=GROUP,
        quantity="illuminance",
        unit="lx",
        points=points_of(known, DIRECT),
        measure=of_readings(job),
        jobs=(job,),
        note="Point sources of the format shine alike in all directions; a Lambertian square of 1 mm stands for this.",
    )


def _panel() -> Case:
    known = data.cie171()["5.3"]
    size = (4.0, 4.0, 3.0)
    ceiling = wall_with_opening("ceiling", size, (1.5, 1.5), (2.5, 2.5), "ceiling", ("ceiling", "lamp"))
    lamp = Light("luminous_exitance_lm_m2", math.pi * AXIAL_INTENSITY)
    black = dict.fromkeys(FACES, 0.0)
    job = Job(scene_text("CIE 171 5.3", [Room(size, omit=("ceiling",)), *ceiling], black, _places(known), lamp=lamp))
    return Case(
        name=known["id"],
        title="Luminous panel in the ceiling of a black room",
        group=GROUP,
        quantity="illuminance",
        unit="lx",
        points=points_of(known, known["tol_rel"]),
        measure=of_readings(job),
        jobs=(job,),
    )


def _flux_shares() -> Case:
    known = data.cie171()["5.4"]
    flux = 1000.0
    objects: list[Entry] = [Room(known["dims"]), Source(known["source_position"])]
    lamp = Light("luminous_flux_lm", flux)
    somewhere = [((2.0, 2.0, 0.0), (0.0, 0.0, 1.0))]
    job = Job(
        scene_text("CIE 171 5.4", objects, dict.fromkeys(FACES, 0.0), somewhere, lamp=lamp),
        effort=(("light_points", 128),),
    )

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        shares = [flux_on(solution, face, direct=True) / flux for face in known["points"]]
        return [Measured(share) for share in (*shares, sum(shares))]

    return Case(
        name=known["id"],
        title="Flux of a point source on the faces of a room",
        group=GROUP,
        quantity="share of the flux",
        unit="1",
        points=(*points_of(known, known["tol_rel"]), Point("all", 1.0, known["tol_rel"])),
        measure=measure,
        jobs=(job,),
    )


def _reflection(name: str, width: float, distance: float) -> Case:
    known = data.cie171()[name]
    rho, incidence = 0.30, math.radians(35.0)
    corner = (2.0 - width / 2, 2.0 - width / 2, 0.0)
    plane = Rectangle(corner, (width, 0, 0), (0, width, 0), "grey")
    sun = Source((2.0, 2.0 - distance * math.sin(incidence), distance * math.cos(incidence)))
    points = [*_places(known), ((2.0, 2.0, 0.0), (0.0, 0.0, 1.0))]
    lamp = Light("luminous_flux_lm", LUMENS)
    job = Job(
        scene_text(f"CIE 171 {name}", [plane, sun], {"grey": rho}, points, lamp=lamp),
        effort=(("gather_samples", 1 << 18),),
    )
    return Case(
        name=name,
        title=f"Reflection from a plane of {width:g} m × {width:g} m",
        group=GROUP,
        quantity="illuminance over that of the plane times its reflectance",
        unit="%",
        points=points_of(known, ONE_REFLECTION),
        measure=of_readings_over_last(job, 100.0 / rho),
        jobs=(job,),
        note=f"A point source {distance / 1000:g} km away gives the parallel light. The black receiving planes are "
        "left out, since one of them would stand in the beam.",
    )


def _behind_a_box(name: str) -> Case:
    known = data.cie171()[name]
    rho, elevation = 0.60, math.radians(60.0)
    objects: list[Entry] = [
        Rectangle((0, 4, 0), (4, 0, 0), (0, 0, 3), "grey"),
        Rectangle((0, 0, 0), (0, 0, 3), (4, 0, 0), "black"),
        Rectangle((0, 0, 0), (4, 0, 0), (0, 2.5, 0), "black"),
        Solid((0, 2.5, 0), (4, 0.2, 1), "black"),
        Rectangle((-2, -2, 3), (0, 3.5, 0), (8, 0, 0), "black"),
        Source((2.0, 4.0 - FAR * math.cos(elevation), FAR * math.sin(elevation))),
    ]
    points = [*_places(known), ((2.0, 4.0, 1.5), (0.0, -1.0, 0.0))]
    lamp = Light("luminous_flux_lm", LUMENS)
    job = Job(
        scene_text(f"CIE 171 {name}", objects, {"grey": rho, "black": 0.0}, points, lamp=lamp),
        effort=(("gather_samples", 1 << 18),),
    )
    return Case(
        name=name,
        title="Reflection from a wall past a black box",
        group=GROUP,
        quantity="illuminance over that of the wall times its reflectance",
        unit="%",
        points=points_of(known, BEHIND_A_BOX),
        measure=of_readings_over_last(job, 100.0 / rho),
        jobs=(job,),
        note="A point source 100 km away lights the wall; a black screen above the points keeps its direct light off "
        "them. The values that the report prints in table 19 belong to another geometry.",
    )
