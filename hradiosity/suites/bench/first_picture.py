"""Draws the two first previews of a run and prints when: ``python -m hradiosity.suites.bench.first_picture``."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.show.preview import Preview


def main() -> None:
    """Take a scene file and the picture to write; print seconds since the epoch as JSON."""
    scene_file, picture = map(Path, sys.argv[1:])
    scene = load_scene(scene_file)
    solver = make_solver(scene, Options(pictures=True), Device())
    moments: dict[str, float] = {}
    preview: Preview | None = None
    for _ in solver.states():
        preview = preview or Preview(solver.scene, solver.on_device.device, bvh=solver.on_device.bvh)
        preview.write(solver, picture)
        moments.setdefault("light" if solver.replicates else "paints", time.time())
        if solver.replicates:
            break
    print(json.dumps(moments))


if __name__ == "__main__":
    main()
