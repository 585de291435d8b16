"""Draws the first previews of a run and prints when: ``python -m hradiosity.suites.bench.first_picture``."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.show.first_picture import write_first_picture


def main() -> None:
    """Take a scene file and the picture to write; print seconds since the epoch as JSON."""
    scene_file, picture = map(Path, sys.argv[1:])
    scene = load_scene(scene_file)
    device = Device()
    write_first_picture(scene, device, picture)
    moments = {"guessed": time.time()}
    # As in a run, the solver is loaded once that picture is there.
    from hradiosity.options import Options
    from hradiosity.radiosity import make_solver
    from hradiosity.show.preview import Preview

    solver = make_solver(scene, Options(pictures=True), device)
    for _ in solver.states():
        if solver.replicates:
            Preview(solver.scene, device, bvh=solver.on_device.bvh).write(solver, picture)
            moments["computed"] = time.time()
            break
    print(json.dumps(moments))


if __name__ == "__main__":
    main()
