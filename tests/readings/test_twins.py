"""Noise of the elements told apart from that of the readings' own rays."""

import numpy as np
import pytest

from hradiosity.readings.twins import MOST_TWINS, CommonNoise, proved_variance, twin_points


def pairs(rng, surface, own, n_points=MOST_TWINS, replicates=8):
    """Brightnesses a thousand times apart, read twice in each replicate; 1 % of noise for a unit of each kind."""
    level = np.geomspace(1.0, 1000.0, n_points)
    common = surface * rng.normal(size=(replicates, n_points))
    return [level * (1.0 + 0.01 * (common + own * rng.normal(size=common.shape))) for _ in range(2)]


@pytest.mark.parametrize(("surface", "own"), [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 2.0)])
def test_common_noise_is_found(surface, own):
    """The mean of many runs of eight replicates is the true variance, and its uncertainty is what they spread by."""
    rng = np.random.default_rng(4)
    found = [CommonNoise.of(*pairs(rng, surface, own)) for _ in range(200)]
    variance = 1e4 * np.array([some.variance for some in found])
    uncertainty = 1e4 * np.mean([some.uncertainty for some in found])
    assert variance.mean() == pytest.approx(surface**2, abs=4.0 * variance.std() / len(found) ** 0.5 + 0.01)
    assert uncertainty == pytest.approx(variance.std(), rel=0.5)
    if surface == 0.0:
        proved = [some.proved for some in found]
        assert np.mean(np.array(proved) == 0.0) > 0.75


def test_of_single_points_little_is_proved_by_chance_and_much_if_it_is_there():
    rng = np.random.default_rng(6)
    assert np.mean(proved_variance(*pairs(rng, 0.0, 1.0, 4000)) > 0.0) < 0.12
    assert np.mean(proved_variance(*pairs(rng, 1.0, 0.1, 4000)) > 0.0) > 0.97


def test_the_surer_counts_and_few_replicates_or_points_say_nothing():
    rng = np.random.default_rng(5)
    some = CommonNoise.of(*pairs(rng, 1.0, 1.0))
    assert CommonNoise().surer(some) == some == some.surer(CommonNoise())
    assert CommonNoise.of(*pairs(rng, 1.0, 1.0, replicates=3)) == CommonNoise()
    assert CommonNoise.of(*pairs(rng, 1.0, 1.0, n_points=3)) == CommonNoise()
    assert CommonNoise.of(np.zeros((8, 20)), np.zeros((8, 20))) == CommonNoise()
    assert len(twin_points(0)) == 0 and twin_points(3).tolist() == [0, 1, 2] and len(twin_points(400)) == MOST_TWINS
