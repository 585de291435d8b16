"""Solve the Cornell box, and see how much a red wall colours the white floor beside it.

Run it with ``python examples/01_cornell_box.py``.
"""

from pathlib import Path

import hradiosity

SCENES = Path(__file__).resolve().parents[1] / "scenes"

scene = hradiosity.load_scene(SCENES / "cornell_box")
solution = hradiosity.solve(scene, hradiosity.Options(gather_samples=512))

# Irradiance is in W m⁻² per band, one row a reading and one column a band.
floor = solution.readings["floor"]
long_waves = floor.irradiance[:, scene.bands.centre > 600].sum(axis=1)
share = long_waves / floor.irradiance.sum(axis=1).clip(min=1e-12)

# The red wall stands at x = 0.55 m, the green one at x = 0.
beside_red = share[(floor.position[:, 0] > 0.45) & (floor.illuminance > 0)].mean()
beside_green = share[(floor.position[:, 0] < 0.10) & (floor.illuminance > 0)].mean()

print(f"back wall: {solution.readings['back wall'].mean_illuminance:.1f} lx in the mean")
print(f"light above 600 nm, beside the red wall over beside the green wall: {beside_red / beside_green:.3f}")
