"""Sensitivities in a render: following their run, and what they say in words."""

from __future__ import annotations

from hradiosity.cli.display import Display
from hradiosity.cli.text import percent
from hradiosity.device import Device
from hradiosity.errors import DeviceError
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.radiosity.sensitivity import Sensitivities, SensitivityRun

SENSITIVITY_TITLE = "What reflectances and lamps that are off by 2 % change, which intervals do not cover"
NOT_COVERED = "reflectances, spectra and geometry as the scene states them, and surfaces taken as matt"
"""What intervals take for exact."""
TOLD = 3
"""Reflectances, and lamps, that are told of each sensor; the file has all."""
OFF_BY = 0.02
LEAST_TOLD = 0.0005
"""Changes below this are not worth a word."""


def run_sensitivity(
    scene: Scene, options: Options, device: Device, display: Display
) -> tuple[Sensitivities | None, str, bool]:
    """What was found, or why nothing was, and whether that was interrupted."""
    run = SensitivityRun(scene, options, device)
    try:
        for state in run.states():
            display.stage(f"sensitivities: {run.done} of {run.count} parameters, replicate {state.replicate}")
    except KeyboardInterrupt:
        return None, "interrupted", True
    except (DeviceError, MemoryError) as error:
        return None, str(error) or "out of memory", False
    return run.found(), "", False


def sensitivity_lines(found: Sensitivities) -> list[str]:
    """A line a sensor for the reflectances, and one for the lamps, that change its mean illuminance most."""
    lines = []
    for sensor, parameters in found.items():
        for kinds in (("reflectance",), ("flux", "sky")):
            changes = [(OFF_BY * s.mean, p.name) for p, s in parameters.items() if p.kind in kinds]
            known = sorted((item for item in changes if item[0] >= LEAST_TOLD), reverse=True)[:TOLD]
            if known:
                told = ", ".join(f"{name} ±{percent(change)}" for change, name in known)
                lines.append(f"{sensor}, by {'materials' if kinds == ('reflectance',) else 'lights'}: {told}")
    return lines
