"""Lamps that are tried by chance: nothing is missed in the mean, and near ones are always tried."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.shafts import HIDDEN
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.direct import direct_on_rows, light_of_emitters
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.lamp_choice import (
    CLEAR_SHARE,
    FOUND_SHARE,
    LEAST_PROBABILITY,
    TRIED,
    drawn_at_hits,
    lamp_probability,
    light_without_obstacles,
)

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


def clear_light(scene, elements):
    return light_without_obstacles(scene, elements, roughly=True)


def test_nothing_is_missed_in_the_mean(device, hall):
    """Light of all lamps on each element, over 60 seeds, within four standard errors of trying all of them."""
    scene, elements = hall
    chance = lamp_probability(scene, clear_light(scene, elements), emission(SIDE**2), None)
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
    chance = lamp_probability(scene, clear_light(scene, elements), emission(SIDE**2), None)
    assert chance.min() == pytest.approx(LEAST_PROBABILITY) and chance.max() == 1.0
    tried = chance.sum(axis=1)
    sees_none = chance.min(axis=1) == 1.0
    assert tried[~sees_none].max() <= TRIED + SIDE**2 * LEAST_PROBABILITY and (~sees_none).sum() > 60
    bright = emission(SIDE**2)
    bright[5] = 1e4
    assert (lamp_probability(scene, clear_light(scene, elements), bright, None)[~sees_none, 5] == 1.0).mean() > 0.8


def test_lamps_proved_hidden_take_no_share(hall):
    scene, elements = hall
    sight = np.zeros((len(elements.elements), SIDE**2), np.uint8)
    sight[:, 1:] = HIDDEN
    chance = lamp_probability(scene, clear_light(scene, elements), emission(SIDE**2), sight)
    sees = chance[:, 0] > LEAST_PROBABILITY
    assert sees.sum() > 40 and (chance[sees, 0] == 1.0).all()


def test_few_lamps_are_all_tried(device, hall):
    scene, elements = hall
    assert lamp_probability(scene.without_occlusion(), clear_light(scene, elements), emission(SIDE**2), None) is None


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


def test_lamps_are_drawn_at_hits_by_what_was_found_and_what_could_come(device, hall):
    scene, _ = hall
    rng = np.random.default_rng(3)
    direct, clear = rng.random((2, 70, 5)).astype(np.float32)
    direct[0], clear[1], direct[2], clear[2], direct[3, 1] = 0.0, 0.0, 0.0, 0.0, -1.0
    bright = np.repeat(np.array([[1.0], [4.0], [0.0], [2.0], [1.0]], np.float32), 8, axis=1)
    sums = device.fetch(drawn_at_hits(scene, device.upload(direct), device.upload(clear), bright))
    found, without = (np.maximum(light, 0.0) * bright[:, 0] for light in (direct, clear))
    expected = np.zeros_like(found)
    for share, light in ((FOUND_SHARE, found), (CLEAR_SHARE, without)):
        total = light.sum(axis=1, keepdims=True)
        expected += share * np.divide(light, total, out=np.zeros_like(light), where=total > 0.0)
    expected += (1.0 - expected.sum(axis=1, keepdims=True)) / 5
    np.testing.assert_allclose(np.diff(sums, axis=1, prepend=0.0), expected, atol=3e-7)
    assert (sums[:, -1] == 1.0).all() and expected.min() > 0.99 * (1.0 - FOUND_SHARE - CLEAR_SHARE) / 5


def test_light_of_all_lamps_is_a_product(device):
    rng = np.random.default_rng(5)
    direct = rng.random((90, 40)) * (rng.random((90, 40)) < 0.2)
    emission = rng.random((40, 16))
    light = light_of_emitters(
        device, device.upload(direct, np.float32), device.upload(emission, np.float32), direct.shape
    )
    np.testing.assert_allclose(light, direct @ emission, rtol=1e-5)
    empty = light_of_emitters(device, device.upload(np.zeros((7, 0), np.float32)), device.upload(emission[:1]), (7, 0))
    assert empty.shape == (7, 16) and not empty.any()
