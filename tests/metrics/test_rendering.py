"""Colour rendering and fidelity: published values, references that render perfectly, and colour-science."""

import numpy as np
import pytest
from lights import EXPECTED, FINE, TOLERANCE, USUAL, power_of, random_mixtures

from hradiosity.metrics.appearance import uniform_appearance
from hradiosity.metrics.fidelity import FidelityIndex
from hradiosity.metrics.references import References
from hradiosity.metrics.rendering import RenderingIndex
from hradiosity.metrics.samples import daylight_components, fidelity_samples, rendering_samples
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, band_integral

NARROW = Bands.uniform(400, 700, 10)
COARSE = Bands.explicit(np.linspace(377.5, 782.5, 25))


@pytest.mark.parametrize("bands", [FINE, USUAL], ids=["2 nm", "5 nm"])
def test_indices_of_the_illuminants(bands):
    names = list(EXPECTED["illuminants"])
    power = np.concatenate([power_of(name, bands) for name in names])
    rendering, fidelity = RenderingIndex(bands)(power), FidelityIndex(bands)(power)
    for label, found in (("Ra", rendering.ra), ("Rf", fidelity.rf), ("Rg", fidelity.rg)):
        expected = [EXPECTED["illuminants"][name]["colour_science"][label] for name in names]
        np.testing.assert_allclose(found, expected, rtol=0, atol=TOLERANCE[f"{label}_abs"], err_msg=label)
    np.testing.assert_allclose(rendering.special[:, :8].mean(axis=1), rendering.ra)


@pytest.mark.parametrize("bands", [USUAL, NARROW, COARSE], ids=["usual", "400 to 700 nm", "24 bands"])
def test_references_render_perfectly_in_any_bands(bands):
    """What the bands cut off is missing in light and reference alike; the rest is that of the temperature found."""
    warm = np.concatenate([power_of(f"Planck{kelvin}", bands) for kelvin in (1500, 2000, 2856, 3900)])
    least = 98.0 if bands is NARROW else 99.2  # red beyond 700 nm is what tells cold black bodies apart
    assert (RenderingIndex(bands)(warm).special > least).all()
    fidelity = FidelityIndex(bands)(warm)
    assert (fidelity.rf > 99.2).all() and (np.abs(fidelity.rg - 100) < 1).all()
    white = np.concatenate([power_of(name, bands) for name in ("D55", "D65", "D75")])
    assert (RenderingIndex(bands)(white).special > 99.2).all()
    assert (FidelityIndex(bands)(white).rf > 99.2).all()


def test_references_by_one_band_are_integrals():
    """Sums over a wide band against fine trapezoids, for black bodies, and against the table of D65."""
    bands = Bands.explicit([380, 480, 780])
    references = References(bands, np.eye(2), luminance=1)
    temperature = np.array([1000.0, 2700.0, 20_000.0])
    parts = np.linspace(380, 480, 10_001), np.linspace(480, 780, 30_001)
    for kelvin, found in zip(temperature, references.planckian(temperature)):
        first, second = (np.trapezoid(x**-5 / np.expm1(1.438776877e7 / (x * kelvin)), x) for x in parts)
        assert found[0] == pytest.approx(first / second, rel=2e-5 if kelvin == 1000 else 3e-7)
    d65 = band_integral(photometry.illuminant("D65"), bands, "refuse").value
    nominal = np.array([6500 * 1.438776877 / 1.4380])  # CIE 15: named by an earlier c₂
    assert references.daylight(nominal)[0, 0] == pytest.approx(d65[0] / d65[1], rel=2e-4)


def test_blends_are_steps_or_straight():
    references = References(USUAL, np.ones((81, 1)) * [1.0, 2.0] + USUAL.centre[:, None] * [0.0, 1e-3], luminance=1)
    temperature = np.array([3999.0, 4250.0, 5000.0, 6000.0])
    planckian, daylight = references.planckian(temperature), references.daylight(temperature)
    mixed = references.blend(temperature, 4000, 5000)
    np.testing.assert_allclose(mixed[0], planckian[0])
    np.testing.assert_allclose(mixed[1], 0.75 * planckian[1] + 0.25 * daylight[1])
    np.testing.assert_allclose(mixed[2:], daylight[2:])
    np.testing.assert_allclose(references.blend(temperature, 5000, 5000)[1], planckian[1])


def test_indices_do_not_depend_on_brightness_or_company():
    power = random_mixtures(600)
    for index, names in (
        (RenderingIndex(USUAL), ("ra", "special")),
        (FidelityIndex(USUAL), ("rf", "rg", "local_fidelity", "chroma_shift", "hue_shift")),
    ):
        together, alone, brighter = index(power), index(power[431:432]), index(1e3 * power)
        for name in names:
            np.testing.assert_array_equal(getattr(together, name)[431:432], getattr(alone, name))
            np.testing.assert_allclose(getattr(brighter, name), getattr(together, name), rtol=1e-9, atol=1e-9)


