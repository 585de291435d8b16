"""Noise of the elements told apart from that of the readings' own rays."""

import numpy as np
import pytest

from hradiosity.readings.twins import MOST_TWINS, Twins


@pytest.mark.parametrize(("surface", "own"), [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 2.0)])
def test_common_noise_is_found(surface, own):
    """Of brightnesses a thousand times apart; the mean of many runs of eight replicates is the true share."""
    rng = np.random.default_rng(4)
    level = np.geomspace(1.0, 1000.0, MOST_TWINS)
    shares = []
    for _ in range(60):
        twins = Twins(400)
        for _ in range(8):
            common = surface * rng.normal(size=MOST_TWINS)
            twins.add(*(level * (1.0 + 0.01 * (common + own * rng.normal(size=MOST_TWINS))) for _ in range(2)))
        shares.append(twins.surface_share)
    true = surface**2 / (surface**2 + own**2)
    assert np.mean(shares) == pytest.approx(true, abs=0.05)


def test_a_checkpoint_keeps_them_and_few_replicates_say_nothing():
    rng = np.random.default_rng(5)
    first, again = Twins(3), Twins(3)
    for _ in range(3):
        first.add(*rng.random((2, 3)))
    assert first.surface_share == 0.0
    again.restore(first.checkpoint())
    last = rng.random((2, 3))
    first.add(*last)
    again.add(*last)
    assert again.surface_share == first.surface_share
    assert Twins(0).surface_share == 0.0
