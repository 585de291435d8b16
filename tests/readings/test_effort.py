"""How readings share rays: within the price asked for, most where most is gained."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rooms import SceneBuilder

from hradiosity.device import Device
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver
from hradiosity.readings import effort
from hradiosity.readings.effort import LEAST, LEAST_LIGHT, MOST, SHADOW_RAY, Split

spreads = st.lists(st.floats(0.0, 10.0), min_size=1, max_size=40)


@given(spreads, st.integers(0, 2**32 - 1), st.sampled_from([1, 6, 40]))
def test_the_rays_cost_no_more_than_an_even_share_of_them(gather: list[float], seed: int, lamps: int) -> None:
    """Whatever the spreads are, unless the least that each reading gets costs more already."""
    path_spread = np.array(gather)
    penumbra = np.random.default_rng(seed).exponential(1.0, (len(gather), lamps))
    light, paths = Split(256, 128).shared(penumbra, path_spread)
    assert paths.sum() + SHADOW_RAY * light.sum() <= (256 + SHADOW_RAY * 128 * lamps) * len(gather) * 1.0001
    assert (paths >= LEAST * 256).all() and (paths <= MOST * 256).all()
    assert (light >= LEAST_LIGHT * 128).all() and (light <= MOST * 128).all()


@pytest.mark.parametrize("noisy", ["penumbra", "gather"])
def test_rays_go_where_the_spread_is(noisy: str) -> None:
    """Shadow rays to readings in penumbrae, paths where reflected light is uneven, and more of them to the worst."""
    rising, faint = np.geomspace(0.01, 1.0, 16), np.full(16, 1e-3)
    spread = (rising[:, None], faint) if noisy == "penumbra" else (faint[:, None], rising)
    light, paths = Split(256, 256).shared(*spread)
    more, fewer = (light[:, 0], paths) if noisy == "penumbra" else (paths, light[:, 0])
    assert (np.diff(more) >= 0).all() and more[-1] >= 8 * more[0]
    assert (fewer == (LEAST if noisy == "penumbra" else LEAST_LIGHT) * 256).all()


def test_of_many_lamps_those_in_doubt_get_the_rays() -> None:
    """One partly hidden lamp among forty that are far or open."""
    penumbra = np.full((5, 40), 1e-4)
    penumbra[:, 7] = 0.3
    light, _ = Split(64, 4).shared(penumbra, np.full(5, 0.3))
    assert (light[:, 7] == MOST * 4).all()
    assert (np.delete(light, 7, axis=1) == LEAST_LIGHT * 4).all()


def test_split_beats_even_shares_by_its_own_measure() -> None:
    """Σ σ²/n of both kinds is smaller than with even numbers at the same price."""
    draw = np.random.default_rng(7)
    penumbra, gather = draw.exponential(0.3, (200, 3)), draw.exponential(1.0, 200)
    light, paths = Split(256, 128).shared(penumbra, gather)
    chosen = (penumbra**2 / light).sum() + (gather**2 / paths).sum()
    even = (penumbra**2 / 128).sum() + (gather**2 / 256).sum()
    assert chosen < 0.8 * even


def test_without_lamps_all_rays_are_paths() -> None:
    light, paths = Split(256, 128).shared(np.zeros((3, 0)), np.array([0.0, 1.0, 2.0]))
    assert light.shape == (3, 0) and paths[2] > paths[0]


def test_hidden_lamps_take_few_rays(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """Behind a wall with a slit a lamp would outshine the readings; the pilot makes sure that it is hidden."""
    b = SceneBuilder(1)
    grey = b.material(0.4)
    b.box((0, 0, 0), (4, 2, 2), grey, inward=True)
    b.box((1.9, 0, 0), (2.1, 1.9, 2), grey)
    b.lamp(b.patch((0.8, 0.8, 1.9), (0, 0.4, 0), (0.4, 0, 0), grey), 100.0)
    b.sensor([(3.0, 0.3, 0.5), (3.5, 0.2, 0.5), (3.0, 0.5, 0.2), (0.5, 1.0, 0.5)], np.tile((0.0, 0.0, 1.0), (4, 1)))
    rays = []
    for times in (0, effort.UNSEEN_AGAIN):
        monkeypatch.setattr(effort, "UNSEEN_AGAIN", times)
        solver = RadiositySolver(b.scene(), Options(elements=500, replicates=2, gather_samples=512), device)
        next(state for state in solver.states() if state.stage == "replicate")
        kept = solver.checkpoint()
        rays.append((kept["readings/effort/light"].sum(axis=1), kept["readings/effort/gather"]))
    assert rays[1][0][:3].sum() < 0.7 * rays[0][0][:3].sum()
    assert rays[1][1].sum() > rays[0][1].sum()
