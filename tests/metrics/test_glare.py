"""Position index and UGR from their definitions."""

import numpy as np
import pytest

from hradiosity.metrics.glare import glare_sum, position_index, rating_half_width, unified_glare_rating

AHEAD, UP = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
STRAIGHT_ABOVE = (1.00, 1.26, 1.53, 1.90, 2.35, 2.86, 3.50, 4.20, 5.00, 6.00, 7.00, 8.10, 9.25, 10.35, 11.70, 13.15)
"""Table of CIE 117-1995 for sources straight above the line of sight, H/R = 0, 0.1, … 1.5."""


def index_at(ahead, aside, above):
    to = np.array([[ahead, aside, above]], float)
    return position_index(AHEAD, UP, to / np.linalg.norm(to))[0]


def test_the_formula_gives_the_table_of_the_cie():
    found = [index_at(1.0, 0.0, 0.1 * k) for k in range(len(STRAIGHT_ABOVE))]
    np.testing.assert_allclose(found, STRAIGHT_ABOVE, rtol=0.03)


def test_index_grows_away_from_the_line_of_sight_and_is_even():
    assert index_at(1, 0, 0) == pytest.approx(1)
    assert index_at(1, 0.4, 0.3) == pytest.approx(index_at(1, -0.4, 0.3))
    away = [index_at(1, t, t) for t in np.linspace(0, 3, 20)]
    assert (np.diff(away) > 0).all()
    assert index_at(1, 0.5, 0) < index_at(1, 0, 0.5)


def test_index_is_undefined_below_and_behind():
    assert np.isnan([index_at(1, 0, -0.1), index_at(-1, 0, 1)]).all()


def test_rating_by_hand():
    """Two luminaires of 2000 cd m⁻² and 0.01 sr at p = 2 and 4, background 20 cd m⁻²."""
    total = glare_sum(np.full(2, 2000.0), np.full(2, 0.01), np.array([2.0, 4.0])).sum()
    assert total == pytest.approx(4e4 / 4 + 4e4 / 16)
    found = unified_glare_rating(np.array([total]), np.array([20.0]))[0]
    assert found == pytest.approx(8 * np.log10(0.25 * 12500 / 20))
    assert found == pytest.approx(17.55, abs=0.01)
    half = rating_half_width(np.array([20.0 * np.pi]), np.array([0.2 * np.pi]))[0]
    wider = unified_glare_rating(np.array([total]), np.array([20.2]))[0]
    assert half == pytest.approx(found - wider, rel=0.01)


def test_there_is_no_rating_without_sources_or_background():
    assert np.isnan(unified_glare_rating(np.array([0.0, 5.0]), np.array([1.0, 0.0]))).all()
