"""``run.json``: what was done, with what, and how it went."""

from __future__ import annotations

import json
import math
import platform
import sys
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from hradiosity.io.output_folder import PROGRAM
from hradiosity.io.results_tables import temperature_reasons
from hradiosity.metrics.temperature import REASONS
from hradiosity.metrics.truncation import truncation
from hradiosity.model.spectrum import Bands
from hradiosity.plan import Plan
from hradiosity.planning import shared_rays
from hradiosity.solution import Readings, Solution, interval_shares

_PACKAGES = ("hradiosity", "numpy", "scipy", "pyopencl", "h5py", "pocl-binary-distribution")


def run_record(solution: Solution, state: str, more: Mapping[str, Any]) -> dict[str, Any]:
    """Content of ``run.json``.

    Parameters
    ----------
    solution : Solution
    state : str
        "complete", "accuracy not reached" or "interrupted".
    more : mapping
        Further entries.
    """
    scene, plan = solution.scene, solution.plan
    record = dict(solution.record)
    return {
        "program": PROGRAM,
        "state": state,
        "complete": state == "complete",
        "scene": {"name": scene.name, "file": str(scene.path) if scene.path else None},
        "seed": record["options"]["seed"],
        "plan": plan_record(plan, scene.bands),
        **record,
        "iterations": [len(c["residual"]) - 1 for c in record["solver"]],
        "repeat_with": _repeat_with(solution),
        "sensors": {
            name: sensor_record(found) | {"cct_blank": _blank_temperatures(found, scene.bands)}
            for name, found in solution.readings.items()
        },
        "notes": [asdict(note) for note in scene.notes],
        "versions": versions(),
        **more,
    }


def plan_record(plan: Plan, bands: Bands) -> dict[str, Any]:
    """A plan without its arrays, and what the bands leave out of each number."""
    names = [name for name in plan.__dataclass_fields__ if name not in ("columns", "effects", "sight", "weak_emitters")]
    return {
        "effects": [asdict(effect) for effect in plan.effects],
        "sight": [asdict(share) for share in plan.sight],
        "right_hand_sides": plan.columns.n_columns,
        "classes_of_bands": plan.columns.n_classes,
        "emitters_without_shadow_rays": int(plan.weak_emitters.sum()),
        **{name: getattr(plan, name) for name in names},
        "outside_bands": {item.number: item.outside for item in truncation(bands)},
    }


def sensor_record(found: Readings) -> dict[str, Any]:
    """The numbers of a sensor as a whole, half widths of 95 % intervals beside them."""
    quantity, unit = ("luminance", "cd_m2") if found.kind == "luminance" else ("illuminance", "lx")
    levels = {"mean": "mean", "min": "lowest", "max": "highest"}
    numbers = {f"{key}_{quantity}": found.numbers[f"{name}_illuminance"] for key, name in levels.items()}
    ratios = {name: found.numbers[name] for name in ("uniformity", "diversity")}
    return {
        "kind": found.kind,
        "readings": len(found),
        **{
            key: float(value)
            for name, number in numbers.items()
            for key, value in (
                (f"{name}_{unit}", number.value),
                (f"{name}_half_width_{unit}", number.half_width),
            )
        },
        **{
            key: float(value)
            for name, number in ratios.items()
            for key, value in ((name, number.value), (f"{name}_half_width", number.half_width))
        },
        "accuracy": float(found.accuracy.max()),
        "median_interval_parts": interval_shares({found.sensor: found}),
        "enclosed_readings": int((found.enclosed > 0.5).sum()),
    }


def _blank_temperatures(found: Readings, bands: Bands) -> dict[str, int]:
    """By reason: how many readings have no colour temperature because of it."""
    reasons, counts = np.unique(temperature_reasons(found, bands), return_counts=True)
    return {REASONS[number]: int(count) for number, count in zip(reasons, counts) if number}


def versions() -> dict[str, str]:
    """Of this program and of what its numbers depend on."""
    found = {"python": platform.python_version(), "system": f"{sys.platform} {platform.machine()}"}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def to_json(value: Any, *, indent: int | None = None) -> str:
    """JSON text; numbers that are not finite become null."""
    return json.dumps(_plain(value), indent=indent, ensure_ascii=False)


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _repeat_with(solution: Solution) -> dict[str, Any] | None:
    """Options that give the same bits again, whatever ended the run: samples of a replicate times replicates.

    Where unsure readings got more samples, only the same way there repeats them: the accuracy that was asked for, and
    from where it set out; nothing does when the clock had a say in that too.
    """
    plan, count, options = solution.plan, solution.replicates, solution.record["options"]
    alike = {name: options[name] for name in ("lookup", "mode", "form_factors", "seed")}
    totals = ("rays_per_element", "light_points", "light_samples", "gather_samples")
    if solution.record["further_samples"]:
        if options["time"] is not None:
            return None
        start = ("replicates", "elements" if options["element_size"] is None else "element_size", *totals)
        paths = plan.gather_samples * options["replicates"]
        given = {name: options[name] for name in start} | {"gather_samples": paths}
        return {"accuracy": options["accuracy"], **given, **alike}
    samples = {name: getattr(plan, name) * count for name in totals}
    samples["light_samples"] = round(samples["light_samples"] / shared_rays(plan.n_emitters))
    return {"replicates": count, "element_size": plan.element_size, **samples, **alike}
