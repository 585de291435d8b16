"""How even light is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.metrics.uniformity import even_light


def test_by_hand():
    found = even_light(np.array([200.0, 500.0, 800.0]))
    assert (found.mean, found.lowest, found.highest) == (500.0, 200.0, 800.0)
    assert found.uniformity == pytest.approx(0.4)
    assert found.diversity == pytest.approx(0.25)


def test_even_light_is_even_to_the_last_bit():
    assert even_light(np.full(3, 349525.36393513705)).uniformity == 1.0


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=50), st.floats(1e-3, 1e3))
def test_ratios_have_bounds_and_no_unit(lux, factor):
    found, scaled = even_light(np.array(lux)), even_light(factor * np.array(lux))
    assert 0.0 <= found.diversity <= found.uniformity * (1 + 1e-9) <= 1.0 + 1e-9
    assert scaled.uniformity == pytest.approx(found.uniformity, rel=1e-6, abs=1e-12)


def test_darkness_is_not_even():
    assert (even_light(np.zeros(3)).uniformity, even_light(np.zeros(3)).diversity) == (0.0, 0.0)
