"""Reflectances and amounts of light are those that the scene file states."""

import numpy as np
import pytest
from scene_writing import FLOOR, HEADER, LAMP, OPEN_ROOM, PAINT, PANEL, faults, load, warnings

from hradiosity.metrics.photometric import illuminance
from hradiosity.model import photometry
from hradiosity.model.geometry import NONE
from hradiosity.model.spectrum import Bands

POINT = '[[point_source]]\nposition = [1, 1, 2]\nluminaire = "lamp"\n'


def lamp(spectrum, amount):
    return f"[luminaires.lamp]\nspectrum = {spectrum}\n{amount}\n"


def luminaire(tmp_path, spectrum, amount, surfaces=PANEL, header=HEADER):
    scene = load(tmp_path, header + PAINT + lamp(spectrum, amount) + surfaces)
    return scene.luminaires[0], scene


def reflectance(tmp_path, form, header=HEADER):
    return load(tmp_path, header + f"[materials.paint]\nreflectance = {form}\n" + LAMP + PANEL).materials[0].reflectance


def test_constant_reflectance(tmp_path):
    np.testing.assert_array_equal(reflectance(tmp_path, "0.3"), np.full(81, 0.3))
    np.testing.assert_array_equal(reflectance(tmp_path, "1"), np.ones(81))


def test_straight_line_from_a_file(tmp_path):
    (tmp_path / "line.csv").write_text("nm,a,b\n300,0,0.5\n900,0.6,0.5\n")
    found = reflectance(tmp_path, '{ file = "line.csv", column = "a" }')
    np.testing.assert_allclose(found, (np.arange(380, 781, 5) - 300) * 1e-3, rtol=1e-13)


def test_short_file_holds_its_ends_and_says_so(tmp_path):
    (tmp_path / "short.csv").write_text("400,0.2\n700,0.2\n")
    scene = load(tmp_path, OPEN_ROOM.replace("0.5", '{ file = "short.csv" }', 1))
    np.testing.assert_allclose(scene.materials[0].reflectance, 0.2, rtol=1e-15)
    assert [note.kind for note in scene.notes] == ["info"]
    assert "given from 400 to 700 nm" in scene.notes[0].message


def test_file_that_ends_half_a_step_short_needs_no_note(tmp_path):
    rows = "".join(f"{nm},0.2\n" for nm in range(380, 781, 5))
    (tmp_path / "full.csv").write_text(rows)
    scene = load(tmp_path, OPEN_ROOM.replace("0.5", '{ file = "full.csv", outside = "hold" }', 1))
    assert scene.notes == ()


def test_steps(tmp_path):
    header = HEADER + "bands = { edges = [400, 450, 500, 600, 640] }\n"
    found = reflectance(tmp_path, "{ steps = [[440, 480, 0.1], [480, 620, 0.5]] }", header)
    np.testing.assert_allclose(found, [0.1, (30 * 0.1 + 20 * 0.5) / 50, 0.5, 0.5], rtol=1e-14)


def test_library(tmp_path):
    np.testing.assert_array_equal(reflectance(tmp_path, '{ library = "grey/50" }'), np.full(81, 0.5))
    red = reflectance(tmp_path, '{ library = "colorchecker/red" }')
    assert red[20] < 0.1 < 0.5 < red[60]


def test_colour_is_a_guess_and_flagged(tmp_path):
    scene = load(tmp_path, OPEN_ROOM.replace("0.5", '{ rgb = [0.9, 0.1, 0.1], upsample = "mallett2019" }', 1))
    assert not scene.materials[0].measured
    assert "guessed from a colour" in warnings(scene)[0]
    assert scene.materials[0].reflectance[60] > 3 * scene.materials[0].reflectance[20]


def test_sides_of_a_material(tmp_path):
    assert load(tmp_path, OPEN_ROOM).materials[0].two_sided
    assert not load(tmp_path, OPEN_ROOM.replace("0.5", '0.5\nsides = "front"', 1)).materials[0].two_sided


def test_bands(tmp_path):
    assert load(tmp_path, OPEN_ROOM).bands == Bands.uniform(380, 780, 5)
    text = OPEN_ROOM.replace('"m"\n', '"m"\nbands = FORM\n')
    uniform = load(tmp_path, text.replace("FORM", "{ first = 400, last = 700, step = 10 }"))
    assert uniform.bands == Bands.uniform(400, 700, 10)
    ranges = load(tmp_path, text.replace("FORM", "{ ranges = [[400, 500], [550, 600]] }"))
    assert ranges.bands == Bands.explicit([[400, 500], [550, 600]])


