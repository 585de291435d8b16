"""Form factors alone: the share of sky that a street sees, and what an awning takes of it from the pavement.

The sky over a street canyon is the polygon between its roofs. No scene file is needed, only corners in metres.

Run it with ``python examples/05_sky_view.py``.
"""

import numpy as np

import hradiosity

LENGTH, WIDTH, HEIGHT = 60.0, 12.0, 15.0
AWNING_HEIGHT, AWNING_DEPTH, PAVEMENT = 3.0, 2.0, 3.0


def flat(x0: float, x1: float, z: float, *, up: bool) -> np.ndarray:
    """A rectangle over the length of the street that looks up or down."""
    ring = np.array([[x0, 0, z], [x1, 0, z], [x1, LENGTH, z], [x0, LENGTH, z]])
    return ring if up else ring[::-1]


def facade(x: float, towards: int) -> np.ndarray:
    """A wall of the street that looks along +x (towards = 1) or -x (-1)."""
    ring = np.array([[x, 0, 0], [x, LENGTH, 0], [x, LENGTH, HEIGHT], [x, 0, HEIGHT]])
    return ring[::towards]


device = hradiosity.Device()
surfaces = {
    "ground": flat(0, WIDTH, 0, up=True),
    "west facade": facade(0, 1),
    "east facade": facade(WIDTH, -1),
}
sky = flat(0, WIDTH, HEIGHT, up=False)
seen = hradiosity.form_factor(list(surfaces.values()), sky, device=device)
for name, value, error, method in zip(surfaces, seen.value, seen.error, seen.method):
    print(f"{name} sees the sky with {value:.6f} ± {error:.0e} of its view ({method})")

awning = flat(0, AWNING_DEPTH, AWNING_HEIGHT, up=False)
pavement = flat(0, PAVEMENT, 0, up=True)
before = hradiosity.form_factor(pavement, sky, device=device)
after = hradiosity.form_factor(pavement, sky, occluders=awning, visibility_tolerance=2e-3, device=device)
print(f"pavement: {before.value:.4f} without awning, {after.value:.4f} ± {after.error:.4f} with it")
print(f"share of the pavement's sky that the awning leaves: {after.visibility:.3f}")
