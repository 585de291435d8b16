"""Guides are made where they save more paths than they cost."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver
from hradiosity.readings.guide_trial import GUIDE_RAY, ONE_IN, TRIED, Tried, pays


def tried(of_set, of_path=0.3):
    return Tried(np.full(4, 1.0), np.full(4, of_path), np.full(4, of_set))


def test_a_guide_pays_by_what_its_rays_would_bring_as_paths():
    other, seen = np.full(4, 1.0), np.full(4, 0.2)
    worth = 1.0 + GUIDE_RAY * 1024 / 512
    assert pays(tried(1e-4), tried(1.01e-4 * worth), seen, other, 512)
    assert not pays(tried(1e-4), tried(0.99e-4 * worth), seen, other, 512)
    assert pays(tried(1e-4), tried(0.99e-4 * worth), seen, other, 1024)


def test_rare_light_that_even_paths_missed_counts():
    other, seen = np.full(4, 1.0), np.full(4, 30.0)
    assert pays(tried(1e-4), tried(1e-5), seen, other, 512)
    assert pays(tried(1e-4), tried(0.0, of_path=0.0), seen, other, 512)


def test_numbers_of_a_trial_are_means_and_variances():
    rng = np.random.default_rng(1)
    brightness = rng.exponential(1.0, (4000, 16, 3))
    found = Tried.of(np.stack([brightness.mean(axis=1), (brightness**2).mean(axis=1)], axis=1))
    assert found.mean == pytest.approx(1.0, abs=0.02)
    assert found.of_path == pytest.approx(1.0, abs=0.05)
    assert found.of_set == pytest.approx(1.0 / 16.0, rel=0.1)


@pytest.mark.parametrize("wall", [False, True])
def test_a_box_of_one_paint_needs_none_and_a_room_behind_a_gap_does(device, wall):
    b = SceneBuilder(1)
    grey = b.material(0.6)
    b.box((0, 0, 0), (4, 4, 3), grey, inward=True)
    if wall:
        b.box((2.0, 0, 0), (2.2, 3.8, 3), grey)
    b.lamp(b.patch((0.8, 0.8, 2.9), (0, 0.4, 0), (0.4, 0, 0), grey), 100.0)
    n = ONE_IN * TRIED[0]
    places = np.column_stack([np.linspace(2.5, 3.8, n), np.full(n, 0.7), np.full(n, 0.8)])
    b.sensor(places, np.tile((0.0, 0.0, 1.0), (n, 1)))
    solver = RadiositySolver(b.scene(), Options(elements=300, replicates=2, gather_samples=96), device)
    next(state for state in solver.states() if state.stage == "replicate")
    assert solver.checkpoint()["readings/effort/guide/share"].shape[1] == (1024 if wall else 0)
