"""What a run of the classic mode takes: hemicubes, shots, memory, seconds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hradiosity.plan import ClassicCalibration, Plan
from hradiosity.planning_memory import kept_light_bytes

PIXELS_A_PATCH: Final = 64
"""Projecting a patch on the five faces costs about as much as drawing so many pixels."""
VISIBLE_SHARE: Final = 1.0 / 3.0
"""Part of all row elements that a patch sees, about: half of a room's are in front of it, and things hide some."""
COARSER: Final = 12.0 / 16.0
"""Bytes of a factor between patches of twice the size, which are a quarter as many."""
SLOWEST: Final = 0.999
"""Mean reflectance beyond which shots are not told apart."""


@dataclass(frozen=True)
class ClassicSizes:
    """How a scene was cut.

    shooters : patches that shoot
    lamp_points : cells of the lamps
    elements : row elements
    resolution : pixels along an edge of a hemicube's top face
    tolerance : power that may stay unshot, over that of the start
    reflectance : mean over the shooters by area, of the column with the largest
    kept_bytes : views that are kept in memory at most; those of the others are drawn twice
    batch : hemicubes drawn at a time
    """

    shooters: int
    lamp_points: int
    elements: int
    resolution: int
    tolerance: float
    reflectance: float
    kept_bytes: int
    batch: int


def classic_plan(plan: Plan, sizes: ClassicSizes, calibration: ClassicCalibration | None = None) -> Plan:
    """The plan with the work of the classic mode, its memory, and seconds if the device was measured.

    Patches shoot once at least if they reflect. By Southwell's relaxation the unshot power falls with ρ̄² for each
    round of shots at mean reflectance ρ̄, twice as fast as by Jacobi's.
    """
    view = 8 * VISIBLE_SHARE * sizes.elements
    again = max(0, sizes.shooters - int(sizes.kept_bytes / max(view, 1.0)))
    shooters = sizes.shooters if plan.interreflection else 0
    once = sizes.lamp_points + shooters + again * plan.interreflection + plan.n_readings
    level = min(max(sizes.reflectance, 1e-9), SLOWEST)
    rounds = max(1.0, np.log(sizes.tolerance) / (2.0 * np.log(level))) if plan.interreflection else 0.0
    counted = replace(
        plan,
        n_elements=sizes.elements,
        shooters=sizes.shooters,
        hemicubes=plan.replicates * once,
        shots=plan.replicates * int(rounds * shooters),
        memory_bytes=_memory(plan, sizes, view),
        seconds=None,
    )
    if calibration is None:
        return counted
    drawing = counted.hemicubes * pixels_drawn(sizes.resolution, plan.n_patches) * calibration.seconds_per_pixel
    moved = products(counted.shots, counted.hemicubes, sizes.shooters, plan.columns.n_columns)
    return replace(counted, seconds=drawing + moved * calibration.seconds_per_product)


def pixels_drawn(resolution: int, n_patches: int) -> int:
    """Work of one hemicube, in pixels."""
    return 3 * resolution**2 + PIXELS_A_PATCH * n_patches


def products(shots: int, hemicubes: int, shooters: int, n_columns: int) -> int:
    """Factors times columns that are multiplied: once a shot over patches, once a hemicube over their elements."""
    return (shots + hemicubes) * shooters * max(n_columns, 1)


def _memory(plan: Plan, sizes: ClassicSizes, view: float) -> int:
    """Bytes: item and depth buffers and their sums, kept views with their rows by patch and by patches of twice the
    size, columns of both shootings, and the light that replicates leave for further points.
    """
    buffers = sizes.batch * (24 * sizes.resolution**2 + 4 * sizes.elements)
    views = min(sizes.kept_bytes, int(sizes.shooters * view)) + int((8 + COARSER) * VISIBLE_SHARE * sizes.shooters**2)
    columns = 8 * plan.columns.n_columns * (12 * sizes.shooters + 14 * sizes.elements)
    light = kept_light_bytes(3 * 8 * plan.columns.n_columns * sizes.elements, plan.replicates)
    return buffers + views + columns + light
