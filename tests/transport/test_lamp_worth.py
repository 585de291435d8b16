"""Points for lamps by what they are worth: none where noise is low, more where it counts, and the same light."""

import numpy as np
import pytest
from test_lamp_doubt import floor_behind_a_wall

from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.lamp_choice import light_without_obstacles
from hradiosity.transport.lamp_worth import EXTRA, MOST_TIMES, points_by_worth


def points_of(scene, elements, worth, tolerance=0.0):
    clear = light_without_obstacles(scene, elements)
    return points_by_worth(scene, elements, clear, worth[:, None] * clear, None, 4, 1, tolerance=tolerance)


def test_points_follow_worth(device):
    scene, elements = floor_behind_a_wall(device, slit=True)
    n = len(elements.elements)
    even = points_of(scene, elements, np.ones(n))
    assert even is not None and even.min() == 4 and even.max() <= 4 * MOST_TIMES
    assert even.mean() <= 4 * (1.0 + EXTRA) + 0.5
    some = np.flatnonzero(even[:, 0] > 4)
    worth = np.ones(n)
    worth[some[::2]] = 0.0
    fewer = points_of(scene, elements, worth)
    assert (fewer[some[::2]] == 4).all() and (fewer[some[1::2]] >= even[some[1::2]]).all()
    assert points_of(scene, elements, np.ones(n), tolerance=1e3) is None
    scene, elements = floor_behind_a_wall(device, slit=False)
    assert points_of(scene, elements, np.zeros(len(elements.elements))) is None


def test_they_change_the_noise_and_not_the_mean(device):
    """Over 64 seeds: the sum of all light agrees, with less than half of the variance; points may exceed the rays."""
    scene, elements = floor_behind_a_wall(device, slit=True)
    points = points_of(scene, elements, np.ones(len(elements.elements)))
    assert points is not None and points.max() > 32
    uploaded = device.upload(points)
    some = points[:, 0] > 4
    found = []
    for seed in range(64):
        hits = trace_rows(scene, elements, 32, seed)
        pair = (direct_on_rows(scene, elements, hits, 4, seed, points=given) for given in (None, uploaded))
        found.append([light[some].sum(dtype=float) for light in pair])
    few, more = np.array(found).T
    error = np.hypot(few.std(ddof=1), more.std(ddof=1)) / 8.0
    assert few.mean() == pytest.approx(more.mean(), abs=4 * error)
    assert more.var() < 0.5 * few.var()
