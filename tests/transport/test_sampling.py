"""Random numbers and directions: Sobol' points, Owen's scramble, the cosine law, the map onto the triangle."""

import numpy as np
import pytest
from device_call import device_call
from scipy.stats import kstest, qmc

HEADER = "hr_sampling.h"


def samples(device, n, dimension, seed):
    """(n,) coordinate `dimension` of the scrambled sequence, or (n, n_seeds) for a list of seeds."""
    seeds = np.atleast_1d(np.asarray(seed, np.uint32))
    index = np.repeat(np.arange(n, dtype=np.uint32), len(seeds))
    found = device_call(
        device,
        HEADER,
        "hr_sample(index, dimension, seed)",
        index=index,
        dimension=np.full(len(index), dimension, np.uint32),
        seed=np.tile(seeds, n),
    ).reshape(n, len(seeds))
    return found[:, 0] if np.ndim(seed) == 0 else found


@pytest.mark.parametrize("dimension", range(8))
def test_sobol_points_are_those_of_joe_and_kuo(device, dimension):
    """Another program lists them in Gray-code order: its point i is ours i ^ (i >> 1)."""
    n = 4096
    index = np.arange(n, dtype=np.uint32)
    point = "hr_reverse_bits(hr_sobol_reversed(index, dimension))"
    found = device_call(device, HEADER, point, "uint", index=index, dimension=np.full(n, dimension, np.uint32))
    expected = qmc.Sobol(8, scramble=False, bits=32).random(n)[:, dimension]
    np.testing.assert_array_equal(found[index ^ (index >> 1)] * 2.0**-32, expected)


def test_scramble_is_one_to_one_and_nested(device):
    """The first m bits of the result depend on the first m bits of the input only."""
    rng = np.random.default_rng(0)
    scramble = "hr_owen(hr_reverse_bits(bits), seed)"
    bits = rng.integers(0, 2**32, 20000, dtype=np.uint32)
    for seed in rng.integers(0, 2**32, 5, dtype=np.uint32):
        seeds = np.full(len(bits), seed)
        scrambled = device_call(device, HEADER, scramble, "uint", bits=bits, seed=seeds)
        assert len(np.unique(scrambled)) == len(np.unique(bits))
        for m in (1, 4, 11):
            low = np.uint32(32 - m)
            changed = bits ^ (rng.integers(0, 2**32, len(bits), dtype=np.uint32) >> np.uint32(m))
            other = device_call(device, HEADER, scramble, "uint", bits=changed, seed=seeds)
            np.testing.assert_array_equal(scrambled >> low, other >> low)


@pytest.mark.parametrize("seed", [0, 1, 77, 2**32 - 1])
@pytest.mark.parametrize("m", [4, 8])
def test_scrambled_points_are_a_net(device, seed, m):
    """Each elementary interval of area 2^-m holds exactly one of 2^m points, in dimensions 0 and 1."""
    x, y = (samples(device, 2**m, d, seed) for d in (0, 1))
    for a in range(m + 1):
        column, row = (x * 2**a).astype(int), (y * 2 ** (m - a)).astype(int)
        assert len(np.unique(column * 2 ** (m - a) + row)) == 2**m


@pytest.mark.parametrize("dimension", range(8))
def test_each_dimension_is_stratified_and_spread_evenly_over_seeds(device, dimension):
    found = samples(device, 64, dimension, np.arange(1, 401))
    assert (found >= 0).all() and (found < 1).all()
    np.testing.assert_array_equal(np.sort((found * 64).astype(int), axis=0), np.tile(np.arange(64)[:, None], 400))
    # Within its stratum, a point is anywhere with the same probability.
    assert kstest((found * 64 % 1).ravel(), "uniform").pvalue > 1e-4
    assert kstest(found[0], "uniform").pvalue > 1e-4