def test_light_without_a_temperature_has_no_indices():
    line = np.where(np.abs(USUAL.centre - 530) < 6, 1.0, 0.0)[None]
    power = np.concatenate([np.zeros((1, 81)), line, power_of("D65"), power_of("Planck40000")])
    with np.errstate(all="raise"):
        rendering, fidelity = RenderingIndex(USUAL)(power), FidelityIndex(USUAL)(power)
    assert np.isnan(rendering.ra).tolist() == [True, True, False, True]
    assert np.isnan(fidelity.rf).tolist() == [True, True, False, True]
    assert RenderingIndex(USUAL)(np.zeros((0, 81))).special.shape == (0, 14)
    assert FidelityIndex(USUAL)(np.zeros((0, 81))).chroma_shift.shape == (0, 16)


def test_saturating_light_widens_the_gamut():
    """Taking the yellow out, as neodymium glass does, makes red and green stronger."""
    lamp = power_of("Planck3500")
    gap = 1.0 - 0.8 * np.exp(-(((USUAL.centre - 580) / 12) ** 2))
    found = FidelityIndex(USUAL)(lamp * gap)
    assert found.rg[0] > 105 and found.rf[0] < 90
    assert found.chroma_shift[0, [0, 15]].min() > 3  # red
    assert found.chroma_shift[0, [6, 7]].min() > 3  # green


def test_white_and_greys_have_no_colour():
    white = np.array([[95.0, 100.0, 110.0], [30.0, 20.0, 5.0]])
    grey = white[:, :, None] * np.array([0.0, 0.2, 1.0])
    lightness, a, b = np.moveaxis(uniform_appearance(grey, white), 1, 0)
    np.testing.assert_allclose(lightness[:, [0, 2]], [[0, 100], [0, 100]], atol=1e-9)
    np.testing.assert_allclose([a, b], 0, atol=0.1)
    assert (np.diff(lightness) > 0).all()


@pytest.mark.slow
def test_samples_are_those_of_colour_science():
    import colour
    from colour.colorimetry.datasets.illuminants import SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    from colour.quality.cfi2017 import load_TCS_CIE2017
    from colour.quality.datasets import SDS_TCS

    theirs = load_TCS_CIE2017(colour.SpectralShape(380, 780, 1))
    np.testing.assert_array_equal(fidelity_samples()[0], theirs.wavelengths)
    np.testing.assert_allclose(fidelity_samples()[1], theirs.values, rtol=1e-7)
    for number, column in enumerate(rendering_samples()[1].T, start=1):
        np.testing.assert_array_equal(column, SDS_TCS["CIE 1995"][f"TCS{number:02d}"].values)
    for name, column in zip(("S0", "S1", "S2"), daylight_components()[1].T):
        np.testing.assert_array_equal(column, SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES[name].values)


@pytest.mark.slow
def test_colour_science_agrees_on_appearance():
    import colour
    from colour.models import JMh_CIECAM02_to_CAM02UCS

    tristimulus = np.random.default_rng(9).uniform(5, 90, (40, 3))
    white = np.array([96.0, 100.0, 80.0])
    seen = colour.XYZ_to_CIECAM02(tristimulus, white, 100, 20, discount_illuminant=True)
    expected = JMh_CIECAM02_to_CAM02UCS(np.stack([seen.J, seen.M, seen.h], axis=-1))
    found = uniform_appearance(tristimulus.T[None], white[None])[0].T
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.slow
def test_colour_science_agrees_on_indices():
    """Its sums are those of CIE 13.3 and CIE 224 at 5 nm; ours weight bands. Lines of lamps make the difference."""
    import colour
    from colour.quality import colour_fidelity_index_ANSIIESTM3018 as fidelity_of

    names = [*(f"FL{k}" for k in range(1, 13)), "D65", "A", "LED-B1", "LED-B3", "LED-BH1", "LED-V1", "LED-RGB1"]
    tables = [colour.SDS_ILLUMINANTS[name].copy().align(colour.SpectralShape(380, 780, 5)) for name in names]
    power = np.concatenate([*(power_of(name) for name in names), random_mixtures(12)])
    tables += [colour.SpectralDistribution(row / 5, USUAL.centre) for row in power[len(names) :]]
    rendering, fidelity = RenderingIndex(USUAL)(power), FidelityIndex(USUAL)(power)
    for row, table in enumerate(tables):
        with colour.utilities.suppress_warnings(colour_usage_warnings=True, colour_runtime_warnings=True):
            general = colour.colour_rendering_index(table, additional_data=True)
            expected = fidelity_of(table, additional_data=True)
        assert rendering.ra[row] == pytest.approx(general.Q_a, abs=0.3)
        special = np.array([general.Q_as[k].Q_a for k in range(1, 15)])  # by Robertson's temperatures
        assert (np.abs(rendering.special[row] - special) < 0.5 + 0.01 * (100 - special)).all()
        assert fidelity.rf[row] == pytest.approx(expected.R_f, abs=0.2)
        assert fidelity.rg[row] == pytest.approx(expected.R_g, abs=0.2)
        local = (fidelity.local_fidelity[row], fidelity.chroma_shift[row], 100 * fidelity.hue_shift[row])
        for found, theirs in zip(local, (expected.R_fs, expected.R_cs, 100 * expected.R_hs)):
            # a colour on the border of two sectors may fall on either side, which moves both
            assert (np.abs(found - theirs) < 0.3).sum() >= 14
