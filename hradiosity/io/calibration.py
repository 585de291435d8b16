"""How fast each device of this machine was in earlier runs, and which kernels were built for it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, fields

from hradiosity.io.builds import DEVICES_FILE
from hradiosity.io.cache import load_devices, store_devices
from hradiosity.options import Mode
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.planning_classic import pixels_drawn, products
from hradiosity.planning_seconds import reading_paths, solution_rays
from hradiosity.solution import Solution

_KEPT_BUILDS = 200
_IMAGES = "image_s_per_point"
_KINDS: dict[Mode, tuple[type[Calibration | ClassicCalibration], str]] = {
    "rays": (Calibration, "calibration"),
    "classic": (ClassicCalibration, "classic"),
}
"""What is kept for each mode, and under which name."""
_CLASSIC_STAGES = ("lamps", "sky", "shooting", "readings")


def load_calibration(device: str, mode: Mode = "rays") -> Calibration | ClassicCalibration | None:
    """Speeds of a device, by its description, in one mode; None when they were never measured."""
    kind, entry = _KINDS[mode]
    kept = load_devices(DEVICES_FILE).get(device, {}).get(entry)
    if not isinstance(kept, dict) or kept.keys() != {field.name for field in fields(kind)}:
        return None
    return kind(**{name: float(value) for name, value in kept.items()})


def store(device: str, builds: Iterable[str], calibration: Calibration | ClassicCalibration | None) -> bool:
    """Keep what a run measured; a calibration of None leaves the earlier ones, and that of a mode the other mode's.

    Returns
    -------
    bool
        False when the cache can't be written, which harms nothing.
    """
    kept = load_devices(DEVICES_FILE)
    entry = kept.setdefault(device, {})
    known = list(entry.get("builds", ()))
    entry["builds"] = (known + [build for build in builds if build not in known])[-_KEPT_BUILDS:]
    if calibration is not None:
        entry[next(name for kind, name in _KINDS.values() if isinstance(calibration, kind))] = asdict(calibration)
    return store_devices(DEVICES_FILE, kept)


def load_image_pace(device: str) -> float | None:
    """Seconds for a point of an image and eight bands, as an earlier one took; None when there was none."""
    kept = load_devices(DEVICES_FILE).get(device, {}).get(_IMAGES)
    return float(kept) if isinstance(kept, (int, float)) else None


def store_image_pace(device: str, seconds: float) -> bool:
    """Keep that; False when the cache can't be written."""
    kept = load_devices(DEVICES_FILE)
    kept.setdefault(device, {})[_IMAGES] = seconds
    return store_devices(DEVICES_FILE, kept)


def measure(solution: Solution) -> Calibration | ClassicCalibration | None:
    """Speeds from a finished run; None when it left a stage out, hardly took any time, or had no rows of rays."""
    if solution.plan.links is not None or solution.plan.pairs:
        return None
    return _measure_classic(solution) if solution.plan.hemicubes else _measure_rays(solution)


def _measure_classic(solution: Solution) -> ClassicCalibration | None:
    plan, record = solution.plan, solution.record
    drawn, drawing = record["hemicubes"]["drawn"], record["hemicubes"]["seconds"]
    resolution = record["options"]["hemicube_resolution"]
    rest = sum(record["stage_seconds"].get(stage, 0.0) for stage in _CLASSIC_STAGES) - drawing
    shots = int(sum(solved["products"] for solved in record["solver"]) * plan.shooters)
    done = products(shots, drawn, plan.shooters, plan.columns.n_columns)
    if drawing < 0.01 or rest < 0.01 or not shots:
        return None
    return ClassicCalibration(drawing / drawn / pixels_drawn(resolution, plan.n_patches), rest / done)


def _measure_rays(solution: Solution) -> Calibration | None:
    plan, seconds, count = solution.plan, solution.record["stage_seconds"], solution.replicates
    rows = len(solution.elements)
    rays = count * rows * plan.rays_per_element
    shadow_rays = count * rows * plan.n_emitters * plan.light_points
    paths = count * reading_paths(plan)
    stages = ("exchange rays", "direct light", "exchange", "solution", "readings")
    if not (plan.interreflection and plan.occlusion and plan.n_readings and shadow_rays):
        return None
    if any(seconds.get(stage, 0.0) < 0.01 for stage in stages):
        return None
    return Calibration(
        exchange_rays_per_s=rays / seconds["exchange rays"],
        shadow_rays_per_s=shadow_rays / seconds["direct light"],
        reading_paths_per_s=paths / seconds["readings"],
        exchange_s_per_ray=seconds["exchange"] / rays,
        solve_s_per_ray_column=(seconds["solution"] + seconds.get("companion", 0.0))
        / (count * solution_rays(plan, rows))
        / (8 * plan.columns.n_groups),
    )
