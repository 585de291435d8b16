"""Hard cases 1 to 7: surfaces that touch, nearly touch or lie in one plane."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import CASES, box_faces, box_room, expected, patches_of
from check_rooms import SOUND, findings, grave, of_kind, rectangle
from direct_light import mean_read, normal_of, points_on
from hinges import hinge_factor
from polygon_shapes import PAIRS, SQUARE, box_quads, corners, facing_square, hinged_square
from rooms import SceneBuilder

from hradiosity import Options, form_factor, form_factor_matrix, solve
from hradiosity.model.scene import Sensor
from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles

CATALOGUE = {entry["id"]: entry for entry in PAIRS}
METHODS = ("auto", "contour")
CLOSING = (90.0, 30.0, 5.0, 1.0, 0.1)
OPENING = (175.0, 178.0, 179.0, 179.9, 179.99)


def test_case_01_faces_of_a_unit_cube(device):
    for method, digits in (("auto", 1e-5), ("contour", 1e-12)):
        found = form_factor_matrix(box_quads(1), method=method, device=device).value
        for row, opposite in enumerate((1, 0, 3, 2, 5, 4)):
            exact = np.full(6, perpendicular_rectangles(1, 1, 1))
            exact[[row, opposite]] = 0.0, parallel_rectangles(1, 1, 1)
            np.testing.assert_allclose(found[row], exact, rtol=digits)
        np.testing.assert_allclose(found.sum(axis=1), 1.0, rtol=digits)
    assert float(CATALOGUE["P01"]["F12"]) == pytest.approx(0.19982490, abs=5e-9)
    assert float(CATALOGUE["Q01"]["F12"]) == pytest.approx(0.20004378, abs=5e-9)


def test_case_01_faces_of_a_unit_cube_read(device):
    opposite, _ = mean_read(device, SQUARE, facing_square(1.0))
    adjacent, _ = mean_read(device, SQUARE, hinged_square(90.0))
    assert opposite == pytest.approx(float(CATALOGUE["P01"]["F12"]), rel=1e-5)
    assert adjacent == pytest.approx(float(CATALOGUE["Q01"]["F12"]), rel=1e-5)
    assert opposite + 4.0 * adjacent == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize(("name", "degrees"), [("I02", 2), ("I06", 30), ("I10", 90), ("I14", 150), ("I17", 178)])
def test_the_reference_for_hinges_agrees_with_the_catalogue(name, degrees):
    assert hinge_factor(degrees) == pytest.approx(float(CATALOGUE[name]["F12"]), rel=1e-12, abs=1e-16)


@pytest.mark.parametrize("degrees", CLOSING, ids=lambda degrees: f"02-{degrees:g}deg")
def test_case_02_hinges_close(device, degrees):
    exact = hinge_factor(degrees)
    for method, tolerance in (("auto", 1e-4), ("contour", 1e-8)):
        found = form_factor(SQUARE, hinged_square(degrees), method=method, device=device)
        assert found.value == pytest.approx(exact, rel=tolerance)
    mean, readings = mean_read(device, SQUARE, hinged_square(degrees))
    assert mean == pytest.approx(exact, abs=1e-3)
    assert readings.min() >= 0.0 and readings.max() <= 1.0


@pytest.mark.parametrize("method", METHODS)
def test_case_02_and_03_stated_errors_hold_at_all_angles(device, method):
    """From 0.01 to 179.99 degrees; all but accidents, where half the points are right by chance."""
    angle = np.concatenate([np.geomspace(0.01, 90.0, 120), 180.0 - np.geomspace(0.01, 90.0, 120)[:-1]])
    exact = np.array([hinge_factor(t) for t in angle])
    for tolerance in (None, 1e-2, 1e-6, 1e-12):
        squares = [hinged_square(t) for t in angle]
        found = form_factor(SQUARE, squares, method=method, tolerance=tolerance, device=device)
        assert (np.abs(found.value - exact) <= found.error + 2e-16).mean() >= 0.99
    np.testing.assert_allclose(found.value[angle < 120.0], exact[angle < 120.0], rtol=1e-13)


def test_case_02_hinges_close_without_a_step(device):
    """Opening angles from 0.001 to 90 degrees: F falls from 1."""
    angle = np.geomspace(1e-3, 90.0, 60)
    for method in METHODS:
        found = form_factor(SQUARE, [hinged_square(t) for t in angle], method=method, device=device).value
        assert (np.diff(found) < 0.0).all()
        assert 1.0 - 2e-5 < found[0] < 1.0


@pytest.mark.parametrize("degrees", OPENING, ids=lambda degrees: f"03-{degrees:g}deg")
def test_case_03_nearly_coplanar_hinges(device, degrees):
    exact = hinge_factor(degrees)
    for method in METHODS:
        found = form_factor(SQUARE, hinged_square(degrees), method=method, device=device)
        assert found.value == pytest.approx(exact, rel=1e-4)
    mean, readings = mean_read(device, SQUARE, hinged_square(degrees), crowded=False)
    assert readings.min() >= 0.0
    # Single precision leaves 1e-8 of the exitance, which is more than the light itself above 179.9 degrees.
    assert mean == pytest.approx(exact, rel=1e-2, abs=1e-8)


def test_case_03_flat_hinge(device):
    for method in METHODS:
        assert form_factor(SQUARE, hinged_square(180.0), method=method, device=device).value == 0.0
        assert form_factor(SQUARE, hinged_square(180.001), method=method, device=device).value == 0.0
    _, readings = mean_read(device, SQUARE, SQUARE - [1, 0, 0])
    assert not readings.any()


@pytest.mark.parametrize("name", ["R05", "G09"], ids="04-{}".format)
def test_case_04_one_common_vertex(device, name):
    a, b = (corners(CATALOGUE[name], key) for key in ("poly1", "poly2"))
    assert len({*map(tuple, a)} & {*map(tuple, b)}) == 1
    exact = float(CATALOGUE[name]["F12"])
    for method, tolerance in (("auto", 1e-4), ("contour", 1e-9)):
        assert form_factor(a, b, method=method, device=device).value == pytest.approx(exact, rel=tolerance)
    if len(a) == 4:
        mean, readings = mean_read(device, a, b)
        assert mean == pytest.approx(exact, rel=1e-5)
        assert np.isfinite(readings).all()


@pytest.mark.parametrize("shift", [(0.3, 0.2, 0.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0)], ids="05-{}".format)
def test_case_05_overlapping_coplanar_patches(device, shift):
    """Each sees nothing of the other, although both shine and reflect."""
    other = SQUARE + shift
    for method in METHODS:
        assert form_factor(SQUARE, other, method=method, device=device).value == 0.0
    b = SceneBuilder()
    white = b.material(0.9)
    for quad in (SQUARE, other):
        b.patch(quad[0], quad[1] - quad[0], quad[3] - quad[0], white)
    b.lamp(0, 1.0)
    points, _ = points_on(other, 4)
    b.sensor(points, (0, 0, 1))
    solution = solve(b.scene(), Options(elements=100, gather_samples=64), device)
    assert not solution.readings["s0"].irradiance.any()
    assert not solution.surfaces.irradiance.any()


def test_case_05_overlaps_are_named(device, tmp_path):
    rug = rectangle("rug", (1, 1, 0), (1, 0, 0), (0, 2, 0))
    (finding,) = of_kind(findings(device, tmp_path, SOUND + rug), "coincident-surfaces")
    assert "'rug' and 'room' lie in one plane and face the same way: 2 m²" in finding.message
    twin = rug.replace('"rug"', '"the rug again"').replace("1, 1, 0", "1, 1, 0.5")
    lifted = rug.replace("1, 1, 0", "1, 1, 0.5")
    (finding,) = of_kind(findings(device, tmp_path, SOUND + lifted + twin), "duplicate-faces")
    assert "'rug' and 'the rug again' are the same faces twice: 2 m²" in finding.message


def beside_a_dark_room(case):
    """A room whose light is known, and its like beyond a wall that is two faces back to back, without lamp."""
    room = box_room(case)
    x, y, z = case["dims"]
    rows = np.concatenate([box_faces(x, y, z)] * 2)
    rows[6:, 0, 0] += x
    places = [(x + 1e-3, y / 2, z / 2), (1.5 * x, 0.1, 0.1), (2 * x, y / 2, z / 2), (x + 1e-4, 1e-3, 1e-3)]
    dark = Sensor("dark", np.array(places), np.array([(1.0, 0, 0), (0, 1, 0), (-1, 0, 0), (0, 0, 1)]))
    return replace(room, patches=patches_of(rows, [*range(6)] * 2), sensors=(*room.sensors, dark))


def test_case_06_thin_sheet(device):
    """The light of the lit room as if it were alone, within 2 % for 1024 paths; exactly none beyond the sheet."""
    for method in METHODS:
        found = form_factor(SQUARE, SQUARE[::-1], method=method, device=device)
        assert found.value == 0.0 and found.error == 0.0
    case = CASES["cube-iso-rho0.50"]
    options = Options(elements=2000, gather_samples=1024, light_samples=16, rays_per_element=128)
    solution = solve(beside_a_dark_room(case), options, device)
    lit, dark = solution.readings.values()
    assert np.abs(lit.illuminance / expected(case) - 1.0).max() < 0.02
    assert not dark.irradiance.any()
    assert np.isfinite(solution.surfaces.irradiance).all()


def test_case_06_thin_sheets_that_differ_are_named(device, tmp_path):
    sheet = rectangle("front", (1, 1, 1), (1, 0, 0), (0, 1, 0))
    unlike = rectangle("back", (1, 1, 1), (0, 1, 0), (1, 0, 0), material="other")
    (finding,) = of_kind(findings(device, tmp_path, SOUND + sheet + unlike), "coincident-back-to-back")
    assert "'front' and 'back' lie in one plane back to back and differ: 1 m²" in finding.message
    assert grave(findings(device, tmp_path, SOUND + sheet + unlike.replace("other", "paint"))) == []


@pytest.mark.parametrize("exponent", range(1, 7), ids="07-1e-{}".format)
def test_case_07_plates_nearly_touch(device, exponent):
    """What the opposite plate does not get, four strips as high as the gap do: a closed form that keeps digits."""
    gap = 10.0**-exponent
    missing = 4.0 * perpendicular_rectangles(1.0, 1.0, gap)
    assert 1.0 - missing == pytest.approx(parallel_rectangles(1, 1, gap), rel=1e-9)
    for method in METHODS:
        found = form_factor(SQUARE, facing_square(gap), method=method, device=device)
        assert 1.0 - found.value == pytest.approx(missing, rel=1e-8)
        assert found.value < 1.0
    mean, readings = mean_read(device, SQUARE, facing_square(gap))
    assert mean == pytest.approx(1.0 - missing, rel=3e-5)
    assert readings.max() <= 1.0


def test_case_07_light_between_plates_that_nearly_touch(device):
    """In the middle both see nothing but each other: E₁ = ρE₂, E₂ = M + ρE₁ between plates that lose nothing there."""
    b = SceneBuilder()
    grey = b.material(0.6)
    for quad in (SQUARE, facing_square(1e-4)):
        b.patch(quad[0], quad[1] - quad[0], quad[3] - quad[0], grey)
    b.lamp(1, 1.0)
    b.sensor([(0.5, 0.5, 0.0), (0.5, 0.5, 1e-4)], [(0, 0, 1), (0, 0, -1)])
    readings = solve(b.scene(), Options(elements=400, gather_samples=4096), device).readings["s0"].irradiance[:, 0]
    np.testing.assert_allclose(readings, np.array([1.0, 0.6]) / (1.0 - 0.36), rtol=2e-3)


def test_the_points_of_the_readings_integrate_what_they_should():
    """The mean of u² v over a tilted quad, crowded points and plain ones; its normal."""
    quad = hinged_square(120.0)
    for crowded in (True, False):
        points, weight = points_on(quad, 12, crowded=crowded)
        u, v = points[:, 1], points[:, 2] / quad[3, 2]
        assert weight @ (u**2 * v) == pytest.approx(1 / 6, rel=1e-12)
    assert normal_of(quad) == pytest.approx([np.sin(np.radians(120)), 0, -np.cos(np.radians(120))])
