"""What a run in the mode of rays takes, from the speeds of earlier runs on the device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from hradiosity.plan import Calibration, Plan

READINGS: Final = 40
"""Readings that take as long as what all of them take anyway in a replicate."""
READING_PATHS: Final = 300
"""Paths that take as long as all else about a reading in a replicate: shadow rays, and what is derived from it."""
SOLUTION_RAYS: Final = 50_000
"""Exchange rays whose part in a solution takes as long as what a solution takes anyway."""
PROOF, VISIBILITY, PIXEL = 5.0, 2.4, 0.09
"""Of what an exchange ray takes to close: a proof that nothing stands between a pair, its visibility in a replicate,
and a pixel of a hemicube; replicates with half the samples, for the intervals, included."""
CLOSING, SOLUTION = 0.3, 0.2
"""What a link of a pair takes to close and to solve, of what a ray does: many links share what a row takes anyway."""
BEFORE: Final = ("geometry", "check")
"""Stages before the first replicate."""


def reading_paths(plan: Plan) -> int:
    """Work of the readings in one replicate, in paths; 0 without readings."""
    return (plan.n_readings + READINGS) * (plan.gather_samples + READING_PATHS) if plan.n_readings else 0


def solution_rays(plan: Plan, n_elements: int) -> int:
    """Work of one solution, for each right-hand side, in exchange rays."""
    return n_elements * plan.rays_per_element + SOLUTION_RAYS


def shadow_seconds(plan: Plan, calibration: Calibration) -> float:
    """Expected seconds of all shadow rays from elements."""
    return plan.replicates * plan.n_elements * plan.n_emitters * plan.light_points / calibration.shadow_rays_per_s


def with_seconds(plan: Plan, calibration: Calibration) -> Plan:
    """The plan with expected seconds of all replicates, and what the effects that are left out save."""
    rays = plan.replicates * plan.n_elements * plan.rays_per_element
    a_column = plan.replicates * solution_rays(plan, plan.n_elements) * calibration.solve_s_per_ray_column
    shadows = shadow_seconds(plan, calibration)
    reflection = (
        8 * plan.columns.n_groups * a_column + plan.replicates * reading_paths(plan) / calibration.reading_paths_per_s
    )
    share = plan.columns.n_groups * 8 / max(plan.n_bands, 1)
    saved = {
        "occlusion": shadows,
        "interreflection": reflection,
        "bands singly": plan.n_bands * a_column * max(0.0, 1.0 - share),
    }
    seconds = rays * (1.0 / calibration.exchange_rays_per_s + calibration.exchange_s_per_ray)
    seconds += shadows if plan.occlusion else 0.0
    seconds += reflection if plan.interreflection else 0.0
    effects = tuple(
        effect if effect.needed else replace(effect, saved_seconds=saved.get(effect.name, 0.0))
        for effect in plan.effects
    )
    return replace(plan, effects=effects, seconds=seconds)


def with_geometry(plan: Plan, spent: Mapping[str, float]) -> Plan:
    """The plan with what was spent before the first replicate, which is known by then, in its seconds.

    Parameters
    ----------
    plan : Plan
    spent : mapping
        Seconds of each stage so far.
    """
    first = sum(spent.get(stage, 0.0) for stage in BEFORE)
    return plan if plan.seconds is None else replace(plan, seconds=plan.seconds + first)


def pair_seconds(plan: Plan, calibration: Calibration, rays_of_a_pair: float) -> float:
    """Expected seconds that form factors of all pairs of cells add to those of rays.

    Parameters
    ----------
    plan : Plan
        With its pairs.
    calibration : Calibration
    rays_of_a_pair : float
        Exchange rays that take as long as all form factors of a pair.
    """
    factors = rays_of_a_pair * plan.pairs / calibration.exchange_rays_per_s
    sights = (PROOF + plan.replicates * VISIBILITY) * plan.pairs if plan.occlusion else 0.0
    more = max(2 * plan.pairs - plan.n_elements * plan.rays_per_element, 0)
    return factors + sights * calibration.exchange_s_per_ray + _link_seconds(plan, calibration, more)


def hemicube_seconds(plan: Plan, calibration: Calibration, pixels: float, links: float) -> float:
    """Expected seconds that hemicubes over all elements add to those of rays.

    Parameters
    ----------
    plan : Plan
    calibration : Calibration
    pixels, links : float
        Of all elements together, in one replicate: drawn, and made of them.
    """
    drawing = plan.replicates * PIXEL * pixels * calibration.exchange_s_per_ray
    return drawing + _link_seconds(plan, calibration, links)


def _link_seconds(plan: Plan, calibration: Calibration, more: float) -> float:
    """Expected seconds of closing and solution in all replicates with so many links more than there are rays."""
    solution = 8 * plan.columns.n_groups * calibration.solve_s_per_ray_column
    return plan.replicates * more * (CLOSING * calibration.exchange_s_per_ray + SOLUTION * solution)
