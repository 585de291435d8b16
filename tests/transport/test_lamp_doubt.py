"""Lamps of which elements see little: more points there, the same light in the mean, and less noise."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.lamp_choice import light_without_obstacles
from hradiosity.transport.lamp_doubt import TIMES, points_for_lamps

EMISSION = np.ones((1, 8), np.float32)


def floor_behind_a_wall(device, *, slit):
    """A floor of 8 m with a lamp over one half and a wall up to the lamp across, with a slit of 10 cm or without."""
    b = SceneBuilder()
    grey = b.material(0.5)
    b.patch((0, 0, 0), (8, 0, 0), (0, 8, 0), grey)
    if slit:
        b.patch((4, 0, 0), (0, 3.95, 0), (0, 0, 3), grey)
        b.patch((4, 4.05, 0), (0, 3.95, 0), (0, 0, 3), grey)
    b.lamp(b.patch((1.5, 3.5, 3), (0, 1, 0), (1, 0, 0), grey), 1.0)
    scene = b.scene()
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    elements = build_elements(scene.patches, lit.space, np.array([m.two_sided for m in scene.materials]), 0.5)
    return upload_scene(device, scene, bvh, occlusion=True), upload_elements(device, elements)


def lamp_points(scene, elements):
    return points_for_lamps(scene, elements, light_without_obstacles(scene, elements), EMISSION, None, 4, 1)


def test_more_points_behind_the_slit_and_nowhere_else(device):
    scene, elements = floor_behind_a_wall(device, slit=True)
    points = lamp_points(scene, elements)
    assert points is not None and set(np.unique(points)) == {4, 4 * TIMES}
    assert 0.02 < (points > 4).mean() < 0.2
    assert lamp_points(*floor_behind_a_wall(device, slit=False)) is None


def test_they_change_the_noise_and_not_the_mean(device):
    """Over 64 seeds: sums of what these elements get agree, with less than half of the variance."""
    scene, elements = floor_behind_a_wall(device, slit=True)
    points = lamp_points(scene, elements)
    assert points is not None
    some = points[:, 0] > 4
    uploaded = device.upload(points)
    found = []
    for seed in range(64):
        hits = trace_rows(scene, elements, 32, seed)
        few, more = (direct_on_rows(scene, elements, hits, 4, seed, points=given) for given in (None, uploaded))
        np.testing.assert_array_equal(few[~some], more[~some])
        found.append((few[some].sum(dtype=float), more[some].sum(dtype=float)))
    few, more = np.array(found).T
    error = np.hypot(few.std(ddof=1), more.std(ddof=1)) / 8.0
    assert few.mean() == pytest.approx(more.mean(), abs=4 * error)
    assert more.var() < 0.5 * few.var()
