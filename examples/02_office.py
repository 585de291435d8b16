"""Light the desks of an office, with the interval that each number carries.

Run it with ``python examples/02_office.py``.
"""

from pathlib import Path

import hradiosity

SCENES = Path(__file__).resolve().parents[1] / "scenes"

scene = hradiosity.load_scene(SCENES / "office")
solution = hradiosity.solve(scene, hradiosity.Options(element_size=0.4, gather_samples=512))

desk = solution.readings["desk"]
darkest = desk.illuminance.argmin()
x, y, z = desk.position[darkest]
print(f"darkest of {len(desk)} points: ({x:.2f}, {y:.2f}, {z:.2f}) m")
print(f"there: {desk.illuminance[darkest]:.0f} ± {desk.illuminance_half_width[darkest]:.0f} lx")
eyes = solution.readings["eyes"]
for number, (eye, half_width) in enumerate(zip(eyes.illuminance, eyes.illuminance_half_width, strict=True)):
    print(f"eye {number}: {eye:.0f} ± {half_width:.0f} lx")

print(f"mean desk illuminance in lx, ± {desk.mean_illuminance_half_width:.1f}: {desk.mean_illuminance:.1f}")
