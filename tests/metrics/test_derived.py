"""Numbers of colour and the eye together: closed cubes with known answers, darkness, and time."""

import time

import numpy as np
import pytest
from lights import USUAL, power_of, random_mixtures

from hradiosity.metrics import colorimetric, eye, photometric
from hradiosity.metrics.derived import FULL, DerivedNumbers, derived_numbers
from hradiosity.metrics.derived import USUAL as ALWAYS
from hradiosity.metrics.fidelity import FidelityIndex
from hradiosity.metrics.rendering import RenderingIndex
from hradiosity.model.spectrum import Bands, Spectrum, band_mean


@pytest.mark.parametrize(
    ("name", "ratio", "xy", "cct", "duv", "ra", "rf"),
    [
        ("D65", 1.8963, (0.3511, 0.3529), 4779, -0.0017, 97.2, 97.9),
        ("FL11", 1.9340, None, 3287, None, 84.7, 80.7),
    ],
)
def test_closed_cube_with_walls_that_redden(name, ratio, xy, cct, duv, ra, rf):
    """Each band is M / (1 − ρ): faces emit a lamp's light, their reflectance rises from 0.2 at 380 to 0.8 at 780 nm."""
    emitted = power_of(name)
    reflectance = band_mean(Spectrum([380, 780], [0.2, 0.8]), USUAL, "hold").value
    inside = emitted / (1 - reflectance)
    lux = photometric.illuminance(inside, USUAL) / photometric.illuminance(emitted, USUAL)
    assert lux[0] == pytest.approx(ratio, abs=2e-4)
    found = {key: value[0] for key, value in derived_numbers(inside, USUAL, full=True).items()}
    assert found["cct_k"] == pytest.approx(cct, abs=5)
    assert found["ra"] == pytest.approx(ra, abs=0.3)
    assert found["rf"] == pytest.approx(rf, abs=0.3)
    if xy is not None:
        np.testing.assert_allclose(colorimetric.chromaticity(colorimetric.xyz(inside, USUAL))[0], xy, atol=2e-4)
        assert found["duv"] == pytest.approx(duv, abs=1e-4)


def test_numbers_are_those_of_the_functions():
    power = random_mixtures(30)
    for full, names in ((False, ALWAYS), (True, FULL)):
        found = derived_numbers(power, USUAL, full=full)
        assert tuple(found) == tuple(name for name, _ in names)
        assert all(value.shape == (30,) and value.dtype == np.float64 for value in found.values())
        assert DerivedNumbers(USUAL, full=full).names == names
    np.testing.assert_allclose(found["ra"], RenderingIndex(USUAL)(power).ra)
    np.testing.assert_allclose(found["r9"], RenderingIndex(USUAL)(power).special[:, 8])
    np.testing.assert_allclose(found["rg"], FidelityIndex(USUAL)(power).rg)
    np.testing.assert_allclose(found["melanopic_edi_lx"], eye.equivalent_daylight_illuminance(power, USUAL)[:, 0])
    np.testing.assert_allclose(found["l_cone_opic_der"], eye.daylight_efficacy_ratio(power, USUAL)[:, 4])


@pytest.mark.parametrize(
    "bands", [Bands.explicit([380, 780]), Bands.explicit([[400, 450], [500, 501], [600, 900]]), Bands.uniform(700, 800)]
)
def test_odd_bands_and_darkness_make_no_trouble(bands):
    power = np.stack([np.zeros(len(bands)), bands.width, np.eye(len(bands))[-1], np.full(len(bands), 1e-300)])
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        found = derived_numbers(power, bands, full=True)
    assert found["melanopic_edi_lx"][0] == 0
    dark = {name: value[0] for name, value in found.items() if not name.endswith("_lx")}
    assert np.isnan(list(dark.values())).all()
    known = np.isfinite(found["cct_k"])
    assert (np.isfinite(found["ra"]) <= known).all() and (np.isfinite(found["duv"]) >= known).all()


def test_many_spectra_take_milliseconds():
    """400 readings below 30 ms in every replicate, 10 000 in about a second with everything; best of several runs."""

    def seconds(numbers, power):
        numbers(power)
        best = np.inf
        for _ in range(4):
            begun = time.process_time()
            numbers(power)
            best = min(best, time.process_time() - begun)
        return best

    power = random_mixtures(10_000)
    assert seconds(DerivedNumbers(USUAL), power[:400]) < 0.03
    assert seconds(DerivedNumbers(USUAL), power) < 0.6
    assert seconds(DerivedNumbers(USUAL, full=True), power[:2000]) < 0.6


def test_daylight_is_its_own_measure():
    found = {key: value[0] for key, value in derived_numbers(power_of("D65"), USUAL, full=True).items()}
    assert found["cct_k"] == pytest.approx(6504, abs=3)
    ratios = [value for key, value in found.items() if key.endswith("_der")]
    np.testing.assert_allclose(ratios, 1, atol=5e-5)
    assert min(found[key] for key in ("ra", "rf", *(f"r{k}" for k in range(1, 15)))) > 99.9


def test_differences_of_spectra_make_no_trouble():
    """Numbers of spectra that are partly negative mean nothing, but no warning tells of them either."""
    power = np.random.default_rng(2).normal(0.2, 1.0, (300, 81))
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        found = derived_numbers(power, USUAL, full=True)
    assert 0 < np.isfinite(found["ra"]).sum() < 300
