import numpy as np
import pytest

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.metrics import colorimetric, photometric
from hradiosity.metrics.upsampling import upsample_rgb
from hradiosity.metrics.weights import band_weights
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Spectrum, band_integral
from hradiosity.suites.validation.data import colour_values

EXPECTED = colour_values()
TOLERANCE = EXPECTED["tolerances"]
FINE, USUAL = Bands.uniform(361, 829, 2), Bands.uniform()


def bell(centre, width):
    wavelength = np.arange(360, 830.01, 0.1)
    return Spectrum(wavelength, np.exp(-(((wavelength - centre) / width) ** 2) / 2))


def analytic(name):
    if name.startswith("Planck"):
        return photometry.blackbody(float(name.removeprefix("Planck")))
    if name == "E":
        return photometry.illuminant("E")
    _, centre, width = name.split("_")
    return bell(float(centre), float(width))


@pytest.mark.parametrize("name", EXPECTED["illuminants"])
def test_colour_of_the_illuminants(name):
    expected = EXPECTED["illuminants"][name]["colour_science"]
    for observer, label in (("1931", "2deg"), ("1964", "10deg")):
        # the tables of CIE 15 end at 780 nm; sums at 5 nm and integrals of daylight differ by 1.3e-4 by themselves
        slack = 1.3e-4 if name.startswith("D") else 0.0
        outside = "hold" if name == "E" else "zero"
        found = colorimetric.xyz(band_integral(photometry.illuminant(name), FINE, outside).value, FINE, observer)
        found *= 100 / found[1]
        largest = max(expected[f"XYZ_{label}"])
        atol = (TOLERANCE["XYZ_rel"] + slack) * largest
        np.testing.assert_allclose(found, expected[f"XYZ_{label}"], rtol=0, atol=atol)
        for bands in (FINE, USUAL):
            power = band_integral(photometry.illuminant(name), bands, "hold").value
            xy = colorimetric.chromaticity(colorimetric.xyz(power, bands, observer))
            np.testing.assert_allclose(xy, expected[f"xy_{label}"], rtol=0, atol=TOLERANCE["xy_abs"])


@pytest.mark.parametrize("name", EXPECTED["analytic_spectra"])
@pytest.mark.parametrize("bands", [FINE, USUAL], ids=["2 nm", "5 nm"])
def test_colour_and_efficacy_of_analytic_spectra(name, bands):
    expected, spectrum = EXPECTED["analytic_spectra"][name], analytic(name)
    power = band_integral(spectrum, bands, "hold").value
    found = colorimetric.xyz(power, bands)
    np.testing.assert_allclose(
        100 * found / found[1], expected["XYZ_rel"], rtol=0, atol=2 * TOLERANCE["XYZ_rel"] * max(expected["XYZ_rel"])
    )
    np.testing.assert_allclose(colorimetric.chromaticity(found), expected["xy"], rtol=0, atol=TOLERANCE["xy_abs"])
    total = band_integral(spectrum, Bands.explicit([359.5, 830.5]), "hold").value.sum()
    lux = photometric.illuminance(power, bands)
    assert lux / total == pytest.approx(expected["K_lm_per_W"], rel=TOLERANCE["XYZ_rel"])
    assert lux == pytest.approx(found[1], rel=5e-5)


def test_uniform_light_is_weighted_by_the_mean_of_v():
    weights = photometric.luminous_weights(USUAL)
    efficiency = photometry.luminous_efficiency()
    exact = band_integral(efficiency, Bands.explicit([377.5, 782.5]), "refuse").value[0]
    assert (weights * USUAL.width).sum() == pytest.approx(MAXIMUM_LUMINOUS_EFFICACY * exact, rel=1e-6)
    one = Bands.explicit([550, 560])
    mean = band_integral(efficiency, one, "refuse").value[0] / 10
    assert photometric.luminous_weights(one)[0] == pytest.approx(683.002 * mean, rel=1e-12)


def test_weights_are_exact_for_linear_light_and_of_fourth_order_for_smooth():
    fine = np.arange(360, 830.001, 0.02)
    action = Spectrum(fine, np.exp(-(((fine - 560) / 40) ** 2) / 2))
    ramp = Spectrum([360, 830], [0, 1])
    exact = np.trapezoid(action.value * (fine - 360) / 470, fine)
    bands = Bands.uniform(380, 780, 5)
    found = band_weights(action, bands) @ band_integral(ramp, bands, "refuse").value
    assert found == pytest.approx(exact, rel=1e-6)
    light = bell(520, 30)
    truth = np.trapezoid(action.value * np.interp(fine, light.wavelength, light.value), fine)
    steps = np.array([5.0, 10.0, 20.0])
    errors = []
    for step in steps:
        bands = Bands.uniform(380, 780, step)
        errors.append(abs(band_weights(action, bands) @ band_integral(light, bands, "hold").value / truth - 1))
    order = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert (order > 3.5).all(), (errors, order)


def test_bands_of_any_width_and_with_gaps_have_no_negative_weight():
    for bands in (USUAL, Bands.uniform(400, 700, 50), Bands.explicit([[400, 480], [480, 500], [500, 501], [600, 700]])):
        assert (photometric.luminous_weights(bands) >= 0).all()
        assert (colorimetric.xyz_weights(bands) >= 0).all()


def test_quantities_keep_the_shape_and_are_linear():
    rng = np.random.default_rng(4)
    power = rng.random((7, 3, len(USUAL)))
    assert photometric.illuminance(power, USUAL).shape == (7, 3)
    assert colorimetric.xyz(power, USUAL).shape == (7, 3, 3)
    np.testing.assert_allclose(photometric.luminance(3 * power, USUAL), 3 * photometric.illuminance(power, USUAL))


