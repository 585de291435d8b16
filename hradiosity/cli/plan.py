"""``hradiosity plan``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hradiosity.cli.settings import Settings


def plan(scene: Path, /, *, settings: Settings | None = None, json: bool = False) -> int:
    """Say what a render would compute, leave out and cost, without doing it.

    Parameters
    ----------
    scene
        Folder with scene.toml, or the file.
    json
        One JSON object instead of words.
    """
    from hradiosity.cli.expected import accuracy_lines
    from hradiosity.cli.imaging import image_plan_lines
    from hradiosity.cli.text import note_lines
    from hradiosity.device import Device
    from hradiosity.io.calibration import load_calibration
    from hradiosity.io.run_record import plan_record, to_json
    from hradiosity.io.scene_toml import load_scene
    from hradiosity.metrics.truncation import truncation_lines
    from hradiosity.radiosity import make_solver

    chosen = settings or Settings()
    options = replace(chosen.options(), pictures=True)
    loaded = load_scene(scene)
    device = Device(chosen.device)
    solver = make_solver(loaded, options, device, load_calibration(device.description, options.mode))
    made = solver.plan
    images = image_plan_lines(loaded, device.description) if chosen.quality == "image" else []
    if json:
        print(to_json({**plan_record(made, loaded.bands), **({"drawn": images} if images else {})}))
        return 0
    expected = accuracy_lines(loaded, options, device.description)
    remarks = note_lines(solver.notes, all_of_them=True)
    for line in (
        *remarks,
        *made.lines(),
        *truncation_lines(loaded.bands),
        *images,
        *expected,
        f"device: {device.description}",
    ):
        print(line)
    return 0