def test_absolute_exitance_is_power_per_band(tmp_path):
    found, _ = luminaire(tmp_path, "{ constant = 0.2 }", "absolute = true")
    np.testing.assert_allclose(found.exitance, 1.0, rtol=1e-14)
    assert len(found.intensity) == 0


@pytest.mark.parametrize(
    "spectrum", ['{ illuminant = "D65" }', "{ blackbody_K = 2700 }", "{ lines = [[546.1, 1.0], [611, 2]] }"]
)
def test_luminous_flux_comes_out_as_illuminance(tmp_path, spectrum):
    """A flux of 500 lm over 1 m² is 500 lm m⁻² of exitance, counted with the weights of the results."""
    found, scene = luminaire(tmp_path, spectrum, "luminous_flux_lm = 500")
    assert illuminance(found.exitance, scene.bands) == pytest.approx(500, rel=2e-5)


def test_radiant_flux_and_exitance(tmp_path):
    panel = PANEL.replace("edge_v = [1.0", "edge_v = [4.0")
    found, _ = luminaire(tmp_path, '{ illuminant = "A" }', "radiant_flux_W = 10", panel)
    assert found.exitance.sum() == pytest.approx(2.5, rel=1e-14)
    found, _ = luminaire(tmp_path, '{ illuminant = "A" }', "radiant_exitance_W_m2 = 10", panel)
    assert found.exitance.sum() == pytest.approx(10, rel=1e-14)
    found, scene = luminaire(tmp_path, '{ illuminant = "A" }', "luminous_exitance_lm_m2 = 10", panel)
    assert illuminance(found.exitance, scene.bands) == pytest.approx(10, rel=2e-5)


def test_flux_is_shared_by_both_sides(tmp_path):
    one, _ = luminaire(tmp_path, "{ constant = 1.0 }", "radiant_flux_W = 10")
    both, _ = luminaire(tmp_path, "{ constant = 1.0 }", 'radiant_flux_W = 10\nsides = "both"')
    assert (one.two_sided, both.two_sided) == (False, True)
    np.testing.assert_allclose(both.exitance, one.exitance / 2, rtol=1e-14)


def test_flux_is_per_object_and_shared_by_area(tmp_path):
    small = PANEL
    same = PANEL.replace('"panel"', '"panel 2"').replace("corner = [0.0", "corner = [2.0")
    large = PANEL.replace('"panel"', '"panel 3"').replace("edge_v = [1.0", "edge_v = [4.0")
    _, scene = luminaire(tmp_path, "{ constant = 1.0 }", "radiant_flux_W = 10", small + same + large)
    assert [kind.name for kind in scene.luminaires] == ["lamp (panel)", "lamp (panel 3)"]
    assert list(scene.emitters.luminaire) == [0, 0, 1]
    exitance = np.array([scene.luminaires[k].exitance.sum() for k in scene.emitters.luminaire])
    power = exitance * scene.patches.area[scene.emitters.patch]
    np.testing.assert_allclose(power, 10, rtol=1e-14)


def test_flux_of_a_box_is_over_all_its_emitting_faces(tmp_path):
    box = '[[box]]\ncorner = [0, 0, 0]\nsize = [1, 2, 3]\nmaterial = "paint"\n'
    box += 'luminaires = { top = "lamp", left = "lamp" }\n'
    found, scene = luminaire(tmp_path, "{ constant = 1.0 }", "radiant_flux_W = 10", box)
    assert len(scene.emitters) == 2
    assert found.exitance.sum() == pytest.approx(10 / (2 + 6), rel=1e-14)


def test_luminous_flux_with_bands_that_hold_only_part_of_the_light(tmp_path):
    """Half of the lumens in the bands: the bands get half of the flux, and not all of it."""
    full, _ = luminaire(tmp_path, '{ illuminant = "E" }', "luminous_flux_lm = 100")
    header = HEADER + "bands = { first = 580, last = 780, step = 5 }\n"
    part, _ = luminaire(tmp_path, '{ illuminant = "E" }', "luminous_flux_lm = 100", header=header)
    np.testing.assert_allclose(part.exitance, full.exitance[40:], rtol=1e-4)


def test_lines_outside_all_bands_are_reported(tmp_path):
    _, scene = luminaire(tmp_path, "{ lines = [[546.1, 1.0], [1014.0, 1.0]] }", "radiant_flux_W = 10")
    assert "1014 nm" in warnings(scene)[0]


