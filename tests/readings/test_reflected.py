"""Reflected light at many points by shared paths: the light of readings, with noise as it is."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity import Options
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sensor
from hradiosity.radiosity import make_solver
from hradiosity.readings.reflected import shared_spread
from hradiosity.transport.direct import direct_at_points

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def solved(device):
    """A room with a block in it, a lamp below the ceiling, and points on the floor."""
    b = SceneBuilder()
    b.box((0, 0, 0), (2, 2, 2), b.material(0.6), inward=True)
    b.box((0.8, 0.7, 0), (1.3, 1.2, 0.7), b.material(0.4), solid=True)
    b.lamp(b.patch((0.8, 0.8, 1.9), (0, 0.4, 0), (0.4, 0, 0), b.material(0.5)), 100.0)
    solver = make_solver(b.scene(), Options(elements=600, gather_samples=2048, light_samples=1024), device)
    list(solver.states())
    place = (np.arange(60) * [[0.755], [0.57]] % 1.0).T
    place = place[(np.abs(place * 2 - [1.05, 0.95]) > 0.3).any(axis=1)]
    position = np.column_stack([2 * place, np.full(len(place), 1e-6)])
    return solver, position, np.broadcast_to(UP, position.shape)


def test_with_direct_light_it_is_what_readings_are(solved):
    solver, position, normal = solved
    read = solver.read(Sensor("read", position, normal)).numbers["illuminance"]
    found = solver.read_reflected(position, normal, 4096, 1)
    solution = solver.solution()
    lumens = luminous_weights(solution.scene.bands) @ solution.scene.luminaires[0].emission
    factor = direct_at_points(solver.on_device, position, normal, 4096, 5).astype(float)[:, 0]
    apart = np.abs(found.lux + factor * lumens - read.value)
    assert np.sqrt((apart**2).mean()) < 0.02 * read.value.mean()
    assert (apart <= np.hypot(found.half_width, read.half_width) + 0.01 * read.value.mean()).mean() > 0.9


@pytest.mark.parametrize("n_paths", [64, 1024])
def test_noise_is_the_spread_over_seeds(solved, n_paths):
    solver, position, normal = solved
    found = [solver.read_reflected(position, normal, n_paths, seed) for seed in range(8)]
    actual = np.sqrt(np.var([f.lux for f in found], axis=0, ddof=1).mean())
    stated = np.sqrt(np.mean([f.noise**2 for f in found]))
    assert stated == pytest.approx(actual, rel=0.25)


def test_an_evenly_spread_set_is_better_than_its_paths_by_chance(solved):
    """Sixteen times the paths leave a quarter of the noise by chance; sets that are spread evenly less."""
    solver, position, normal = solved
    few, many = (solver.read_reflected(position, normal, n, 3).noise.mean() for n in (64, 1024))
    assert many < 0.22 * few


def test_the_factor_of_a_spread_is_shared_by_all():
    rng = np.random.default_rng(0)
    likely = rng.uniform(0.1, 4.0, 5000)
    estimates = rng.standard_normal((2, 5000)) * np.sqrt(2 * likely) * 0.3
    np.testing.assert_allclose(shared_spread(estimates, likely), 0.3 * np.sqrt(likely), rtol=0.06)
    assert not shared_spread(np.ones((2, 3)), np.zeros(3)).any()


def test_before_two_replicates_there_is_nothing_to_read(device):
    solver = make_solver(_empty(), Options(), device)
    with pytest.raises(RuntimeError, match="two replicates"):
        solver.read_reflected(np.zeros((1, 3)), UP[None], 64, 0)


def _empty():
    b = SceneBuilder()
    room = b.box((0, 0, 0), (1, 1, 1), b.material(0.5), inward=True)
    b.lamp(room[5], 1.0)
    return b.scene()
