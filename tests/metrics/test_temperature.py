"""Colour temperatures: published values, black bodies, and lights that have none."""

import numpy as np
import pytest
from lights import EXPECTED, FINE, TOLERANCE, USUAL, power_of, random_mixtures

from hradiosity.metrics import colorimetric
from hradiosity.metrics.planck import COLDEST, HOTTEST, locus, nearest_on_locus, relative_radiance
from hradiosity.metrics.temperature import FARTHEST, REASONS, colour_temperature
from hradiosity.model import photometry
from hradiosity.model.spectrum import Spectrum, band_integral


def beside_the_locus(temperature, duv):
    """(n, 2) u, v at distances from black bodies, and by the observer's own sums; normals by differences."""
    wavelength, functions = photometry.observer("1931")

    def uv(kelvin):
        return colorimetric.chromaticity_1960(np.einsum("nw,wc->nc", relative_radiance(wavelength, kelvin), functions))

    along = uv(temperature * (1 - 1e-4)) - uv(temperature * (1 + 1e-4))
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    return uv(temperature) + duv[:, None] * normal


@pytest.mark.parametrize("bands", [FINE, USUAL], ids=["2 nm", "5 nm"])
@pytest.mark.parametrize("name", EXPECTED["illuminants"])
def test_temperatures_of_the_illuminants(name, bands):
    expected = EXPECTED["illuminants"][name]["colour_science"]
    found = colour_temperature(colorimetric.xyz(power_of(name, bands), bands))
    assert found.cct[0] == pytest.approx(expected["CCT"], abs=TOLERANCE["CCT_K"])
    assert found.duv[0] == pytest.approx(expected["Duv"], abs=TOLERANCE["Duv_abs"])
    assert REASONS[found.reason[0]] == ""


@pytest.mark.parametrize("name", ["Planck2000", "Planck2700", "Planck2856", "Planck6500", "E"])
def test_temperatures_of_analytic_spectra(name):
    expected = EXPECTED["analytic_spectra"][name]
    found = colour_temperature(colorimetric.xyz(power_of(name, FINE), FINE))
    assert found.cct[0] == pytest.approx(expected["CCT"], abs=0.2)
    assert found.duv[0] == pytest.approx(expected["Duv"], abs=2e-6)


@pytest.mark.parametrize(
    ("name", "reason"),
    [("gauss_450_20", "not between"), ("gauss_555_25", "more than"), ("gauss_630_15", "not between")],
)
def test_colours_without_a_temperature_say_why(name, reason):
    _, centre, width = name.split("_")
    wavelength = np.arange(360, 830.01, 0.1)
    bell = Spectrum(wavelength, np.exp(-(((wavelength - float(centre)) / float(width)) ** 2) / 2))
    found = colour_temperature(colorimetric.xyz(band_integral(bell, FINE, "hold").value[None], FINE))
    assert np.isnan(found.cct[0])
    if name == "gauss_555_25":
        assert REASONS[found.reason[0]].startswith(reason)
        assert found.duv[0] == pytest.approx(EXPECTED["analytic_spectra"][name]["Duv"], abs=TOLERANCE["Duv_abs"])
    else:  # the nearest black body is hotter or colder than any that counts
        assert REASONS[found.reason[0]] == f"not between {COLDEST:g} and {HOTTEST:g} K"
        assert np.isnan(found.duv[0])


def test_the_nearest_black_body_is_found_from_either_side():
    rng = np.random.default_rng(5)
    mired = rng.uniform(11, 990, 2000)
    duv = rng.uniform(-FARTHEST, FARTHEST, 2000)
    temperature, distance = nearest_on_locus(beside_the_locus(1e6 / mired, duv))
    np.testing.assert_allclose(temperature, 1e6 / mired, rtol=1e-6)  # of cubics, and of the normals here
    np.testing.assert_allclose(distance, duv, atol=1e-9)


def test_no_point_of_the_locus_is_nearer():
    """For colours anywhere, also where there are two near places."""
    uv = np.random.default_rng(6).uniform((0.1, 0.2), (0.5, 0.4), (3000, 2))
    _, distance = nearest_on_locus(uv)
    knots = locus().uv
    nearest_knot = np.sqrt(((uv[:, None] - knots) ** 2).sum(axis=2)).min(axis=1)
    assert (np.abs(distance) <= nearest_knot + 1e-12).all()
    assert (np.abs(distance) >= nearest_knot - np.linalg.norm(np.diff(knots, axis=0), axis=1).max()).all()


def test_darkness_and_the_ends_have_no_temperature():
    uv = beside_the_locus(np.array([1001.0, 999.0, 99_000.0, 2e5]), np.zeros(4))
    y = np.full(4, 2.0)
    x = 1.5 * y * uv[:, 0] / uv[:, 1]
    tristimulus = np.stack([x, y, (4 * x / uv[:, 0] - x - 15 * y) / 3], axis=1)
    found = colour_temperature(np.concatenate([tristimulus, np.zeros((1, 3))]))
    assert found.reason.tolist() == [0, 3, 0, 3, 1]
    np.testing.assert_allclose(found.cct[[0, 2]], [1001, 99_000], rtol=1e-6)
    assert np.isnan(found.cct[[1, 3, 4]]).all() and np.isnan(found.duv[[1, 3, 4]]).all()
    assert len(colour_temperature(np.zeros((0, 3))).cct) == 0


def test_uniform_chromaticities_belong_to_x_and_y():
    rng = np.random.default_rng(7)
    tristimulus = rng.random((4, 5, 3))
    x, y = np.moveaxis(colorimetric.chromaticity(tristimulus), -1, 0)
    expected = np.stack([4 * x, 9 * y], axis=-1) / (-2 * x + 12 * y + 3)[..., None]
    np.testing.assert_allclose(colorimetric.uniform_chromaticity(tristimulus), expected, rtol=1e-12)
    np.testing.assert_allclose(colorimetric.chromaticity_1960(tristimulus)[..., 1] * 1.5, expected[..., 1], rtol=1e-12)
    assert np.isnan(colorimetric.uniform_chromaticity(np.zeros(3))).all()


@pytest.mark.slow
def test_colour_science_agrees_on_temperatures():
    import colour

    tristimulus = colorimetric.xyz(random_mixtures(100), USUAL)
    found = colour_temperature(tristimulus)
    theirs = colour.temperature.uv_to_CCT_Ohno2013(colorimetric.chromaticity_1960(tristimulus))
    known = found.reason == 0
    assert known.sum() > 90
    np.testing.assert_allclose(found.cct[known], theirs[known, 0], rtol=3e-4)  # its c₂ is rounded, its steps are coarse
    np.testing.assert_allclose(found.duv[known], theirs[known, 1], atol=2e-6)
