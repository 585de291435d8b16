"""Device functions and tables of images against numpy."""

import itertools

import numpy as np
import pytest
from device_call import device_call

from hradiosity.show.image_guide import EVEN_SHARE, LEVELS, SIDE, guide_tables
from hradiosity.show.image_lamps import CLEAR_LAMPS, clear_lamps, seen_shares, summed_chances
from hradiosity.space.hierarchy import NONE


@pytest.mark.parametrize("seed", [0, 123456])
def test_pixels_lie_along_a_shuffled_z_curve(device, seed):
    """Each square of the quadtree has a range of numbers of its own, and the order differs between seeds."""
    y, x = (part.ravel().astype(np.uint32) for part in np.mgrid[:32, :32])
    order = device_call(device, "hr_image.h", f"hr_pixel_order(x, y, 5u, {seed}u)", "uint", x=x, y=y)
    assert set(order.tolist()) == set(range(1024))
    for level in range(1, 5):
        size = 2**level
        square = (x // size) + 100 * (y // size)
        for number in np.unique(square):
            inside = order[square == number]
            assert np.ptp(inside) == size * size - 1 and inside.min() % (size * size) == 0
    other = device_call(device, "hr_image.h", f"hr_pixel_order(x, y, 5u, {seed + 1}u)", "uint", x=x, y=y)
    assert (order != other).mean() > 0.5


def test_the_drawn_entry_is_the_first_above(device):
    sums = np.array([0.1, 0.1, 0.4, 0.9, 1.0], np.float32)
    numbers = np.linspace(0, 0.999, 5).astype(np.float32)
    found = device_call(device, "hr_sampling.h", "hr_draw(in_sums, 5u, x)", "uint", sums=sums, x=numbers)
    np.testing.assert_array_equal(found, np.searchsorted(sums, numbers, side="right"))


def test_guides_add_up(device):
    """Every level sums to 1, each part of a coarse one to its four finer ones, and none is below the even share."""
    brightness = np.random.default_rng(0).exponential(size=(3, SIDE * SIDE)) ** 3
    brightness[2] = 0.0
    tables = guide_tables(brightness).astype(float)
    starts = np.cumsum([0, *(4**level for level in range(1, LEVELS + 1))])
    levels = [tables[:, a:b].reshape(3, 2**k, 2**k) for k, (a, b) in enumerate(itertools.pairwise(starts), 1)]
    for coarse, fine in itertools.pairwise(levels):
        n = coarse.shape[1]
        np.testing.assert_allclose(fine.reshape(3, n, 2, n, 2).sum(axis=(2, 4)), coarse, rtol=1e-5)
    np.testing.assert_allclose(levels[0].sum(axis=(1, 2)), 1.0, rtol=1e-6)
    assert levels[-1].min() >= EVEN_SHARE / SIDE**2 * (1 - 1e-6)
    np.testing.assert_allclose(levels[-1][2], 1 / SIDE**2, rtol=1e-6)


def test_lamps_mostly_seen_are_clear_and_the_brightest_are_listed():
    seen = np.tile([1.0, 0.4, 0.6] * 5, (2, 1))
    light = np.stack([np.arange(15.0), np.zeros(15)])
    is_clear, listed = clear_lamps(seen, light)
    candidates = [e for e in range(14, 0, -1) if e % 3 != 1]
    np.testing.assert_array_equal(listed[0], candidates[:CLEAR_LAMPS])
    assert (listed[1] == NONE).all() and not is_clear[1].any()
    assert set(np.flatnonzero(is_clear[0])) == set(candidates[:CLEAR_LAMPS])


def test_shadow_rays_go_where_there_is_doubt():
    seen, light = np.array([[1.0, 0.5, 0.0]]), np.array([[1.0, 1.0, 1.0]])
    chances = np.diff(summed_chances(seen, light)[0], prepend=0.0)
    assert chances[1] > 2 * chances[0] and chances[0] == pytest.approx(chances[2]) and chances.min() > 0.03
    assert summed_chances(seen, 0 * light)[0].tolist() == pytest.approx([1 / 3, 2 / 3, 1])
    assert summed_chances(np.zeros((2, 0)), np.zeros((2, 0))).shape == (2, 0)


def test_shares_of_what_could_arrive():
    direct, free = np.array([[0.1, 0.3, 0.0, -0.1]]), np.array([[0.2, 0.2, 0.0, 0.1]])
    np.testing.assert_allclose(seen_shares(direct, free), [[0.5, 1.0, 0.0, 0.0]])
