"""Colour scale, ticks and exposure."""

import numpy as np
import pytest

from hradiosity.metrics.colorimetric import xyz_to_linear_srgb
from hradiosity.show.colormap import colours_of, lab_to_xyz, scale_colours
from hradiosity.show.exposure import white_luminance
from hradiosity.show.scale_bar import Scale, automatic_scale, false_colours, round_down, round_up

RGB_TO_XYZ = np.linalg.inv(np.stack([xyz_to_linear_srgb(np.eye(3)[i], 1.0) for i in range(3)], axis=1))


def lab_of(srgb):
    """CIE L*a*b* of sRGB values."""
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    white = lab_to_xyz(np.array([100.0, 0.0, 0.0]))
    ratio = linear @ RGB_TO_XYZ.T / white
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / 3 / (6 / 29) ** 2 + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def test_steps_of_the_scale_look_equal():
    lab = lab_of(scale_colours())
    step = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    np.testing.assert_allclose(step, step.mean(), rtol=0.02)


def test_scale_rises_in_lightness_so_that_hue_is_not_needed():
    assert (np.diff(lab_of(scale_colours())[:, 0]) > 0.05).all()


def test_lab_of_the_white_is_the_white():
    np.testing.assert_allclose(xyz_to_linear_srgb(lab_to_xyz(np.array([100.0, 0, 0])), 1.0), 1.0, atol=1e-12)


@pytest.mark.parametrize(
    ("scale", "ticks"),
    [
        (Scale(0, 1000, False, "illuminance", "lx"), [0, 200, 400, 600, 800, 1000]),
        (Scale(1, 1000, True, "illuminance", "lx"), [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]),
        (Scale(30, 70, False, "luminance", "cd/m²"), [30, 35, 40, 45, 50, 55, 60, 65, 70]),
    ],
)
def test_ticks_are_round_and_inside(scale, ticks):
    np.testing.assert_allclose(scale.ticks(), ticks)


def test_places_on_a_scale():
    linear, logs = Scale(0, 50, False, "q", "u"), Scale(1, 100, True, "q", "u")
    np.testing.assert_allclose(linear.share(np.array([0, 25, 100])), [0, 0.5, 2])
    np.testing.assert_allclose(logs.share(np.array([0.0, 1.0, 10.0, 100.0])), [0, 0, 0.5, 1])


def test_automatic_scale_ends_at_a_round_number():
    values = np.append(np.linspace(0, 430, 1000), 1e6)
    assert automatic_scale(values, logarithmic=False, quantity="q", unit="u").high == 500
    assert automatic_scale(0.5 * values, logarithmic=False, quantity="q", unit="u").high == 250
    assert automatic_scale(np.zeros(0), logarithmic=False, quantity="q", unit="u").high == 1


@pytest.mark.parametrize(
    ("values", "ends"),
    [
        (np.geomspace(1.0, 100.0, 1000), (1.0, 100.0)),  # the darkest and the brightest hundredth: 1.05 and 95.5
        (np.geomspace(1e-6, 450.0, 1000), (0.4, 400.0)),  # too far for three decades
        (np.linspace(400.0, 430.0, 100), (50.0, 500.0)),  # hardly any contrast: a decade in any case
        (np.zeros(10), (0.001, 1.0)),
    ],
)
def test_a_logarithmic_scale_holds_dark_and_bright_places(values, ends):
    scale = automatic_scale(values, logarithmic=True, quantity="q", unit="u")
    assert (scale.low, scale.high) == pytest.approx(ends)


@pytest.mark.parametrize(("value", "down"), [(1.0, 1.0), (0.99, 0.8), (430, 400), (0.061, 0.06), (9.9, 8.0)])
def test_round_down(value, down):
    assert round_down(value) == pytest.approx(down, rel=1e-12)


@pytest.mark.parametrize(("value", "up"), [(1.0, 1.0), (1.01, 2.0), (430, 500), (0.06, 0.1), (2e-7, 2e-7), (9, 10)])
def test_round_up(value, up):
    assert round_up(value) == pytest.approx(up, rel=1e-12)


def test_nothing_seen_is_grey():
    scale = Scale(0, 1, False, "q", "u")
    out = false_colours(np.array([[1.0, 0.5]]), np.array([[True, False]]), scale)
    assert (out[0, 0] == np.rint(255 * colours_of(np.array(1.0)))).all() and len(set(out[0, 1])) == 1


def test_one_in_a_hundred_is_brighter_than_white():
    grey = lab_to_xyz(np.array([100.0, 0, 0])).astype(np.float32)
    samples = np.linspace(0, 200, 2001, dtype=np.float32)[:, None] * grey
    assert white_luminance([samples[:1000], samples[1000:]]) == pytest.approx(198, rel=1e-3)
    assert white_luminance([]) == 1 and white_luminance([0 * samples]) == 1
