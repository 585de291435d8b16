"""Receptors of the eye, and what bands leave out."""

import numpy as np
import pytest
from lights import EVERY_NM, EXPECTED, TOLERANCE, USUAL, power_of, random_mixtures

from hradiosity.io.spectra import read_spectrum_csv
from hradiosity.metrics.eye import (
    RECEPTORS,
    action_irradiance,
    alpha_opic_irradiance,
    alpha_opic_weights,
    daylight_efficacies,
    daylight_efficacy_ratio,
    equivalent_daylight_illuminance,
)
from hradiosity.metrics.photometric import illuminance
from hradiosity.metrics.truncation import outside_share, truncation, truncation_lines
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Spectrum

IN_FILE = ("l-cone-opic", "m-cone-opic", "s-cone-opic", "rhodopic", "melanopic")
COLUMNS = [RECEPTORS.index(name) for name in IN_FILE]
CIE_MELANOPIC = {
    380: 9.18165e-4,
    382: 1.17858e-3,
    400: 0.0114277,
    436: 0.336016,
    478: 0.949035,
    483: 0.983006,
    490: 1.0,
    497: 0.98422,
    504: 0.932236,
    508: 0.888663,
    546: 0.265737,
    580: 0.0268747,
    620: 9.47313e-4,
}
CIE_CONES = {
    480: (0.350108, 0.355066, 0.20794),
    493: (0.153311, 0.494927, 0.312673),
    506: (0.0594049, 0.682055, 0.469997),
}


def test_efficacies_of_daylight_are_those_of_the_standard():
    np.testing.assert_allclose(1e3 * daylight_efficacies(), [1.3262, 1.4497, 0.8173, 1.4558, 1.6289], atol=5e-5)


@pytest.mark.parametrize("bands", [USUAL, EVERY_NM], ids=["5 nm", "1 nm"])
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        *((n, v["luxpy"]["DER_lc_mc_sc_rh_mel"]) for n, v in EXPECTED["illuminants"].items() if "DER" in str(v)),
        *((n, v["DER_lc_mc_sc_rh_mel"]) for n, v in EXPECTED["analytic_spectra"].items() if "DER" in str(v)),
    ],
)
def test_daylight_efficacy_ratios(name, expected, bands):
    """In bands of 5 nm a mercury line has no place of its own, see `test_what_bands_of_5_nm_do_to_lines`."""
    found = daylight_efficacy_ratio(power_of(name, bands), bands)[0, COLUMNS]
    lines = name.startswith("FL") and bands is USUAL
    np.testing.assert_allclose(found, expected, rtol=(2 if lines else 1) * TOLERANCE["DER_rel"])


def test_what_bands_of_5_nm_do_to_lines():
    """Sums over the CIE's own table every 5 nm, as CIE 15 has them, are as far off: 1.6e-3 for melanopsin and FL11."""
    expected = EXPECTED["illuminants"]["FL11"]["luxpy"]["DER_lc_mc_sc_rh_mel"][-1]
    wavelength, action = photometry.alpha_opic()
    lamp = photometry.illuminant("FL11")
    every_5_nm = np.arange(380.0, 781.0, 5.0)
    power = np.interp(every_5_nm, lamp.wavelength, lamp.value)
    efficiency = photometry.luminous_efficiency()
    melanopic = power @ np.interp(every_5_nm, wavelength, action[:, 4])
    luminous = 683.002 * power @ np.interp(every_5_nm, efficiency.wavelength, efficiency.value)
    summed = melanopic / luminous / daylight_efficacies()[0]
    assert summed / expected - 1 == pytest.approx(1.6e-3, abs=1e-4)
    for bands, most in ((USUAL, 2e-3), (EVERY_NM, 2e-4)):
        assert abs(daylight_efficacy_ratio(power_of("FL11", bands), bands)[0, 0] / expected - 1) < most


def test_action_spectra_are_those_of_the_cie():
    """Values that the CIE publishes every 1 nm (doi 10.25039/CIE.DS.vqqhzp5a), between the nodes of the 5 nm too."""
    wavelength, action = photometry.alpha_opic()
    for at, published in CIE_MELANOPIC.items():
        assert action[wavelength == at, 4][0] == pytest.approx(published, abs=4e-5), at
    for at, published in CIE_CONES.items():
        np.testing.assert_allclose(action[wavelength == at, :3][0], published, rtol=1e-5)


def test_daylight_does_to_each_receptor_what_it_does():
    lux = illuminance(power_of("D65"), USUAL)
    np.testing.assert_allclose(equivalent_daylight_illuminance(power_of("D65"), USUAL)[0], lux[0], rtol=2e-5)


