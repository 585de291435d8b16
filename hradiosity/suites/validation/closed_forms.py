"""Whole scenes with closed-form solutions: spheres, parallel planes, a cube of six patches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.suites.validation import data
from hradiosity.suites.validation.measures import mean_on, scaled
from hradiosity.suites.validation.scene_text import FACES, Light, Mesh, Rectangle, Room, Source, scene_text
from hradiosity.suites.validation.values import Bench, Case, Job, Measured, NotRun, Point

GROUP = "Closed forms"
AT_POINTS = 0.005
MEANS = 0.001
LEVEL, INNER_LEVEL, OUTER_LEVEL = 4, 1, 3
"""Each level cuts the triangles of an icosahedron in four; of a lone sphere, and of one in another. All triangles of
the inner one are lamps."""
PLATE = 400.0
"""Edge of the plates that stand for endless ones 1 m apart [m]; what misses them is 5e-5."""
EFFORT = (("gather_samples", 16384), ("rays_per_element", 512), ("light_points", 128))


def cases() -> list[Case]:
    """Cheapest first."""
    known = data.closed_forms()
    cubes = known["cube-6-patches"]["cases"]
    spheres = known["sphere-uniform"]["cases"]
    shells = known["concentric-spheres"]["cases"]
    return [
        *(_planes(case) for case in known["infinite-parallel-planes"]["cases"]),
        *(_six_patches(case, number) for number, case in enumerate(cubes, 1)),
        *(_sphere(case) for case in spheres),
        *(_shells(case, number) for number, case in enumerate(shells, 1)),
    ]


def not_run() -> list[NotRun]:
    """Statements that compare runs with each other."""
    reason = "compares runs with each other and not with a reference; the tests of the program do that"
    return [NotRun("invariances", reason)]


def _planes(known: Mapping[str, float]) -> Case:
    half = PLATE / 2
    lower = Rectangle((-half, -half, 0), (PLATE, 0, 0), (0, PLATE, 0), "lower", "lamp")
    upper = Rectangle((-half, -half, 1), (0, PLATE, 0), (PLATE, 0, 0), "upper")
    points = [((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))]
    lamp = Light("luminous_exitance_lm_m2", known["M"])
    paints = {"lower": known["r1"], "upper": known["r2"]}
    text = scene_text("parallel planes", [lower, upper], paints, points, lamp=lamp)
    job = Job(text, effort=(("gather_samples", 16384),), fixed=(("element_size", 8.0),))
    return Case(
        name="parallel-planes",
        title="Two endless parallel planes",
        group=GROUP,
        quantity="illuminance",
        unit="lx",
        points=(Point("on plane 2", known["B1"], AT_POINTS, "2"), Point("on plane 1", known["B2"], AT_POINTS, "1")),
        measure=lambda bench: scaled(bench.solve(job), 1.0),
        jobs=(job,),
        note=f"Plates of {PLATE:g} m stand for the planes, 1 m apart; the points are in their middle.",
    )


def _six_patches(known: Mapping[str, Any], number: int) -> Case:
    paints = dict(zip(FACES, known["rho"]))
    exitance = dict(zip(FACES, known["M"]))
    lamp = Light("luminous_exitance_lm_m2", float(exitance["ceiling"]))
    points = [((0.5, 0.5, 0.0), (0.0, 0.0, 1.0))]
    job = Job(
        scene_text("six patches", [Room((1, 1, 1), luminous="ceiling")], paints, points, lamp=lamp),
        effort=(("rays_per_element", 1 << 20), ("light_points", 1 << 16)),
        fixed=(("element_size", 1.0),),
    )

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return [Measured(exitance[face] + paints[face] * mean_on(solution, face)) for face in FACES]

    return Case(
        name=f"cube-6-patches-{number}",
        title="A unit cube of six patches, of which one shines",
        group=GROUP,
        quantity="exitance",
        unit="lm m⁻²",
        points=tuple(Point(face, value, MEANS, face) for face, value in zip(FACES, known["B"])),
        measure=measure,
        jobs=(job,),
        note="One element a face: the solution of the discrete system, and not that of the continuous equation.",
    )


def _sphere(known: Mapping[str, float]) -> Case:
    radius = known["R"]
    corner, triangle = sphere(radius, LEVEL, inwards=True)
    centre = corner[triangle].mean(axis=1)[:: len(triangle) // 8]
    points = [(tuple(map(float, place)), tuple(map(float, -place))) for place in centre]
    job = Job(
        scene_text(
            "sphere",
            [Mesh("sphere.obj", "wall"), Source((0, 0, 0))],
            {"wall": known["rho"]},
            points,
            lamp=Light("luminous_flux_lm", known["Phi"]),
        ),
        files=(("sphere.obj", obj(corner, triangle)),),
        effort=EFFORT,
    )

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return [*scaled(solution, 1.0), Measured(mean_on(solution, "wall"))]

    names = [f"point {k + 1}" for k in range(len(points))]
    return Case(
        name=f"sphere-rho{known['rho']:.2f}",
        title="A sphere with a point source in its centre",
        group=GROUP,
        quantity="illuminance",
        unit="lx",
        points=(*(Point(name, known["E"], AT_POINTS) for name in names), Point("mean", known["E"], MEANS, "mean")),
        measure=measure,
        jobs=(job,),
        note=f"A polyhedron of {len(triangle)} triangles and of the sphere's area stands for it.",
    )


def _shells(known: Mapping[str, float], number: int) -> Case:
    inner = sphere(known["r1"], INNER_LEVEL, inwards=False)
    outer = sphere(known["r2"], OUTER_LEVEL, inwards=True)
    paints = {"inner": known["rho1"], "outer": known["rho2"]}
    objects = [Mesh("inner.obj", "inner", "lamp"), Mesh("outer.obj", "outer")]
    points = [((0.0, 0.0, 0.5 * (known["r1"] + known["r2"])), (0.0, 0.0, -1.0))]
    job = Job(
        scene_text("spheres", objects, paints, points, lamp=Light("luminous_exitance_lm_m2", known["M1"])),
        files=(("inner.obj", obj(*inner)), ("outer.obj", obj(*outer))),
        effort=(("rays_per_element", 2048), ("light_points", 16)),
        fixed=(("elements", 1000),),
    )

    def measure(bench: Bench) -> list[Measured]:
        solution = bench.solve(job)
        return [Measured(mean_on(solution, name)) for name in ("inner", "outer")]

    return Case(
        name=f"concentric-spheres-{number}",
        title="A luminous sphere inside another one",
        group=GROUP,
        quantity="mean illuminance",
        unit="lx",
        points=(Point("inner", known["E1"], MEANS, "inner"), Point("outer", known["E2"], MEANS, "outer")),
        measure=measure,
        jobs=(job,),
        note=f"Polyhedra of {len(inner[1])} and {len(outer[1])} triangles and of the spheres' areas stand for them.",
    )


@cache
def sphere(radius: float, level: int, *, inwards: bool) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A polyhedron of 20 · 4^level triangles with the area of a sphere about the origin.

    Returns
    -------
    corner : (n, 3) float64 [m]
    triangle : (20 · 4^level, 3) int64
        Counter-clockwise seen from outside, or from inside.
    """
    from scipy.spatial import ConvexHull

    golden = 0.5 * (1.0 + math.sqrt(5.0))
    signs = np.array([(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)])
    corner = np.concatenate([np.roll(np.insert(signs, 0, 0.0, axis=1), shift, axis=1) for shift in range(3)])
    for _ in range(level):
        hull = ConvexHull(corner).simplices
        edge = np.unique(np.sort(np.concatenate([hull[:, [0, 1]], hull[:, [1, 2]], hull[:, [2, 0]]]), axis=1), axis=0)
        corner = np.concatenate([_unit(corner), _unit(_unit(corner)[edge].sum(axis=1))])
    corner = _unit(corner)
    triangle = ConvexHull(corner).simplices.astype(np.int64)
    first, second, third = (corner[triangle[:, k]] for k in range(3))
    across = np.cross(second - first, third - first)
    outward = np.einsum("td,td->t", across, first) > 0.0
    turned = outward == inwards
    triangle[turned] = triangle[turned][:, ::-1]
    area = 0.5 * float(np.linalg.norm(across, axis=1).sum())
    return corner * radius * math.sqrt(4.0 * math.pi / area), triangle


def obj(corner: NDArray[np.float64], triangle: NDArray[np.int64]) -> str:
    """An OBJ file of one object, "surface"."""
    rows = ["o surface", *(f"v {x:.12g} {y:.12g} {z:.12g}" for x, y, z in corner.tolist())]
    return "\n".join([*rows, *(f"f {a} {b} {c}" for a, b, c in (triangle + 1).tolist())]) + "\n"


def _unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return unit
