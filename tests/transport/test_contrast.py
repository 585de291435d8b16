"""How much the light of a surface differs between directions."""

import numpy as np
import pytest

from hradiosity.space.hierarchy import COVERED, MISS
from hradiosity.transport.contrast import side_contrast
from hradiosity.transport.exchange import RowHits


def contrast(row, side, leaving, arriving, area=None):
    row = np.array(row, np.uint32)
    area = np.ones(len(row)) if area is None else np.asarray(area, float)
    hits = RowHits(row, np.zeros_like(row), None)
    return side_contrast(hits, np.asarray(side), area, np.asarray(leaving, float), np.asarray(arriving, float))


def test_even_surroundings_have_none():
    np.testing.assert_allclose(contrast([[1, 2], [2, 0], [0, 1]], [0, 2, 4], [3, 3, 3], [3, 3, 3]), 0.0)


def test_one_bright_spot_among_many_rays():
    """Of four rays one meets a spot as bright as 4: mean 1, variance 3, over the light received squared."""
    row = [[1, 0, 0, 0], [0, 0, 0, 0]]
    np.testing.assert_allclose(contrast(row, [0, 2], [0, 4], [1.0, 2.0]), [3.0, 0.0])
    assert contrast(row, [0, 2], [0, 4], [2.0, 2.0])[0] == pytest.approx(0.75)


def test_rows_of_a_side_share_their_contrast():
    """The second row's rays missed the spot by chance; it counts as its neighbour does."""
    found = contrast([[2, 0], [0, 0], [0, 0]], [0, 0, 2], [0, 0, 4], [1, 1, 1])
    assert found[0] == found[1] == pytest.approx(3.0)
    weighted = contrast([[2, 0], [0, 0], [0, 0]], [0, 0, 2], [0, 0, 4], [1, 1, 1], area=[3, 1, 1])
    assert weighted[0] == pytest.approx((0.75 * 8 - 1.5**2) / 1.0)


def test_covered_rays_do_not_count_and_lost_ones_are_dark():
    assert contrast([[1, COVERED], [0, 0]], [0, 2], [0, 4], [4, 1])[0] == 0.0
    assert contrast([[1, MISS], [0, 0]], [0, 2], [0, 4], [2, 1])[0] == pytest.approx(1.0)


def test_a_dark_side_has_none():
    assert contrast([[1, 1], [0, 0]], [0, 2], [0, 0], [0, 0]).tolist() == [0.0, 0.0]
