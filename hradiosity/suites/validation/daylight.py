"""CIE 171:2006, sections 5.9 to 5.14 under a uniform sky: openings, ground and masks outside."""

from __future__ import annotations

from collections.abc import Sequence

from hradiosity.suites.validation import data
from hradiosity.suites.validation.cie171 import GROUP, points_of
from hradiosity.suites.validation.measures import of_readings, scaled
from hradiosity.suites.validation.scene_text import (
    FACES,
    Entry,
    Light,
    Rectangle,
    Room,
    scene_text,
    wall_with_opening,
)
from hradiosity.suites.validation.values import Bench, Case, Job, Measured, NotRun, Point

SIZE = (4.0, 4.0, 3.0)
E_HZ = 10000.0
"""Illuminance of the unobstructed plane outside [lx]."""
GROUND = 0.30
"""Exitance of the ground over that illuminance."""
NEAR_GROUND, FAR_GROUND = 48.0, 4000.0
"""Extent of the ground [m]: for points that see none of its horizon, and for the two that do."""
MASK_HEIGHT, MASK_DISTANCE = 3.0, 6.0
"""Of the canopy over the floor, and of the building opposite from the opening [m]."""
BUILDING_WIDTH, CANOPY_WIDTH = 24.0, 8.0
"""Enough to be endless for every point through this opening [m]."""
EFFORT = (("gather_samples", 1 << 18),)
LAMP_EFFORT = (*EFFORT, ("light_samples", 1 << 20))
"""With luminous things outside, of which little is seen."""

Place = tuple[Sequence[float], Sequence[float]]


def cases() -> list[Case]:
    """Those with a uniform sky."""
    return [
        _roof_opening(),
        *(_masked(f"5.14-{height:g}-t5", f"building of {height:g} m opposite", _building(height)) for height in (3, 9)),
        *(_masked(f"5.13-{depth:g}-t5", f"canopy of {depth:g} m", _canopy(depth)) for depth in (0.5, 1.0)),
        _facade_opening(),
    ]


def not_run() -> list[NotRun]:
    """Those whose sky is none that a scene can have."""
    reason = "the sky of the scene format is uniform; this case has another one"
    return [NotRun(name, reason) for name, case in data.cie171().items() if "anisotropic" in case["applicability"]]


def _job(
    title: str,
    openings: Sequence[Rectangle],
    outside: Sequence[Rectangle],
    points: Sequence[Place],
    face: str,
    *,
    sky: bool = True,
    ground: float = 0.0,
) -> Job:
    """A black room with an opening in a face, and what stands outside; ground: extent of the luminous one [m]."""
    lamp = Light("luminous_exitance_lm_m2", GROUND * E_HZ if ground else E_HZ)
    paints = dict.fromkeys((*FACES, "outside"), 0.0)
    objects: list[Entry] = [Room(SIZE, omit=(face,)), *openings, *outside]
    lit = any(piece.luminaire for piece in outside)
    text = scene_text(
        title,
        objects,
        paints,
        points,
        lamp=lamp if lit else None,
        sky=Light("illuminance_lx", E_HZ) if sky else None,
    )
    # Everything is black: elements only have to be few, and those of the ground would be many.
    return Job(text, effort=LAMP_EFFORT if lit else EFFORT, fixed=(("element_size", ground / 80.0),) if ground else ())


def _roof_opening() -> Case:
    known = data.cie171()["5.9-1x1-t5"]
    roof = wall_with_opening("ceiling", SIZE, (1.5, 1.5), (2.5, 2.5), "ceiling")
    points = [(point["p"], point["n"]) for point in known["points"].values()]
    job = _job("CIE 171 5.9", roof, [], points, "ceiling")
    return Case(
        name=known["id"],
        title="Roof opening of 1 m × 1 m under a uniform sky",
        group=GROUP,
        quantity="illuminance over that of the open plane",
        unit="%",
        points=points_of(known, known["tol_rel"]),
        measure=of_readings(job, 100.0 / E_HZ),
        jobs=(job,),
    )


