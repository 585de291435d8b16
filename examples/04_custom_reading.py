"""Read places that the scene file does not name, and see whether a face in the aisle is well modelled.

Cylindrical illuminance is the mean of the vertical illuminance over all directions; EN 12464-1 asks that it be between
0.30 and 0.60 of the horizontal illuminance, so that faces look neither flat nor harsh.

Run it with ``python examples/04_custom_reading.py``.
"""

from pathlib import Path

import numpy as np

import hradiosity

SCENES = Path(__file__).resolve().parents[1] / "scenes"
FACE = (3.0, 3.2, 1.6)
DIRECTIONS = 16

scene = hradiosity.load_scene(SCENES / "office")
solution = hradiosity.solve(scene, hradiosity.Options(element_size=0.4, gather_samples=512))

angle = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
around = np.stack([np.cos(angle), np.sin(angle), np.zeros(DIRECTIONS)], axis=1)
vertical = solution.read(np.tile(FACE, (DIRECTIONS, 1)), around)
horizontal = solution.read(FACE, (0, 0, 1))

print(f"cylindrical: {vertical.mean_illuminance:.0f} ± {vertical.mean_illuminance_half_width:.0f} lx")
print(f"horizontal: {horizontal.mean_illuminance:.0f} ± {horizontal.mean_illuminance_half_width:.0f} lx")
print(f"modelling index: {vertical.mean_illuminance / horizontal.mean_illuminance:.3f}")
