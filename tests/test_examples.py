"""The numbered examples run and end in a number that physics allows."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from hradiosity.model.photometry import alpha_opic, illuminant, luminous_efficiency

EXAMPLES = Path(__file__).parents[1] / "examples"
OFFICE_FLUX, OFFICE_FLOOR = 6 * 3400.0, 24.0


def last_number(name, capsys):
    """The number that the last printed line ends in."""
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    return float(capsys.readouterr().out.splitlines()[-1].rsplit(" ", 1)[1])


def test_red_wall_reddens_the_floor(capsys):
    assert 1.05 < last_number("01_cornell_box.py", capsys) < 2.0


def test_desks_get_a_usual_share_of_the_flux(capsys):
    """Utilances of furnished rooms with ceiling luminaires lie around 0.6."""
    assert 0.45 < last_number("02_office.py", capsys) * OFFICE_FLOOR / OFFICE_FLUX < 0.8


def melanopic_per_lux(name):
    """Of a lamp alone, up to a constant factor."""
    wavelength, action = alpha_opic()
    lamp, efficiency = illuminant(name), luminous_efficiency()
    power = np.interp(wavelength, lamp.wavelength, lamp.value)
    return (power * action[:, 4]).sum() / (power * np.interp(wavelength, efficiency.wavelength, efficiency.value)).sum()


def test_lamps_differ_at_the_eye_about_as_they_do_by_themselves(capsys):
    """Paints filter the light of both lamps alike, save for the fine structure of their spectra."""
    alone = melanopic_per_lux("FL11") / melanopic_per_lux("LED-B3")
    assert last_number("03_compare_two_lamps.py", capsys) == pytest.approx(alone, rel=0.05)


def test_modelling_index_is_that_of_an_office_with_ceiling_lamps(capsys):
    """It is 0 right below a small lamp in a black room, 1 in a uniform field; a white office lies well between."""
    assert 0.2 < last_number("04_custom_reading.py", capsys) < 0.8


def test_an_awning_takes_the_sky_over_two_thirds_of_the_pavement(capsys):
    """It is low: what lies under it loses nearly all of the sky but that over the street, the rest little."""
    assert 0.3 < last_number("05_sky_view.py", capsys) < 0.8
