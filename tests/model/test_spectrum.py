import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.model.spectrum import Bands, Spectrum, band_integral, band_mean

heights = st.floats(0, 1e3).filter(lambda v: v == 0 or v > 1e-6)
points = st.lists(st.tuples(st.integers(3000, 9000), heights), min_size=2, max_size=40, unique_by=lambda p: p[0])
spectra = points.map(lambda rows: Spectrum(*(np.array(sorted(rows)) * [0.1, 1]).T))
band_lists = st.lists(st.integers(3000, 9000), min_size=2, max_size=60, unique=True).map(
    lambda edges: Bands.explicit(np.sort(edges) / 10)
)


def exact_total(spectrum):
    return np.trapezoid(spectrum.value, spectrum.wavelength)


def test_uniform_bands_are_centred_on_the_wavelengths_asked_for():
    bands = Bands.uniform()
    assert len(bands) == 81
    np.testing.assert_allclose(bands.centre, np.arange(380, 781, 5), rtol=1e-14)
    np.testing.assert_allclose(bands.width, 5, rtol=1e-12)
    np.testing.assert_array_equal(bands.lower[1:], bands.upper[:-1])
    assert bands == Bands.uniform(380, 780, 5)
    assert hash(bands) == hash(Bands.uniform(380, 780, 5))
    assert bands != Bands.uniform(380, 780, 10)


def test_bands_may_have_gaps_and_one_band_is_enough():
    assert len(Bands.explicit([[400, 410], [500, 520]])) == 2
    assert len(Bands.explicit([400, 700])) == 1
    assert len(Bands.uniform(550, 550, 10)) == 1


@pytest.mark.parametrize(
    "make",
    [
        lambda: Bands.explicit([]),
        lambda: Bands.explicit([500]),
        lambda: Bands.explicit([500, 400]),
        lambda: Bands.explicit([400, 400]),
        lambda: Bands.explicit([-5, 400]),
        lambda: Bands.explicit([400, np.nan]),
        lambda: Bands.explicit([[400, 420], [410, 430]]),
        lambda: Bands.explicit([[500, 520], [400, 410]]),
        lambda: Bands.explicit(np.zeros((2, 3))),
        lambda: Bands.uniform(380, 781, 5),
        lambda: Bands.uniform(380, 780, 0),
        lambda: Bands.uniform(780, 380, 5),
        lambda: Bands.uniform(380, 780, 0.5),
        lambda: Bands.uniform(380, 780, 1e-9),
    ],
)
def test_nonsense_bands_are_refused(make):
    with pytest.raises(ValueError, match=r"band|step|edge"):
        make()


@pytest.mark.parametrize(
    ("wavelength", "value", "lines"),
    [
        ([400, 400], [1, 1], []),
        ([500, 400], [1, 1], []),
        ([400], [1], []),
        ([], [], []),
        ([400, 500], [1], []),
        ([400, 500], [1, np.inf], []),
        ([400, 500], [1, 1], [450]),
    ],
)
def test_nonsense_spectra_are_refused(wavelength, value, lines):
    with pytest.raises(ValueError, match=r"wavelength|point|finite"):
        Spectrum(wavelength, value, lines, np.zeros(0))