def test_estimates_are_unbiased_and_better_than_random(device):
    """Mean over 400 seeds within 4 standard errors; the spread falls faster than 1/√n."""
    spread = []
    for n in (16, 64, 256):
        x, y = (samples(device, n, d, np.arange(400)) for d in (0, 1))
        estimate = (np.exp(x) * np.cos(2 * y)).mean(axis=0)
        exact = (np.e - 1) * np.sin(2) / 2
        assert abs(estimate.mean() - exact) < 4 * estimate.std() / 20
        spread.append(estimate.std())
    assert np.log2(spread[0] / spread[2]) / 4 > 1.2


def test_dimensions_are_independent_of_each_other(device):
    """The product of two centred coordinates has mean 0 over seeds, for every pair."""
    all_of_them = np.stack([samples(device, 16, d, np.arange(500)) for d in range(8)]) - 0.5
    product = np.einsum("dns,ens->des", all_of_them, all_of_them) / 16
    error = product.std(axis=2) / np.sqrt(500)
    off_diagonal = ~np.eye(8, dtype=bool)
    assert (np.abs(product.mean(axis=2)) < 4.5 * error)[off_diagonal].all()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.36, -0.48, 0.8), (0.6, 0, -0.8)])
def test_directions_follow_the_cosine_law(device, normal):
    """cos²θ and the azimuth over 2π are uniform; E[d] = 2/3 n; unit length; never below the horizon."""
    rng = np.random.default_rng(3)
    n = 20000
    normals = np.tile(np.array(normal, np.float32), (n, 1))
    uv = rng.random((n, 2)).astype(np.float32)
    d = device_call(
        device, HEADER, "hr_cosine_direction(n, u, v)", "float3", n=normals, u=uv[:, 0].copy(), v=uv[:, 1].copy()
    ).astype(float)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, atol=1e-6)
    cosine = d @ np.array(normal)
    assert (cosine > 0).all()
    assert kstest(cosine**2, "uniform").pvalue > 1e-3
    np.testing.assert_allclose(d.mean(axis=0), 2 / 3 * np.array(normal), atol=4 * 0.5 / np.sqrt(n))
    tangent = np.cross(normal, [0.3, 0.9, -0.2])
    tangent /= np.linalg.norm(tangent)
    azimuth = np.arctan2(d @ np.cross(normal, tangent), d @ tangent)
    assert kstest(azimuth / (2 * np.pi) + 0.5, "uniform").pvalue > 1e-3


def test_directions_at_the_borders_of_the_square(device):
    """Corners, edges and the centre give unit vectors on or above the horizon, and no NaN."""
    grid = np.array([0.0, 2.0**-24, 0.25, 0.5, 0.75, 1 - 2.0**-24], np.float32)
    u, v = (g.ravel() for g in np.meshgrid(grid, grid))
    normals = np.tile(np.array([0, 0, 1], np.float32), (len(u), 1))
    d = device_call(device, HEADER, "hr_cosine_direction(n, u, v)", "float3", n=normals, u=u.copy(), v=v.copy())
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, atol=1e-6)
    assert (d[:, 2] > 0).all()


def test_square_is_spread_evenly_over_the_triangle(device):
    """Barycentric coordinates are in the triangle, and each of 64 equal parts gets its share of a fine grid."""
    n = 256
    grid = ((np.arange(n) + 0.5) / n).astype(np.float32)
    s, t = (g.ravel() for g in np.meshgrid(grid, grid))
    uv = device_call(device, "hr_patches.h", "hr_square_to_triangle(s, t)", "float2", s=s.copy(), t=t.copy())
    u, v = uv.T.astype(float)
    assert (u >= 0).all() and (v >= 0).all() and (u + v <= 1).all()
    assert u.mean() == pytest.approx(1 / 3, abs=1e-4) and v.mean() == pytest.approx(1 / 3, abs=1e-4)
    iu, iv = (8 * u).astype(int), (8 * v).astype(int)
    part = 2 * (8 * iv + iu) + ((8 * u - iu) + (8 * v - iv) > 1)
    counts = np.unique(part, return_counts=True)[1]
    assert len(counts) == 64
    np.testing.assert_allclose(counts, n * n / 64, rtol=0.05)
