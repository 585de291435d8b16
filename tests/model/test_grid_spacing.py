"""Grids of EN 12464-1."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.model.grid_spacing import grid_counts, grid_spacing


@pytest.mark.parametrize(
    ("edge", "spacing", "points"),
    [(1.0, 0.2, 5), (2.0, 0.32, 6), (5.0, 0.62, 8), (10.0, 1.0, 10), (50.0, 3.1, 16), (100.0, 5.0, 20)],
)
def test_examples_of_the_standard(edge, spacing, points):
    """Its table gives 0.20, 0.35, 0.60, 1.00, 3.00 and 5.00 m, rounded."""
    assert grid_spacing(edge, edge) == pytest.approx(spacing, rel=0.02)
    assert grid_counts(edge, edge) == (points, points)


def test_a_long_area_has_the_spacing_of_its_width():
    assert grid_spacing(30.0, 2.0) == grid_spacing(2.0, 2.0)
    assert grid_spacing(3.0, 2.0) == grid_spacing(3.0, 3.0)
    assert grid_spacing(1e6, 1e6) == 10.0
    with pytest.raises(ValueError, match="positive"):
        grid_spacing(1.0, 0.0)


@given(st.floats(0.3, 300.0), st.floats(0.3, 300.0))
def test_cells_are_about_square_and_turn_with_the_area(length, width):
    along, across = grid_counts(length, width)
    assert grid_counts(width, length) == (across, along)
    ratio = (length / along) / (width / across)
    assert 0.5 <= ratio <= 2.0
    assert max(length / along, width / across) < 2.0 * grid_spacing(length, width) + 1e-9
    assert np.prod((along, across)) >= 1
