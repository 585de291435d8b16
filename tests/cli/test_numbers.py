"""All kinds of readings and numbers through the program: closed cubes with known answers, a room with everything."""

import csv
import json

import numpy as np
import pytest
from cli_room import QUICK, ROOM
from scene_writing import write

import hradiosity
from hradiosity.metrics.temperature import REASONS
from hradiosity.model import photometry
from hradiosity.model.sensor_kinds import curved_sensor
from hradiosity.model.spectrum import Bands, Spectrum, band_integral, band_mean

CUBE = """
[scene]
unit = "m"
bands = {{ first = 380, last = 780, step = {step} }}
[materials.paint]
reflectance = {reflectance}
[luminaires.glow]
spectrum = {{ illuminant = "{lamp}" }}
luminous_exitance_lm_m2 = 1000
[[box]]
name = "cube"
corner = [0, 0, 0]
size = [1, 1, 1]
inside = true
material = "paint"
luminaire = "glow"
[[view]]
name = "inside"
position = [0.2, 0.2, 0.5]
target = [1, 0.8, 0.5]
[[sensor]]
name = "plane"
kind = "points"
positions = [[0.4, 0.5, 0.6], [0.01, 0.3, 0.2]]
normals = [[0, 0, 1], [1, 0, 0]]
[[sensor]]
name = "cylinder"
kind = "points"
positions = [[0.4, 0.5, 0.6]]
response = "cylindrical"
axis = [0, 1, 1]
[[sensor]]
name = "half cylinder"
kind = "grid"
corner = [0.2, 0.2, 0.2]
edge_u = [0.6, 0, 0]
edge_v = [0, 0.6, 0]
spacing = 0.4
response = "semi-cylindrical"
facing = [1, 1, 0]
[[sensor]]
name = "sphere"
kind = "points"
positions = [[0.4, 0.5, 0.6]]
response = "spherical"
[[sensor]]
name = "walls"
kind = "luminance"
eye = [0.5, 0.5, 0.5]
directions = [[1, 0.2, 0.1], [0, 0, -1]]
[[sensor]]
name = "region"
kind = "luminance"
view = "inside"
pixels = [100, 50, 500, 400]
rays = [4, 3]
"""
RISING = "wavelength_nm,reflectance\n380,0.2\n780,0.8\n"
SMALL = ("--element-size", "0.25", "--rays-per-element", "256", "--no-pictures", "--full-metrics", "--replicates", "4")


