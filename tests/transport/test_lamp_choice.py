"""Lamps that are tried by chance: nothing is missed in the mean, and near ones are always tried."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.shafts import HIDDEN
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.lamp_choice import LEAST_PROBABILITY, TRIED, lamp_probability, light_without_obstacles

SIDE = 9


@pytest.fixture(scope="module")
def hall(device):
    """A floor of 27 m under 81 lamps, with a screen across; scene on the device, elements there, rays from them."""
    b = SceneBuilder()
    grey = b.material(0.5)
    b.patch((0, 0, 0), (27, 0, 0), (0, 27, 0), grey)
    b.patch((13.4, 0, 0), (0, 27, 0), (0, 0, 2.5), grey)
    for i in range(SIDE):
        for j in range(SIDE):
            b.lamp(b.patch((3 * i + 1, 3 * j + 1, 3), (0, 1, 0), (1, 0, 0), grey), 1.0)
    scene = b.scene()
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    elements = build_elements(scene.patches, lit.space, np.array([m.two_sided for m in scene.materials]), 3.0)
    on_device, uploaded = upload_scene(device, scene, bvh, occlusion=True), upload_elements(device, elements)
    return on_device, uploaded


def emission(n_emitters):
    return np.ones((n_emitters, 8), np.float32)


def test_nothing_is_missed_in_the_mean(device, hall):
    """Light of all lamps on each element, over 60 seeds, within four standard errors of trying all of them."""
    scene, elements = hall
    chance = lamp_probability(scene, elements, emission(SIDE**2), None)
    assert chance is not None and chance.shape == (len(elements.elements), SIDE**2)
    tried = device.upload(chance)
    found = {None: [], "chance": []}
    for seed in range(60):
        hits = trace_rows(scene, elements, 16, seed)
        found[None].append(direct_on_rows(scene, elements, hits, 4, seed).sum(axis=1, dtype=float))
        found["chance"].append(direct_on_rows(scene, elements, hits, 4, seed, tried).sum(axis=1, dtype=float))
    every, some = (np.array(values) for values in found.values())
    error = np.hypot(every.std(axis=0, ddof=1), some.std(axis=0, ddof=1)) / np.sqrt(60)
    lit = every.mean(axis=0) > 1e-3
    assert lit.sum() > 60
    score = (some.mean(axis=0) - every.mean(axis=0))[lit] / error[lit]
    assert np.abs(score).max() < 4.5 and abs(score.mean()) < 4.0 / np.sqrt(lit.sum()) + 0.1
    assert np.abs(score).max() > 0.5


def test_near_lamps_are_always_tried_and_far_ones_seldom(hall):
    scene, elements = hall
    chance = lamp_probability(scene, elements, emission(SIDE**2), None)
    assert chance.min() == pytest.approx(LEAST_PROBABILITY) and chance.max() == 1.0
    tried = chance.sum(axis=1)
    sees_none = chance.min(axis=1) == 1.0
    assert tried[~sees_none].max() <= TRIED + SIDE**2 * LEAST_PROBABILITY and (~sees_none).sum() > 60
    bright = emission(SIDE**2)
    bright[5] = 1e4
    assert (lamp_probability(scene, elements, bright, None)[~sees_none, 5] == 1.0).mean() > 0.8


def test_lamps_proved_hidden_take_no_share(hall):
    scene, elements = hall
    sight = np.zeros((len(elements.elements), SIDE**2), np.uint8)
    sight[:, 1:] = HIDDEN
    chance = lamp_probability(scene, elements, emission(SIDE**2), sight)
    sees = chance[:, 0] > LEAST_PROBABILITY
    assert sees.sum() > 40 and (chance[sees, 0] == 1.0).all()


def test_few_lamps_are_all_tried(device, hall):
    scene, elements = hall
    assert lamp_probability(scene.without_occlusion(), elements, emission(SIDE**2), None) is None


def test_rough_light_is_that_of_far_lamps_within_a_few_per_cent(hall):
    scene, elements = hall
    exact, rough = (light_without_obstacles(scene, elements, roughly=roughly) for roughly in (False, True))
    assert np.abs(rough - exact).sum() < 0.03 * exact.sum()
    assert not np.array_equal(rough, exact)
    chance, sure = (_chances(light) for light in (rough, exact))
    assert np.abs(chance - sure).mean() < 0.01


def _chances(light):
    share = light / np.maximum(light.sum(axis=1, keepdims=True), 1e-30)
    return np.clip(TRIED * share, LEAST_PROBABILITY, 1.0)
