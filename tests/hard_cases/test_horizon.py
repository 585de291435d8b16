"""Hard cases 8 to 11: what lies in a plane, on an edge, across the horizon or below it."""

import numpy as np
import pytest
from direct_light import FEW, black_plates, factors_read, mean_read
from polygon_shapes import PAIRS, POINTS, SQUARE, corners, facing_square, hinged_square
from scipy.spatial.transform import Rotation

from hradiosity import form_factor, solve
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene

METHODS = (("auto", 1e-4), ("contour", 1e-9))
WALL = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], float)
"""Stands on the floor z = 0 and shines towards +x."""
SIDEWAYS = ((0, 0, 1), (1, 0, 0), (-1, 0, 0), (0.6, 0, 0.8), (-1, 0, 0.1), (-0.6, 0.64, -0.48), (0, 0, -1))


@pytest.mark.parametrize("place", [(0.5, 0.5, 0), (0.25, 0.75, 0), (1.5, 0.5, 0), (-3.0, 0.1, 0)], ids="08-{}".format)
def test_case_08_points_in_the_plane_of_a_plate(device, place):
    """On the plate and beside it, whatever they face: exactly nothing; also when the whole scene is turned."""
    turn = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    for rotation in (np.eye(3), turn):
        found = factors_read(
            device, [SQUARE @ rotation.T], np.tile(place, (len(SIDEWAYS), 1)) @ rotation.T, SIDEWAYS @ rotation.T
        )
        assert (found == 0.0).all()


def test_case_08_small_plates_in_the_plane_of_another(device):
    speck = 1e-6 * SQUARE + [0.5, 0.5, 0.0]
    standing = np.array([[0.5, 0.5, 0], [0.5, 0.5 + 1e-6, 0], [0.5, 0.5 + 1e-6, -1e-6], [0.5, 0.5, -1e-6]])
    for method, _ in METHODS:
        for plate in (speck, speck + [1, 0, 0], standing, standing[::-1]):
            assert form_factor(plate, SQUARE, method=method, device=device).value == 0.0


@pytest.mark.parametrize(
    ("along", "up", "share"), [(0.5, 0.0, 0.5), (0.0, 0.0, 0.25), (1.0, 0.0, 0.25), (0.0, 0.5, 0.25), (0.5, 1.0, 0.0)]
)
@pytest.mark.parametrize("exponent", [-6, -5, -3], ids="09-1e{}".format)
def test_case_09_points_next_to_an_edge(device, exponent, along, up, share):
    """Facing up: half the sky at an edge, a quarter at its ends; the exact values differ from those by the distance."""
    point = np.array([[10.0**exponent, along, up]])
    found = factors_read(device, [WALL], point, (0, 0, 1))[0]
    assert found == pytest.approx(points_to_polygon(point, np.array([[0, 0, 1.0]]), WALL)[0], rel=1e-4, abs=1e-7)
    assert found == pytest.approx(share, abs=10.0**exponent)


def test_case_09_points_on_an_edge_and_a_corner(device):
    """Exactly there a plate gives its limit or, by convention, nothing; the check warns of such places."""
    on_wall = np.array([[0, 0.5, 0], [0, 0, 0], [0, 1, 0], [0, 0, 0.5], [0, 0.5, 1]])
    scene = black_plates([WALL, SQUARE], on_wall, (0, 0, 1))
    found = check_scene(scene, build_bvh(device, scene.patches))
    assert [finding.severity for finding in found if finding.kind == "sensor-in-edge"] == ["warning"]
    for plates in ([WALL], [WALL, SQUARE]):
        found = factors_read(device, plates, on_wall, (0, 0, 1))
        for value, limit in zip(found, (0.5, 0.25, 0.25, 0.25, 0.0)):
            assert value == 0.0 or value == pytest.approx(limit, abs=1e-3)


@pytest.mark.parametrize("name", ["H01", "H03", "H05", "G09"], ids="10-{}".format)
def test_case_10_polygons_cut_by_a_horizon(device, name):
    entry = next(entry for entry in PAIRS if entry["id"] == name)
    a, b, exact = corners(entry, "poly1"), corners(entry, "poly2"), float(entry["F12"])
    for method, tolerance in METHODS:
        assert form_factor(a, b, method=method, device=device).value == pytest.approx(exact, rel=tolerance)
    if len(a) == 4:
        middle = 0.5 * (a[[1, 2]] + a[[0, 3]])
        halves = np.array([[a[0], middle[0], middle[1], a[3]], [middle[0], a[1], a[2], middle[1]]])
        assert np.mean([mean_read(device, half, b)[0] for half in halves]) == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("entry", POINTS, ids=lambda entry: f"10-{entry['id']}")
def test_case_10_points_of_the_catalogue(device, entry):
    """Lit from the side on which the point lies."""
    point, normal, plate = (corners(entry, key) for key in ("point", "normal", "poly2"))
    if np.cross(plate[1] - plate[0], plate[3] - plate[0]) @ (point - plate[0]) < 0:
        plate = plate[::-1]
    found = factors_read(device, [plate], point, normal / np.linalg.norm(normal))[0]
    assert found == pytest.approx(float(entry["F12"]), rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("corners_of_it", [3, 4], ids=["10-triangle", "10-parallelogram"])
def test_case_10_any_horizon(device, corners_of_it):
    """2000 places and directions around a plate: the part above each horizon by Lambert's formula in float64."""
    rng = np.random.default_rng(10)
    plate = hinged_square(70.0)[:corners_of_it] @ Rotation.random(random_state=1).as_matrix().T
    points = rng.uniform(-2, 2, (2000, 3))
    normals = rng.normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = np.cross(plate[1] - plate[0], plate[-1] - plate[0])
    exact = np.where((points - plate[0]) @ across > 0.0, points_to_polygon(points, normals, plate), 0.0)
    height = np.einsum("nkd,nd->nk", plate[None] - points[:, None], normals)
    assert ((height.min(axis=1) < 0.0) & (height.max(axis=1) > 0.0) & (exact > 0.0)).sum() > 200
    found = factors_read(device, [plate], points, normals)
    np.testing.assert_allclose(found, exact, rtol=1e-5, atol=2e-7)
    assert (found[exact == 0.0] == 0.0).all()


def test_case_11_wholly_behind_is_exactly_nothing(device):
    """Also with something in between, for which a ray would have to be traced: the plan needs none."""
    card = 0.2 * SQUARE + [0.4, 0.4, 0.5]
    below = np.array([[0.5, 0.5, 0.0], [0.1, 0.9, 0.0], [0.5, 0.5, 2.0]])
    scene = black_plates([facing_square(1.0), card], below, [(0, 0, -1), (0, -0.6, -0.8), (0, 0, -1)])
    solution = solve(scene, FEW, device)
    readings = solution.readings["s0"]
    assert (readings.irradiance == 0.0).all() and (readings.half_width == 0.0).all()
    (occlusion,) = (effect for effect in solution.plan.effects if effect.name == "occlusion")
    assert not occlusion.needed and "proved by shafts" in occlusion.because
    for method, _ in METHODS:
        for pair in ((SQUARE[::-1], facing_square(1.0)), (SQUARE, SQUARE + [0, 0, 1.0]), (SQUARE, WALL - [0, 0, 1.5])):
            found = form_factor(*pair, occluders=card, method=method, device=device)
            assert (found.value, found.error, found.visibility, found.method) == (0.0, 0.0, 1.0, "none")