def test_grey_surroundings_leave_ratios_alone():
    """Inside a closed grey room all bands are multiplied alike."""
    for name, melanopic in (("D65", 1.0), ("FL11", 0.5632)):
        found = daylight_efficacy_ratio(power_of(name) / (1 - 0.8), USUAL)
        np.testing.assert_allclose(found, daylight_efficacy_ratio(power_of(name), USUAL), rtol=1e-12)
        assert found[0, 0] == pytest.approx(melanopic, abs=5e-4)


def test_numbers_belong_together():
    power = random_mixtures(20)
    lux, edi = illuminance(power, USUAL), equivalent_daylight_illuminance(power, USUAL)
    np.testing.assert_allclose(edi * daylight_efficacies(), alpha_opic_irradiance(power, USUAL))
    np.testing.assert_allclose(daylight_efficacy_ratio(power, USUAL), edi / lux[:, None])
    assert np.isnan(daylight_efficacy_ratio(np.zeros((2, 81)), USUAL)).all()
    assert alpha_opic_weights(USUAL).shape == (81, 5)


def test_any_action_spectrum_weights_light(tmp_path):
    """V(λ) from a file gives lux; a step gives the irradiance on its side."""
    efficiency = photometry.luminous_efficiency()
    rows = [f"{w:g},{v:.17g}" for w, v in zip(efficiency.wavelength, efficiency.value)]
    (tmp_path / "v.csv").write_text("\n".join(["wavelength_nm,weight", *rows]) + "\n")
    power = random_mixtures(20)
    found = 683.002 * action_irradiance(power, USUAL, read_spectrum_csv(tmp_path / "v.csv"))
    np.testing.assert_allclose(found, illuminance(power, USUAL), rtol=1e-12)
    blue = Spectrum([377.5, 497.5 - 1e-9, 497.5], [1, 1, 0])
    np.testing.assert_allclose(action_irradiance(power, USUAL, blue), power[:, :24].sum(axis=1), rtol=1e-9)
    with pytest.raises(ValueError, match="lines"):
        action_irradiance(power, USUAL, Spectrum([], [], [500], [1]))


def test_shares_outside_are_areas():
    flat = Spectrum([400, 700], [1, 1])
    assert outside_share(flat, Bands.explicit([400, 700])) == 0
    assert outside_share(flat, Bands.explicit([300, 900])) == 0
    assert outside_share(flat, Bands.explicit([430, 640])) == pytest.approx(0.3)
    assert outside_share(flat, Bands.explicit([[400, 450], [500, 700]])) == pytest.approx(1 / 6)
    assert outside_share(flat, Bands.explicit([100, 200])) == 1
    ramp = Spectrum([400, 700], [0, 1])
    assert outside_share(flat, Bands.explicit([400, 550]), ramp) == pytest.approx(0.75, rel=1e-6)
    assert outside_share(ramp, Bands.explicit([400, 550]), ramp) == pytest.approx(7 / 8, rel=1e-5)
    assert outside_share(Spectrum([400, 700], [0, 0]), Bands.explicit([500, 600])) == 0


def test_what_is_outside_is_told():
    assert truncation_lines(USUAL) == []
    found = {item.number: item.outside for item in truncation(Bands.uniform(400, 700, 10))}
    assert 1e-5 < found["illuminance"] < 1e-3 < found["Rf, Rg"] < 3e-3
    red = truncation(Bands.explicit([580, 780]))
    by_name = {item.number: item.outside for item in red}
    assert by_name["melanopic EDI and DER"] > 0.99
    lines = truncation_lines(Bands.explicit([580, 780]))
    assert len(lines) == len(red)
    assert any("melanopic" in line and "(580 to 780 nm)" in line for line in lines)
    warm = {item.number: item.outside for item in truncation(Bands.explicit([580, 780]), photometry.illuminant("A"))}
    assert warm["illuminance"] < by_name["illuminance"]
    with pytest.raises(ValueError, match="lines"):
        truncation(USUAL, Spectrum([], [], [500], [1]))


def test_shares_are_those_of_the_numbers():
    """Equal-energy light in bands that end early gives so much less of each receptor's irradiance."""
    some = Bands.explicit(np.arange(480, 640.1, 2.0))
    wide = Bands.uniform(361, 829, 2)
    whole, part = (alpha_opic_irradiance(b.width[None], b)[0] for b in (wide, some))
    told = {item.number.split()[0]: item.outside for item in truncation(some)}
    np.testing.assert_allclose([told[name] for name in RECEPTORS], 1 - part / whole, atol=2e-3)
