"""Rooms that are boxes: continuous solutions at points and face means, and case 5.8 of CIE 171:2006."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from hradiosity.suites.validation import cie171, data
from hradiosity.suites.validation.measures import flux_on, mean_everywhere, mean_on, scaled
from hradiosity.suites.validation.scene_text import (
    FACES,
    INWARD,
    Entry,
    Light,
    Room,
    Source,
    scene_text,
    wall_with_opening,
)
from hradiosity.suites.validation.values import Bench, Case, Job, Measured, Point

GROUP = "Rooms that are boxes"
AT_POINTS = 0.005
AT_FACES = 0.001
CUBE = (4.0, 4.0, 4.0)
CUBE_LUMENS = 10000.0
EFFORT = (("gather_samples", 16384), ("rays_per_element", 1024), ("light_points", 128))
CUBE_EFFORT = (("gather_samples", 8192), ("rays_per_element", 256))
"""Of the cubes with a point source in the middle, whose light is smooth."""
CENTRE = (2.0, 2.0, 2.0)


def cases() -> list[Case]:
    """Rooms of the catalogue, the flux balance of one of them, and case 5.8."""
    rooms = [_room(known) for known in data.box_rooms().values()]
    return [*rooms, _balance(), _mean_of_cubes()]


def _job(known: Mapping[str, Any]) -> Job:
    """The scene of a room of the data."""
    size, source = tuple(known["dims"]), known["source"]
    points = [(place(point, size), INWARD[point["face"]]) for point in known["points"]]
    if "isotropic" in source:
        return _cube(known["id"], known["rho"], points, (1.0, 1.5, 3.0) if "(1,1.5,3)" in source else CENTRE)
    exitance = 1000.0
    if "whole ceiling" in source:
        objects: list[Entry] = [Room(size, luminous="ceiling")]
    else:
        low, high = ((0.4, 1.0), (1.0, 2.2)) if "0.6x1.2" in source else ((1.5, 1.5), (2.5, 2.5))
        exitance = 5000.0 if "0.6x1.2" in source else 1000.0 * math.pi
        ceiling = wall_with_opening("ceiling", size, low, high, "ceiling", ("ceiling", "lamp"))
        objects = [Room(size, omit=("ceiling",)), *ceiling]
    lamp = Light("luminous_exitance_lm_m2", exitance)
    return Job(scene_text(known["id"], objects, known["rho"], points, lamp=lamp), effort=EFFORT)


def _cube(name: str, rho: Mapping[str, float], points: Any, source: tuple[float, float, float]) -> Job:
    """Cube with an isotropic point source."""
    lamp = Light("luminous_flux_lm", CUBE_LUMENS)
    return Job(
        scene_text(name, [Room(CUBE), Source(source)], rho, points, lamp=lamp),
        effort=CUBE_EFFORT if source == CENTRE else EFFORT,
    )


def _room(known: Mapping[str, Any]) -> Case:
    job = _job(known)
    at_points = [
        Point(f"{point['face']} {point['a']:g} {point['b']:g}", point["E_total"], AT_POINTS, point["face"])
        for point in known["points"]
    ]
    means = [Point(f"{face} mean", known["face_means"][face]["total"], AT_FACES, f"{face} mean") for face in FACES]

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return [*scaled(solution, 1.0), *(Measured(mean_on(solution, face)) for face in FACES)]

    reflectances = ", ".join(f"{face} {known['rho'][face]:g}" for face in FACES)
    return Case(
        name=_name(known["id"]),
        title=f"{' × '.join(f'{d:g}' for d in known['dims'])} m, {known['source']}",
        group=GROUP,
        quantity="illuminance",
        unit="lx",
        points=(*at_points, *means),
        measure=measure,
        jobs=(job,),
        note=f"Reflectances: {reflectances}. Points are named by face and the two other coordinates.",
    )


def _name(known: str) -> str:
    """Without blanks and brackets: "cube-lum-ceiling-B (red wall band)" is cube-lum-ceiling-B-red-wall-band."""
    return known.replace(" (", "-").replace(")", "").replace(" ", "-")


def _balance() -> Case:
    known = data.box_rooms()["room443-offset-mixed"]
    job = _job(known)
    sent = 5000.0 * 0.6 * 1.2

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return [Measured(sum((1.0 - known["rho"][face]) * flux_on(solution, face) for face in FACES))]

    return Case(
        name="flux-balance",
        title="What surfaces absorb is what the lamp sends out",
        group="Closed forms",
        quantity="absorbed flux",
        unit="lm",
        points=(Point("all", sent, AT_FACES),),
        measure=measure,
        jobs=(job,),
        note="The room of the case room443-offset-mixed.",
    )


def _mean_of_cubes() -> Case:
    known = data.cie171()["5.8-average"]
    points = [((2.0, 2.0, 0.0), (0.0, 0.0, 1.0))]
    rooms = data.box_rooms()
    jobs = []
    for point in known["points"].values():
        name = f"cube-iso-rho{point['rho']:.2f}"
        uniform = dict.fromkeys(FACES, float(point["rho"]))
        jobs.append(_job(rooms[name]) if name in rooms else _cube(name, uniform, points, CENTRE))
    return Case(
        name=known["id"],
        title="Interreflection in a cube of one reflectance, mean of all faces",
        group=cie171.GROUP,
        quantity="mean indirect illuminance",
        unit="lx",
        points=tuple(Point(f"ρ = {p['rho']:g}", p["value"], known["tol_rel"]) for p in known["points"].values()),
        measure=partial(_indirect_means, jobs),
        jobs=tuple(jobs),
        note="The report gives ρΦ/(S(1 − ρ)), which is the mean over the faces and not the value at a point; the cases "
        "cube-iso-… have values at points.",
    )


def _indirect_means(jobs: list[Job], bench: Bench) -> list[Measured]:
    solutions = (bench.solve(job) for job in jobs)
    return [Measured(mean_everywhere(found) - mean_everywhere(found, direct=True)) for found in solutions]


def place(point: Mapping[str, Any], size: tuple[float, ...]) -> tuple[float, ...]:
    """World position of a point that is given by its face and the two other coordinates."""
    axis = {"x": 0, "y": 1, "f": 2, "c": 2}[point["face"][0]]
    place = [float(point["a"]), float(point["b"])]
    place.insert(axis, size[axis] if point["face"] in ("x1", "y1", "ceiling") else 0.0)
    return tuple(place)