def test_values_are_owned_and_immutable():
    value = np.array([1.0, 2.0])
    spectrum = Spectrum(np.array([400.0, 500.0]), value)
    value[0] = 7
    assert spectrum.value[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        spectrum.value[0] = 3


@given(spectra, st.lists(st.floats(0.01, 0.99), max_size=20, unique=True))
def test_bands_that_tile_the_support_keep_the_whole_integral(spectrum, shares):
    first, last = spectrum.wavelength[[0, -1]]
    edges = np.unique(np.concatenate([[first, last], first + (last - first) * np.array(shares)]))
    binned = band_integral(spectrum, Bands.explicit(edges), "refuse")
    assert binned.value.sum() == pytest.approx(exact_total(spectrum), rel=1e-12)
    assert binned.outside_share == 0


@given(st.floats(0, 1), band_lists, st.sampled_from(["hold", "refuse"]))
def test_the_mean_of_a_constant_is_the_constant(value, bands, outside):
    assert (band_mean(Spectrum.constant(value), bands, outside).value == value).all()


@given(spectra, band_lists)
def test_a_mean_stays_within_the_values_and_is_the_integral_over_the_width(spectrum, bands):
    mean = band_mean(spectrum, bands, "hold").value
    assert (mean >= spectrum.value.min()).all()
    assert (mean <= spectrum.value.max()).all()
    scale = spectrum.value.max()
    np.testing.assert_allclose(mean * bands.width, band_integral(spectrum, bands, "hold").value, atol=1e-11 * scale)


@given(spectra, band_lists, st.floats(0, 10), st.sampled_from(["hold", "zero"]))
def test_binning_is_linear(spectrum, bands, factor, outside):
    other = Spectrum(spectrum.wavelength, np.cos(spectrum.wavelength))
    both = Spectrum(spectrum.wavelength, spectrum.value + factor * other.value)
    expected = band_integral(spectrum, bands, outside).value + factor * band_integral(other, bands, outside).value
    np.testing.assert_allclose(band_integral(both, bands, outside).value, expected, rtol=1e-10, atol=1e-9)


@given(spectra, band_lists)
def test_binning_agrees_with_the_exact_primitive(spectrum, bands):
    knots = np.unique(np.concatenate([spectrum.wavelength, bands.lower, bands.upper]))
    height = np.interp(knots, spectrum.wavelength, spectrum.value, left=0, right=0)
    inside = (knots[:-1] >= spectrum.wavelength[0]) & (knots[1:] <= spectrum.wavelength[-1])
    steps = np.where(inside, np.diff(knots) * (height[1:] + height[:-1]) / 2, 0)
    primitive = np.concatenate([[0], np.cumsum(steps)])
    expected = np.interp(bands.upper, knots, primitive) - np.interp(bands.lower, knots, primitive)
    np.testing.assert_allclose(
        band_integral(spectrum, bands, "zero").value, expected, rtol=1e-9, atol=1e-9 * max(1, primitive[-1])
    )


def test_what_lies_outside_is_held_dropped_or_refused_and_reported():
    spectrum = Spectrum([400, 500], [1, 3])
    bands = Bands.explicit([350, 450, 550])
    held = band_integral(spectrum, bands, "hold")
    np.testing.assert_allclose(held.value, [50 + 75, 125 + 150], rtol=1e-14)
    assert held.outside_share == pytest.approx(0.5)
    np.testing.assert_allclose(band_integral(spectrum, bands, "zero").value, [75, 125], rtol=1e-14)
    with pytest.raises(ValueError, match=r"400 to 500 nm.*350 to 550 nm"):
        band_integral(spectrum, bands, "refuse")
    with pytest.raises(ValueError, match="outside must be"):
        band_integral(spectrum, bands, "wrap")


def test_bands_with_gaps_count_only_what_is_inside_them():
    spectrum = Spectrum([400, 500], [0, 1])
    binned = band_integral(spectrum, Bands.explicit([[400, 420], [480, 500]]), "refuse")
    np.testing.assert_allclose(binned.value, [2, 18], rtol=1e-14)


def test_a_line_goes_whole_into_a_band_without_a_like_neighbour():
    bands = Bands.explicit([[400, 410], [410, 424], [430, 440]])
    wavelength = np.array([400, 410, 415, 424, 427, 440, 399.9, 440.1])
    spectrum = Spectrum([], [], wavelength, 2.0 ** np.arange(8))
    np.testing.assert_array_equal(band_integral(spectrum, bands, "refuse").value, [1, 2 + 4 + 8, 32])


@given(st.floats(402.5, 477.5), st.sampled_from([5.0, 2.5, 1.0]))
def test_lines_keep_power_and_mean_wavelength(wavelength, step):
    bands = Bands.uniform(400, 480, step)
    power = band_integral(Spectrum([], [], [wavelength], [3.0]), bands, "refuse").value
    assert power.sum() == pytest.approx(3.0) and power.min() >= 0.0
    assert power @ bands.centre / 3.0 == pytest.approx(wavelength, abs=1e-9)
    assert (np.abs(bands.centre[power > 0.0] - wavelength) < step * (1 + 1e-9)).all()


def test_a_line_on_an_edge_is_halved_and_one_in_the_middle_is_whole():
    bands = Bands.explicit([400, 410, 420])
    np.testing.assert_allclose(band_integral(Spectrum([], [], [410], [2]), bands, "zero").value, [1, 1])
    np.testing.assert_array_equal(band_integral(Spectrum([], [], [415], [2]), bands, "zero").value, [0, 2])
    np.testing.assert_array_equal(band_integral(Spectrum([], [], [420], [2]), bands, "zero").value, [0, 2])


def test_lines_add_to_the_continuum_and_have_no_mean():
    spectrum = Spectrum([400, 500], [1, 1], [450], [10])
    np.testing.assert_allclose(band_integral(spectrum, Bands.explicit([400, 450, 500]), "refuse").value, [55, 55])
    with pytest.raises(ValueError, match="lines"):
        band_mean(spectrum, Bands.explicit([400, 500]), "hold")