def test_d65_is_the_white_of_srgb():
    power = band_integral(photometry.illuminant("D65"), USUAL, "hold").value
    white = colorimetric.xyz(power, USUAL)
    linear = colorimetric.xyz_to_linear_srgb(white, white[1])
    np.testing.assert_allclose(linear, 1, atol=5e-4)
    np.testing.assert_allclose(colorimetric.xyz_to_linear_srgb(white / 2, white[1]), linear / 2)
    # the white that IEC 61966-2-1 prints for the matrix, to its four digits
    np.testing.assert_allclose(colorimetric.xyz_to_linear_srgb(np.array([0.9505, 1.0, 1.0890]), 1.0), 1, atol=2e-4)
    with pytest.raises(ValueError, match="luminance"):
        colorimetric.xyz_to_linear_srgb(white, 0)


def test_primaries_of_srgb_become_single_channels():
    x, y = colorimetric.SRGB_PRIMARIES.T
    tristimulus = np.stack([x / y, np.ones(3), (1 - x - y) / y], axis=1)
    linear = colorimetric.xyz_to_linear_srgb(tristimulus, 1.0)
    np.testing.assert_allclose(linear / linear.max(axis=1, keepdims=True), np.eye(3), atol=1e-12)
    assert not colorimetric.out_of_gamut(linear).any()
    np.testing.assert_allclose(1 / np.diag(linear), [0.2126, 0.7152, 0.0722], atol=5e-5)


def test_encoding_has_the_published_points_and_clips():
    codes = colorimetric.encode_srgb(np.array([-1, 0, 0.0031308, 0.21404114, 1, 9]))
    np.testing.assert_allclose(codes, [0, 0, 0.04045, 0.5, 1, 1], atol=2e-6)
    assert (np.diff(colorimetric.encode_srgb(np.linspace(0, 1, 1001))) > 0).all()


def test_masks_tell_saturation_from_brightness():
    linear = np.array([[0.5, 0.5, 0.5], [-0.1, 0.5, 0.5], [2, 0.5, 0.5], [-1e-13, 0, 1]])
    np.testing.assert_array_equal(colorimetric.out_of_gamut(linear), [False, True, False, False])
    np.testing.assert_array_equal(colorimetric.overexposed(linear), [False, False, True, False])


def test_no_light_has_no_chromaticity():
    assert np.isnan(colorimetric.chromaticity(np.zeros((2, 3)))).all()


def test_wrong_colours_and_methods_are_refused():
    for rgb in ([0, 0], [0, 0, 1.1], [0, -0.1, 0], [0, np.nan, 0]):
        with pytest.raises(ValueError, match="linear sRGB"):
            upsample_rgb(rgb)
    with pytest.raises(ValueError, match="method"):
        upsample_rgb([0, 0, 0], "smits")


@pytest.mark.slow
@pytest.mark.parametrize(("method", "tolerance"), [("mallett2019", 2e-3), ("otsu2018", 0.02)])
def test_guessed_reflectances_have_the_colour_they_were_guessed_from(method, tolerance):
    lamp = band_integral(photometry.illuminant("D65"), USUAL, "hold").value
    white = colorimetric.xyz(lamp, USUAL)[1]
    for rgb in ([0.5, 0.5, 0.5], [0.6, 0.2, 0.1], [0.1, 0.3, 0.5]):
        spectrum = upsample_rgb(rgb, method)
        assert spectrum.value.min() >= 0
        assert spectrum.value.max() <= 1
        seen = colorimetric.xyz(lamp * np.interp(USUAL.centre, spectrum.wavelength, spectrum.value), USUAL)
        np.testing.assert_allclose(colorimetric.xyz_to_linear_srgb(seen, white), rgb, atol=tolerance)


@pytest.mark.slow
def test_colour_science_agrees():
    import colour

    rng = np.random.default_rng(8)
    tristimulus = rng.random((50, 3))
    with colour.utilities.suppress_warnings(colour_usage_warnings=True):
        theirs = colour.XYZ_to_RGB(tristimulus, "sRGB", apply_cctf_encoding=False)
        encoded = colour.cctf_encoding(np.clip(theirs, 0, 1), "sRGB")
    mine = colorimetric.xyz_to_linear_srgb(tristimulus, 1.0)
    np.testing.assert_allclose(mine, theirs, atol=1e-3)  # it uses the matrix rounded to four digits
    np.testing.assert_allclose(colorimetric.encode_srgb(theirs), encoded, atol=1e-6)
    np.testing.assert_allclose(colorimetric.chromaticity(tristimulus), colour.XYZ_to_xy(tristimulus), atol=1e-12)


@pytest.mark.parametrize(
    ("lines", "step", "most"), [([589.0, 589.6], 5, 5e-5), ([546.07], 5, 3e-4), ([435.83], 1, 1e-5)]
)
def test_lines_have_their_own_colour_in_any_bands(lines, step, most):
    """In one band alone x of the green mercury line would be 0.008 off, that of sodium 0.004."""
    at, functions = photometry.observer("1931")
    own = sum(np.array([np.interp(line, at, column) for column in functions.T]) for line in lines)
    bands = Bands.uniform(380, 780, step)
    power = band_integral(Spectrum([], [], lines, np.ones(len(lines))), bands, "zero").value[None]
    np.testing.assert_allclose(
        colorimetric.chromaticity(colorimetric.xyz(power, bands))[0], own[:2] / own.sum(), atol=most
    )