@pytest.mark.parametrize(
    "bands",
    ["", "{ first = 380, last = 780, step = 1 }", "{ first = 400, last = 700, step = 50 }", "{ edges = [300, 800] }"],
)
def test_lines_of_a_file_keep_the_flux_on_any_bands(tmp_path, bands):
    """A continuum of 2 per nm from 395 to 705 nm (half steps included), and two lines of 40 and 100."""
    (tmp_path / "lamp.csv").write_text("nm,power\n400,2\nline,546.07,40\n410,2\n690,2\n700,2\nline,435.83,100\n")
    header = HEADER + (f"bands = {bands}\n" if bands else "")
    spectrum = '{ file = "lamp.csv" }'
    found, scene = luminaire(tmp_path, spectrum, "absolute = true", header=header)
    low, high = max(395.0, scene.bands.lower[0]), min(705.0, scene.bands.upper[-1])
    assert found.exitance.sum() == pytest.approx(2 * (high - low) + 140, rel=1e-12)
    around = np.abs(scene.bands.centre - 435.83) <= scene.bands.width
    assert found.exitance[around].sum() > 100
    found, _ = luminaire(tmp_path, spectrum, "radiant_flux_W = 10", header=header)
    assert found.exitance.sum() == pytest.approx(10, rel=1e-12)
    found, _ = luminaire(tmp_path, spectrum, "luminous_flux_lm = 500", header=header)
    assert illuminance(found.exitance, scene.bands) == pytest.approx(500, rel=1e-6)


@pytest.mark.parametrize(("outside", "beyond"), [("zero", 0.0), ("hold", 5.0)])
def test_light_beyond_the_measured_wavelengths(tmp_path, outside, beyond):
    rows = "".join(f"{nm},1\n" for nm in range(400, 701))
    (tmp_path / "lamp.csv").write_text(rows)
    found, scene = luminaire(tmp_path, f'{{ file = "lamp.csv", outside = "{outside}" }}', "absolute = true")
    assert found.exitance[0] == pytest.approx(beyond)
    np.testing.assert_allclose(found.exitance[4:65], 5.0, rtol=1e-13)
    assert "given from 400 to 700 nm" in scene.notes[0].message


def test_light_that_must_cover_all_bands(tmp_path):
    (tmp_path / "lamp.csv").write_text("400,1\n700,1\n")
    text = HEADER + PAINT + lamp('{ file = "lamp.csv", outside = "refuse" }', "absolute = true") + PANEL
    assert "covers 395 to 705 nm" in faults(tmp_path, text)[0]


def test_point_source(tmp_path):
    found, scene = luminaire(tmp_path, "{ constant = 1.0 }", "radiant_flux_W = 10", FLOOR + POINT)
    assert found.intensity.sum() == pytest.approx(10 / (4 * np.pi), rel=1e-14)
    assert len(found.exitance) == 0
    assert list(scene.emitters.patch) == [NONE]
    np.testing.assert_array_equal(scene.emitters.position, [[1, 1, 2]])
    found, _ = luminaire(tmp_path, "{ constant = 0.2 }", "absolute = true", FLOOR + POINT)
    np.testing.assert_allclose(found.intensity, 1.0, rtol=1e-14)


def test_one_luminaire_on_a_surface_and_at_a_point(tmp_path):
    _, scene = luminaire(tmp_path, "{ constant = 1.0 }", "radiant_flux_W = 10", PANEL + POINT)
    area, point = scene.luminaires
    assert list(scene.emitters.luminaire) == [0, 1]
    assert (len(area.exitance), len(area.intensity), len(point.exitance), len(point.intensity)) == (81, 0, 0, 81)


@pytest.mark.parametrize("amount", ["illuminance_lx = 10000", f"luminance_cd_m2 = {10000 / np.pi}"])
def test_sky(tmp_path, amount):
    """Illuminance of a plane under a uniform sky is π sr times its luminance."""
    sky = f'[sky]\nkind = "uniform"\nspectrum = {{ illuminant = "D65" }}\n{amount}\n'
    scene = load(tmp_path, HEADER + PAINT + sky + FLOOR)
    assert np.pi * illuminance(scene.sky.radiance, scene.bands) == pytest.approx(10000, rel=2e-5)
    table = photometry.illuminant("D65")
    inside = scene.bands.lower[:, None] + scene.bands.width[:, None] * (np.arange(500) + 0.5) / 500
    ratio = scene.sky.radiance / np.interp(inside, table.wavelength, table.value).mean(axis=1)
    np.testing.assert_allclose(ratio, ratio[40], rtol=1e-5)


def test_unused_luminaire_is_reported(tmp_path):
    scene = load(tmp_path, OPEN_ROOM + LAMP.replace("lamp", "spare"))
    assert "gives no light" in warnings(scene)[0]