def _facade() -> list[Rectangle]:
    return wall_with_opening("y0", SIZE, (1.0, 1.0), (3.0, 2.0), "y0")


def _ground(extent: float) -> Rectangle:
    half = 0.3 * extent
    return Rectangle((2 - half, -extent, 0), (2 * half, 0, 0), (0, extent, 0), "outside", "lamp")


def _facade_opening() -> Case:
    known = data.cie171()["5.11-2x1-t5"]
    known = {**known, "points": dict(sorted(known["points"].items(), key=lambda item: item[0].endswith("'")))}
    points = {name: (point["p"], point["n"]) for name, point in known["points"].items()}
    far = [name for name in points if name in ("C", "D")]
    near = [name for name in points if name not in far]
    jobs = [
        _job("CIE 171 5.11", _facade(), [_ground(extent)], [points[name] for name in names], "y0", ground=extent)
        for names, extent in ((near, NEAR_GROUND), (far, FAR_GROUND))
    ]

    def measure(bench: Bench) -> list[Measured]:
        found = [scaled(bench.solve(job), 100.0 / E_HZ) for job in jobs]
        by_name = dict(zip(near + far, found[0] + found[1]))
        return [by_name[name] for name in points]

    return Case(
        name=known["id"],
        title="Opening of 2 m × 1 m in a wall, uniform sky and luminous ground",
        group=GROUP,
        quantity="illuminance over that of the open plane",
        unit="%",
        points=points_of(known, known["tol_rel"]),
        measure=measure,
        jobs=tuple(jobs),
        note=f"The endless ground is a luminous rectangle: {NEAR_GROUND:g} m deep for points that see none of its "
        f"horizon, {FAR_GROUND / 1000:g} km for C and D, which do and lack up to 0.1 % by that.",
    )


def _building(height: float) -> tuple[Rectangle, ...]:
    left = 2.0 - BUILDING_WIDTH / 2
    return (Rectangle((left, -MASK_DISTANCE, 0), (0, 0, height), (BUILDING_WIDTH, 0, 0), "outside"),)


def _canopy(depth: float) -> tuple[Rectangle, ...]:
    left = 2.0 - CANOPY_WIDTH / 2
    return (Rectangle((left, -depth, MASK_HEIGHT), (0, depth, 0), (CANOPY_WIDTH, 0, 0), "outside"),)


def _masked(name: str, what: str, outside: tuple[Rectangle, ...]) -> Case:
    """Sky past a black mask at points of the floor; then the mask alone, shining as brightly as the sky."""
    known = data.cie171()[name]
    points = [((2.0, 3.75 - 0.5 * number, 0.0), (0.0, 0.0, 1.0)) for number in range(len(known["points"]))]
    shining = [Rectangle(m.corner, m.edge_u, m.edge_v, m.material, "lamp") for m in outside]
    under_sky = _job(f"CIE 171 {name}", _facade(), outside, points, "y0")
    by_mask = _job(f"CIE 171 {name}, mask", _facade(), shining, points, "y0", sky=False)
    tolerance = known["tol_rel"]
    masks = [Point(f"{key} mask", point["mask_cf"], tolerance, "mask") for key, point in known["points"].items()]

    def measure(bench: Bench) -> list[Measured]:
        return [found for job in (under_sky, by_mask) for found in scaled(bench.solve(job), 100.0 / E_HZ)]

    return Case(
        name=name,
        title=f"Opening of 2 m × 1 m behind a {what}, uniform sky",
        group=GROUP,
        quantity="illuminance over that of the open plane",
        unit="%",
        points=(*points_of(known, tolerance), *masks),
        measure=measure,
        jobs=(under_sky, by_mask),
        note="Once with a black mask under the sky, once with the mask alone, as bright as the sky (“mask”).",
    )
