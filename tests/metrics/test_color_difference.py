"""CIEDE2000 against colour-science, and where its value is known."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.metrics.color_difference import delta_e_2000, lab
from hradiosity.metrics.colorimetric import linear_srgb_to_xyz, xyz_to_linear_srgb

WHITE = np.array([0.95047, 1.0, 1.08883])


def test_as_colour_science_has_it():
    import colour

    random = np.random.default_rng(0)
    first = np.column_stack([random.uniform(0, 100, 20000), random.uniform(-120, 120, (20000, 2))])
    second = first + random.normal(0, 1, first.shape) * 10 ** random.uniform(-2, 2, (20000, 1))
    expected = colour.difference.delta_E_CIE2000(first, second)
    np.testing.assert_allclose(delta_e_2000(first, second), expected, rtol=1e-9, atol=1e-9)


def test_lab_as_colour_science_has_it():
    import colour

    xyz = np.random.default_rng(0).uniform(0, 1.2, (1000, 3)) ** 3
    x, y = WHITE[0] / WHITE.sum(), WHITE[1] / WHITE.sum()
    np.testing.assert_allclose(lab(xyz, WHITE), colour.XYZ_to_Lab(xyz, np.array([x, y])), rtol=1e-6, atol=1e-6)


def test_grey_colours_differ_in_lightness_alone():
    grey = np.array([[50.0, 0.0, 0.0], [50.0, 0.0, 0.0]])
    other = np.array([[50.0, 0.0, 0.0], [52.0, 0.0, 0.0]])
    assert delta_e_2000(grey, other)[0] == 0.0
    np.testing.assert_allclose(delta_e_2000(grey, other)[1], 2.0 / (1 + 0.015 * 1.0 / np.sqrt(21.0)))


colours = st.tuples(st.floats(0, 100), st.floats(-128, 128), st.floats(-128, 128)).map(np.array)


@given(colours, colours)
def test_both_ways_alike_and_never_below_zero(first, second):
    there, back = float(delta_e_2000(first, second)), float(delta_e_2000(second, first))
    assert there >= 0.0 and abs(there - back) <= 1e-6 * (1 + there)
    assert float(delta_e_2000(first, first)) == 0.0


def test_linear_srgb_there_and_back():
    xyz = np.random.default_rng(0).uniform(0, 1, (100, 3))
    np.testing.assert_allclose(linear_srgb_to_xyz(xyz_to_linear_srgb(xyz, 1.0)), xyz, rtol=1e-12)
