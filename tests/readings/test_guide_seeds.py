"""Parts of hemispheres that lead to known places: the inverse of how directions are drawn."""

import numpy as np
from device_call import device_call

from hradiosity.readings.guide import SIDE
from hradiosity.readings.guide_seeds import parts_towards


def test_parts_are_those_that_directions_are_drawn_from(device):
    """A place along a direction that was drawn at (u, v) lies in the part that (u, v) is in."""
    rng = np.random.default_rng(7)
    normal = rng.normal(size=(500, 3))
    normal = np.concatenate([normal / np.linalg.norm(normal, axis=1)[:, None], np.eye(3), -np.eye(3)])
    n = len(normal)
    uv = rng.random((n, 2)).astype(np.float32)
    drawn = device_call(
        device,
        "hr_sampling.h",
        "hr_cosine_direction(n, u, v)",
        "float3",
        n=normal.astype(np.float32),
        u=uv[:, 0].copy(),
        v=uv[:, 1].copy(),
    ).astype(np.float64)
    position = rng.normal(size=(n, 3))
    place = position + 3.0 * drawn
    part = np.array([parts_towards(position[k : k + 1], normal[k : k + 1], place[k : k + 1])[0, 0] for k in range(n)])
    within = SIDE * uv.astype(np.float64)
    # Rounding counts at the edges of parts, and at the horizon, where the disk ends.
    sure = (np.abs(within - np.rint(within)) > 1e-2).all(axis=1) & (np.abs(2.0 * uv - 1.0).max(axis=1) < 0.999)
    assert sure.mean() > 0.9
    column, row = np.floor(within).astype(int).T
    np.testing.assert_array_equal(part[sure], (row * SIDE + column)[sure])


def test_places_behind_lie_in_no_part():
    up = np.array([[0.0, 0.0, 1.0]])
    part = parts_towards(np.zeros((1, 3)), up, np.array([[0.0, 0.0, -1.0], [1.0, 0.0, -0.1], [0.1, 0.1, 1.0]]))
    assert (part[0, :2] == -1).all() and part[0, 2] >= 0
    assert parts_towards(np.zeros((1, 3)), up, np.zeros((0, 3))).shape == (1, 0)
