"""How readings share rays: within the price asked for, most where most is gained."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.readings.effort import LEAST, MOST, Split

spreads = st.lists(st.floats(0.0, 10.0), min_size=1, max_size=40)


@given(spreads, st.integers(0, 2**32 - 1), st.sampled_from([0.2, 1.2, 8.0]))
def test_the_rays_cost_no_more_than_an_even_share_of_them(gather: list[float], seed: int, price: float) -> None:
    """Whatever the spreads are, unless the least that each reading gets costs more already."""
    path_spread = np.array(gather)
    penumbra = np.random.default_rng(seed).exponential(1.0, len(gather))
    light, paths = Split(256, 128, price).shared(penumbra, path_spread)
    assert paths.sum() + price * light.sum() <= len(gather) * (256 + price * 128) * 1.0001
    assert (paths >= LEAST * 256).all() and (paths <= MOST * 256).all()
    assert (light >= LEAST * 128).all() and (light <= MOST * 128).all()


@pytest.mark.parametrize("noisy", ["penumbra", "gather"])
def test_rays_go_where_the_spread_is(noisy: str) -> None:
    """Shadow rays to readings in penumbrae, paths where reflected light is uneven, and more of them to the worst."""
    rising = np.geomspace(0.01, 1.0, 16)
    faint = np.full(16, 1e-3)
    light, paths = Split(256, 256, 0.2).shared(*((rising, faint) if noisy == "penumbra" else (faint, rising)))
    more, fewer = (light, paths) if noisy == "penumbra" else (paths, light)
    assert (np.diff(more) >= 0).all() and more[-1] >= 8 * more[0]
    assert (fewer == LEAST * 256).all()


def test_split_beats_even_shares_by_its_own_measure() -> None:
    """Σ σ²/n of both kinds is smaller than with even numbers at the same price."""
    draw = np.random.default_rng(7)
    penumbra, gather = draw.exponential(0.3, 200), draw.exponential(1.0, 200)
    light, paths = Split(256, 128, 1.2).shared(penumbra, gather)
    chosen = (penumbra**2 / light + gather**2 / paths).sum()
    even = (penumbra**2 / 128 + gather**2 / 256).sum()
    assert chosen < 0.8 * even


def test_without_lamps_nothing_is_divided_by_zero() -> None:
    """The price of shadow rays is then 0."""
    light, paths = Split(256, 128, 0.0).shared(np.zeros(3), np.array([0.0, 1.0, 2.0]))
    assert np.isfinite(light).all() and paths[2] > paths[0]
