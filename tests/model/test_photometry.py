import numpy as np
import pytest

from hradiosity.constants import MAXIMUM_LUMINOUS_EFFICACY
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands
from hradiosity.suites.validation.data import colour_values

EXPECTED = colour_values()


def test_luminous_efficiency_peaks_at_one_at_555_nm():
    efficiency = photometry.luminous_efficiency()
    assert efficiency.value.max() == 1
    assert efficiency.wavelength[efficiency.value.argmax()] == 555


def test_observers_see_equal_energy_as_white_and_the_1931_one_has_v_as_second():
    for name in ("1931", "1964"):
        wavelength, functions = photometry.observer(name)
        assert functions.shape == (471, 3) == (len(wavelength), 3)
        np.testing.assert_allclose(functions.sum(axis=0) / functions[:, 1].sum(), 1, atol=4e-4)
    efficiency = photometry.luminous_efficiency().value
    np.testing.assert_allclose(photometry.observer("1931")[1][:, 1], efficiency, atol=1e-5)


@pytest.mark.parametrize("name", ["D65", "E", "A"])
def test_alpha_opic_efficacies_are_those_of_cie_s_026(name):
    wavelength, action = photometry.alpha_opic()
    lamp = photometry.illuminant(name)
    power = np.interp(wavelength, lamp.wavelength, lamp.value)
    luminous = MAXIMUM_LUMINOUS_EFFICACY * (photometry.luminous_efficiency().value * power).sum()
    found = 1e3 * (action * power[:, None]).sum(axis=0) / luminous
    constants = EXPECTED["S026_K_mW_per_lm"][name]
    np.testing.assert_allclose(found, [constants[key] for key in ("sc", "mc", "lc", "rh", "mel")], rtol=5e-5)
    assert action.shape == (471, len(photometry.ALPHA_OPIC_NAMES))
    np.testing.assert_allclose(action.max(axis=0), 1, atol=1e-4)


def test_illuminant_a_is_a_black_body_of_2855_5_kelvin():
    # CIE 15: defined with c2 = 1.435e-2 at 2848 K, which is 2855.5 K with today's c2
    lamp, body = photometry.illuminant("A"), photometry.blackbody(2848 * 1.438776877 / 1.435)
    ratio = lamp.value / np.interp(lamp.wavelength, body.wavelength, body.value)
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-5)


def test_black_body_follows_wien_and_stefan_boltzmann():
    body = photometry.blackbody(6500)
    assert body.wavelength[body.value.argmax()] == round(2.897771955e6 / 6500)
    hot = photometry.blackbody(10000)  # share of all power below a wavelength: Planck's integral as a series
    x = 1.438776877e-2 / (np.array([1100e-9, 300e-9]) * 1e4)
    n = np.arange(1, 60)[:, None]
    below = (np.exp(-n * x) * (x**3 / n + 3 * x**2 / n**2 + 6 * x / n**3 + 6 / n**4)).sum(axis=0) * 15 / np.pi**4
    radiance = 5.670374419e-8 * 1e16 / np.pi * (below[0] - below[1])
    assert np.trapezoid(hot.value, hot.wavelength) == pytest.approx(radiance, rel=2e-6)
    for temperature in (0, -3, np.nan, 1e6):
        with pytest.raises(ValueError, match="temperature"):
            photometry.blackbody(temperature)


def test_lamps_have_their_lines_where_they_are_in_narrow_bands_only():
    narrow, usual = (Bands.uniform(380, 780, step) for step in (1, 5))
    fine = photometry.illuminant("FL2", narrow)
    assert fine.value.sum() == pytest.approx(2968.9113, rel=1e-6)  # as the CIE states
    around = (fine.wavelength > 430) & (fine.wavelength < 442)
    line = fine.value[around] - fine.value[around].min()
    assert (line * fine.wavelength[around]).sum() / line.sum() == pytest.approx(435.83, abs=0.15)
    for lamp in (photometry.illuminant("FL2"), photometry.illuminant("FL2", usual)):
        assert lamp.value.max() < 0.5 * fine.value.max()
    assert photometry.illuminant("D65", narrow).value.tolist() == photometry.illuminant("D65").value.tolist()


def test_every_table_can_be_had_by_name():
    assert len(photometry.colorchecker_names()) == 24
    asked = {"A", "D50", "D65", "E", "LED-B1", "LED-V2", *(f"FL{i}" for i in range(1, 13))}
    assert asked <= set(photometry.illuminant_names())
    for name in photometry.illuminant_names():
        assert photometry.illuminant(name).value.max() > 0
    for name in photometry.reflectance_names():
        value = photometry.reflectance(name).value
        assert value.min() >= 0
        assert value.max() <= 1
    np.testing.assert_array_equal(
        photometry.reflectance("colorchecker/cyan").value, photometry.colorchecker("cyan").value
    )


def test_greys_are_named_by_percent():
    assert (photometry.reflectance("grey/18").value == 0.18).all()
    for name in ("grey/101", "grey/-1", "grey/dark", "grey/nan"):
        with pytest.raises(ValueError, match="percent"):
            photometry.reflectance(name)


@pytest.mark.parametrize(
    ("call", "hint"),
    [
        (lambda: photometry.illuminant("d56"), "D65"),
        (lambda: photometry.illuminant("LEDB3"), "LED-B3"),
        (lambda: photometry.reflectance("cornell/wite"), "cornell/white"),
        (lambda: photometry.colorchecker("dark skn"), "dark skin"),
        (lambda: photometry.observer("2"), "1931, 1964"),
    ],
)
def test_unknown_names_get_near_matches(call, hint):
    with pytest.raises(ValueError, match=hint):
        call()


@pytest.mark.slow
def test_tables_are_those_of_colour_science():
    import colour

    full_names = {"1931": "CIE 1931 2 Degree Standard Observer", "1964": "CIE 1964 10 Degree Standard Observer"}
    for name, full in full_names.items():
        np.testing.assert_array_equal(photometry.observer(name)[1], colour.MSDS_CMFS[full].values)
    for name in photometry.illuminant_names():
        mine, theirs = photometry.illuminant(name), colour.SDS_ILLUMINANTS[name]
        at = theirs.wavelengths
        np.testing.assert_allclose(np.interp(at, mine.wavelength, mine.value), theirs.values, rtol=2e-5, atol=1e-6)
    for name, theirs in colour.SDS_COLOURCHECKERS["ISO 17321-1"].items():
        np.testing.assert_array_equal(photometry.colorchecker(name.split(" (")[0]).value, theirs.values)
    body = photometry.blackbody(3000)
    radiance = colour.colorimetry.planck_law(body.wavelength * 1e-9, 3000, c2=1.438776877e-2) * 1e-9
    np.testing.assert_allclose(body.value, radiance, rtol=1e-5)  # its c1 is rounded
