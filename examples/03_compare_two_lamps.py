"""Fit an office with one lamp, then with another of the same luminous flux, and see what changes for the eye.

Both are solved together, with the same rays: what they have in common cancels in the differences, and their intervals
are far narrower than those of the two numbers.

Run it with ``python examples/03_compare_two_lamps.py``.
"""

from pathlib import Path

import hradiosity
from hradiosity.model.scene import Scene, Variant
from hradiosity.model.variants import with_variant
from hradiosity.solution import Readings

SCENES = Path(__file__).resolve().parents[1] / "scenes"


def lit_by(scene: Scene, name: str) -> Variant:
    """The scene with the light of the luminaire ``name`` in all its sockets."""
    light = next(luminaire.exitance for luminaire in scene.luminaires if luminaire.name == name)
    return hradiosity.make_variant(scene, name, luminaires={lamp.name: light for lamp in scene.luminaires})


def melanopic_per_lux(eyes: Readings) -> float:
    """Mean melanopic EDI over mean illuminance."""
    return float(eyes.numbers["melanopic_edi_lx"].value.mean()) / eyes.mean_illuminance


office = hradiosity.load_scene(SCENES / "office")
cool = with_variant(office, lit_by(office, "cool_led"))
options = hradiosity.Options(element_size=0.5, gather_samples=512, seed=3)
solution = hradiosity.compare(cool, [lit_by(office, "tube")], options)
tube = solution.variants["tube"]
for name, unit in (("illuminance", "lx"), ("melanopic_edi_lx", "lx"), ("cct_k", "K")):
    change = tube.differences["eyes"].numbers[name]
    print(f"first eye, {name}: {change.value[0]:+.2f} ± {change.half_width[0]:.2f} {unit}")

ratio = melanopic_per_lux(tube.readings["eyes"]) / melanopic_per_lux(solution.readings["eyes"])
print(f"melanopic light per lux, tube over cool LED: {ratio:.4f}")
