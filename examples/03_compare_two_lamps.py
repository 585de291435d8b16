"""Fit an office with one lamp, then with another of the same luminous flux, and see what changes for the eye.

Both runs use the same seed, hence the same rays, so that their ratio is sharper than either of the two numbers.

Run it with ``python examples/03_compare_two_lamps.py``.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

import hradiosity
from hradiosity.metrics.eye import RECEPTORS, alpha_opic_irradiance
from hradiosity.model.scene import Scene

SCENES = Path(__file__).resolve().parents[1] / "scenes"


def lit_by(scene: Scene, name: str) -> Scene:
    """The scene with the luminaire ``name`` in all its sockets."""
    number = [luminaire.name for luminaire in scene.luminaires].index(name)
    everywhere = np.full_like(scene.emitters.luminaire, number)
    return replace(scene, emitters=replace(scene.emitters, luminaire=everywhere))


def mean_melanopic_and_lux(scene: Scene) -> tuple[float, float]:
    """Mean melanopic irradiance [W m⁻²] and illuminance [lx] at the eyes."""
    solution = hradiosity.solve(scene, hradiosity.Options(element_size=0.5, gather_samples=512, seed=3))
    eyes = solution.readings["eyes"]
    receptors = alpha_opic_irradiance(eyes.irradiance, scene.bands)
    return float(receptors[:, RECEPTORS.index("melanopic")].mean()), eyes.mean_illuminance


office = hradiosity.load_scene(SCENES / "office")
ratios = {}
for lamp in ("cool_led", "tube"):
    melanopic, lux = mean_melanopic_and_lux(lit_by(office, lamp))
    ratios[lamp] = melanopic / lux
    print(f"{lamp}: {lux:.1f} lx, {1000 * ratios[lamp]:.3f} mW/lm melanopic at the eyes")

print(f"melanopic light per lux, tube over cool LED: {ratios['tube'] / ratios['cool_led']:.4f}")
