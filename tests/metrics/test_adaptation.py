"""Chromatic adaptation against another program, and what it must do by definition."""

import numpy as np
import pytest

from hradiosity.metrics.adaptation import adaptation_matrix

A = np.array([1.09850, 1.0, 0.35585])
D65 = np.array([0.95047, 1.0, 1.08883])


def test_white_becomes_white():
    matrix = adaptation_matrix(250.0 * A, 3.0 * D65)
    np.testing.assert_allclose(matrix @ A, D65, rtol=1e-12)
    np.testing.assert_allclose(adaptation_matrix(D65, D65), np.eye(3), atol=1e-14)


def test_there_and_back():
    np.testing.assert_allclose(adaptation_matrix(A, D65) @ adaptation_matrix(D65, A), np.eye(3), atol=1e-12)


def test_against_colour_science():
    from colour.adaptation import chromatic_adaptation_VonKries

    colours = np.random.default_rng(1).uniform(0.05, 0.9, (20, 3))
    expected = chromatic_adaptation_VonKries(colours, A, D65, transform="CAT16")
    np.testing.assert_allclose(colours @ adaptation_matrix(A, D65).T, expected, rtol=1e-6)


@pytest.mark.parametrize("light", [np.zeros(3), np.array([1.0, 0.1, 0.0])])
def test_what_is_no_white_is_refused(light):
    """Darkness, and deep red: a response to it is negative."""
    with pytest.raises(ValueError):
        adaptation_matrix(light, D65)