def table(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def column(rows, name):
    return np.array([float(row[name] or "nan") for row in rows])


def rendered(call, folder, scene, *settings):
    folder.mkdir()
    (folder / "scene.toml").write_text(scene)
    (folder / "wall.csv").write_text(RISING)
    (folder / "plants.csv").write_text("wavelength,weight\n400,1\n700,1\n")
    out = folder / "out"
    outcome = call("render", folder, "-o", out, *settings)
    assert outcome.code == 0, outcome.err
    return out, outcome


@pytest.mark.parametrize(
    ("lamp", "reflectance", "step", "expected"),
    [
        ("D65", '{ file = "wall.csv" }', 5, {"ratio": 1.8963, "cct": 4779, "ra": 97.2, "rf": 97.9}),
        ("FL11", '{ file = "wall.csv" }', 5, {"ratio": 1.9340, "cct": 3287, "ra": 84.7, "rf": 80.7}),
        ("D65", "0.8", 5, {"ratio": 5.0, "der": 1.000}),
        ("FL11", "0.8", 1, {"ratio": 5.0, "der": 0.5621}),
        ("FL11", "0.8", 5, {"ratio": 5.0, "der": 0.5632}),  # bands of 5 nm move lines of mercury
    ],
)
def test_closed_cube(call, tmp_path, lamp, reflectance, step, expected):
    """Every band is M / (1 − ρ) on whatever is read, and radiance that over π."""
    scene = CUBE.format(lamp=lamp, reflectance=reflectance, step=step)
    out, _ = rendered(call, tmp_path / "cube", scene, *SMALL)
    bands = Bands.uniform(380, 780, step)
    shape = band_integral(photometry.illuminant(lamp, bands), bands, "hold").value / bands.width
    rising = band_mean(Spectrum([380, 780], [0.2, 0.8]), bands, "hold").value
    inside = shape / (1.0 - (0.8 if reflectance == "0.8" else rising))
    for name, solid_angle in (("spectra.csv", 1.0), ("radiances.csv", np.pi)):
        for row in table(out / name):
            spectrum = np.array([float(row[f"{centre:.10g}"]) for centre in bands.centre])
            middle = len(bands) // 2
            np.testing.assert_allclose(spectrum / spectrum[middle], inside / inside[middle], rtol=1e-3)
            luminous = spectrum * solid_angle / inside
            np.testing.assert_allclose(luminous, luminous[0], rtol=1e-3)
    rows = table(out / "readings.csv")
    assert len(rows) == 2 + 1 + 4 + 1
    np.testing.assert_allclose(column(rows, "illuminance_lx") / 1000.0, expected["ratio"], rtol=1e-3)
    looked = column(table(out / "luminances.csv"), "luminance_cd_m2")
    np.testing.assert_allclose(looked * np.pi / 1000.0, expected["ratio"], rtol=1e-3)
    if "cct" in expected:
        np.testing.assert_allclose(column(rows, "cct_k"), expected["cct"], atol=5)
        np.testing.assert_allclose(column(rows, "ra"), expected["ra"], atol=0.3)
        np.testing.assert_allclose(column(rows, "rf"), expected["rf"], atol=0.3)
    if "der" in expected:
        np.testing.assert_allclose(column(rows, "melanopic_der"), expected["der"], atol=3e-4)
    if lamp == "D65" and "cct" in expected:
        np.testing.assert_allclose(column(rows, "cie_x"), 0.3511, atol=2e-4)
        np.testing.assert_allclose(column(rows, "cie_y"), 0.3529, atol=2e-4)
        np.testing.assert_allclose(column(rows, "duv"), -0.0017, atol=1e-4)
    np.testing.assert_allclose(column(rows, "y_lx"), column(rows, "illuminance_lx"), rtol=1e-6)


EVERYTHING = (
    ROOM.replace('unit = "m"', 'unit = "m"\nmaintenance_factor = 0.8', 1)
    + """
[luminaires.spot]
spectrum = { lines = [[546, 1.0]] }
luminous_flux_lm = 200
maintenance_factor = 0.5
[[point_source]]
name = "spot"
position = [0.5, 0.5, 2.0]
luminaire = "spot"
[actions.plants]
file = "plants.csv"
[[sensor]]
name = "area"
kind = "grid"
corner = [0, 0, 0.8]
edge_u = [3, 0, 0]
edge_v = [0, 2, 0]
spacing = "EN 12464-1"
border = 0.5
[[sensor]]
name = "eye"
kind = "eye"
positions = [[0.2, 1.0, 1.2], [2.8, 1.0, 1.2]]
gazes = [[1, 0, 0.3], [1, 0, 0]]
glare = true
[[sensor]]
name = "masked"
kind = "eye"
positions = [[0.2, 1.0, 1.2]]
gaze = [1, 0, 0.3]
field = { up = 50, down = 70 }
"""
)


@pytest.fixture
def everything(call, tmp_path):
    return rendered(call, tmp_path / "room", EVERYTHING, *QUICK, "--interval-parts")


def test_extremes_ratios_and_kinds_are_recorded(everything):
    out, outcome = everything
    record = json.loads((out / "run.json").read_text())["sensors"]
    rows = table(out / "readings.csv")
    for name, found in record.items():
        lux = column([row for row in rows if row["sensor"] == name], "illuminance_lx")
        assert found["min_illuminance_lx"] == pytest.approx(lux.min(), rel=1e-6)
        assert found["max_illuminance_lx"] == pytest.approx(lux.max(), rel=1e-6)
        assert found["diversity"] == pytest.approx(lux.min() / lux.max(), rel=1e-6)
        assert found["uniformity"] == pytest.approx(lux.min() / lux.mean(), rel=1e-6)
        assert found["diversity_half_width"] >= 0.0
        assert (found["max_illuminance_half_width_lx"] > 0.0) == (lux.max() > 0.0)
    assert record["masked"]["kind"] == "field of view"
    assert record["area"]["readings"] == 10 * 5  # 2 m × 1 m are left: the width decides, 0.2 m
    assert "min/max" in outcome.out
    assert "masked (field of view)" in outcome.out


def test_maintained_values_are_those_of_dimmed_lamps(everything):
    """Two lamps with factors of their own: the maintained value lies between, with the share of each."""
    out, outcome = everything
    rows = table(out / "readings.csv")
    lux, kept = column(rows, "illuminance_lx"), column(rows, "maintained_illuminance_lx")
    assert ((kept > 0.5 * lux) & (kept < 0.8 * lux)).all()
    assert (column(rows, "maintained_illuminance_half_width_lx") > 0.0).all()
    own = column(table(out / "variants" / "maintained" / "readings.csv"), "illuminance_lx")
    np.testing.assert_allclose(kept, own, rtol=1e-8)
    assert "Maintained illuminance" in outcome.out
    assert "Differences of the variants" not in outcome.out


def test_action_spectra_are_columns(everything):
    """The plants' curve is 1 from 400 to 700 nm, so that it weighs all that the bands in between hold."""
    out, _ = everything
    rows, spectra = table(out / "readings.csv"), table(out / "spectra.csv")
    bands = Bands.uniform(400, 720, 40)
    share = np.clip((np.minimum(bands.upper, 700) - np.maximum(bands.lower, 400)) / bands.width, 0, 1)
    power = np.array([[float(row[f"{c:.10g}"]) for c in bands.centre] for row in spectra]) * bands.width
    np.testing.assert_allclose(column(rows, "plants_w_m2"), power @ share, rtol=0.01)
    assert (column(rows, "plants_half_width_w_m2") > 0.0).all()


def test_field_of_view_takes_light_away(everything):
    out, _ = everything
    rows = table(out / "readings.csv")
    lux = {(row["sensor"], row["index"]): float(row["illuminance_lx"]) for row in rows}
    assert 0.0 < lux["masked", "0"] < lux["eye", "0"]


def test_glare_tables(everything):
    out, outcome = everything
    rows, sources = table(out / "glare.csv"), table(out / "glare_sources.csv")
    assert [row["sensor"] for row in rows] == ["eye", "eye"]
    assert (rows[0]["ugr"] == "") == (rows[0]["blank_because"] != "")
    assert rows[1]["ugr"] == ""
    assert rows[1]["blank_because"] == "no luminaire in view"
    assert {row["object"] for row in sources} == {"lamp"}
    assert "Glare of observers" in outcome.out


def test_why_a_temperature_is_blank(everything):
    out, _ = everything
    rows = table(out / "readings.csv")
    record = json.loads((out / "run.json").read_text())["sensors"]
    for row in rows:
        assert (row["cct_k"] == "") == (row["cct_reason"] != "0")
    told = {name: sum(found["cct_blank"].values()) for name, found in record.items()}
    for name, count in told.items():
        assert count == sum(row["sensor"] == name and row["cct_reason"] != "0" for row in rows)
    assert set().union(*(found["cct_blank"] for found in record.values())) <= set(REASONS)


def test_from_python(tmp_path, device):
    """Looking somewhere, reading a sphere, rating glare; the same numbers as sensors of the file would have."""
    folder = tmp_path / "cube"
    folder.mkdir()
    scene = hradiosity.load_scene(write(folder, CUBE.format(lamp="D65", reflectance="0.8", step=5)))
    options = hradiosity.Options(element_size=0.25, rays_per_element=256, replicates=2, audit=False)
    solution = hradiosity.solve(scene, options, device)
    seen = solution.look([0.5, 0.5, 0.5], [[2, 0.4, 0.2], [0, 0, -3]])
    np.testing.assert_allclose(seen.illuminance, 5000 / np.pi, rtol=1e-3)
    assert seen.kind == "luminance"
    together = solution.look([0.5, 0.5, 0.5], [[2, 0.4, 0.2], [0, 0, -3]], together=True)
    np.testing.assert_allclose(together.illuminance, [seen.illuminance.mean()], rtol=1e-6)
    ball = curved_sensor("ball", np.array([[0.5, 0.4, 0.3]]), "spherical", axis=np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(solution.read_sensor(ball).illuminance, 5000, rtol=2e-3)
    assert hradiosity.rate_glare(solution, device) == {}
    for eye, directions in (([0, 0], [0, 0, 1]), ([0, 0, 0], [0, 0, 0]), ([0, 0, np.inf], [0, 0, 1])):
        with pytest.raises(ValueError, match="direction"):
            solution.look(eye, directions)
