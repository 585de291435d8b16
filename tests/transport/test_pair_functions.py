"""Device functions behind the form factors of polygon pairs, against plain float64 and adaptive quadrature."""

import numpy as np
import pytest
from device_call import device_call
from polygon_shapes import POINTS, SQUARE, corners, facing_square
from scipy.spatial.transform import Rotation

from hradiosity import form_factor
from hradiosity.reference.form_factors import polygon_pair
from hradiosity.reference.pair_factors import area_pair, chord_projection, contour_pair, edge_pair
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.transport.form_factor.polygons import polygon_set, stack_corners
from hradiosity.transport.form_factor.quadrature import double_exponential, gauss, surface_rule

EDGES = {
    "skew": ((0, 0, 0), (1, 0, 0), (0.2, 0.3, 0.5), (0.4, 1.3, 0.9)),
    "skew, close": ((0, 0, 0), (1, 0, 0), (0.5, -0.5, 1e-3), (0.6, 0.5, 1e-3)),
    "crossing": ((0, 0, 0), (1, 0, 0), (0.3, -0.5, 0), (0.6, 0.5, 0)),
    "common corner, 60 degrees": ((0, 0, 0), (1, 0, 0), (0, 0, 0), (0.5, 0.75**0.5, 0)),
    "common corner, 1 degree": ((0, 0, 0), (1, 0, 0), (0, 0, 0), (0.99984770, 0.01745241, 0)),
    "parallel": ((0, 0, 0), (1, 0, 0), (0.3, 0.2, 0.1), (2.3, 0.2, 0.1)),
    "antiparallel, close": ((0, 0, 0), (1, 0, 0), (1, 1e-2, 0), (0, 1e-2, 0)),
    "one line, overlapping": ((0, 0, 0), (1, 0, 0), (0.4, 0, 0), (1.9, 0, 0)),
    "one line, apart": ((0, 0, 0), (1, 0, 0), (3.0, 0, 0), (1.5, 0, 0)),
    "long and short": ((0, 0, 0), (1e-4, 0, 0), (-5, 1e-5, 0), (5, 3.0, 2.0)),
    "far": ((0, 0, 0), (1, 0, 0), (20, 3, 1), (20.5, 4, 2)),
}
EDGE_CALL = (
    "({ const hr_rules rules = {in_node, in_weight, 8, 4, 26, 1e-12, 1.0, 1e-6}; double error, magnitude = 0.0;"
    " const double sum = hr_edge_pair(a, u, la, b, v, lb, rules, &error, &magnitude); (double2)(sum, error); })"
)


def edge_sums(device, edges):
    """hr_edge_pair and its error estimate for edges (n, 4, 3), n at most 38."""
    rules = [gauss(16), gauss(8), double_exponential(0.125, 3.125)]
    node, weight = (np.concatenate([r[k][:n] for r, n in zip(rules, (8, 4, 26))]) for k in (0, 1))
    rows = np.resize(edges, (len(node), 4, 3))
    u, v = rows[:, 1] - rows[:, 0], rows[:, 3] - rows[:, 2]
    la, lb = (np.linalg.norm(edge, axis=1) for edge in (u, v))
    arrays = {"a": rows[:, 0], "u": u / la[:, None], "la": la, "b": rows[:, 2], "v": v / lb[:, None], "lb": lb}
    found = device_call(device, "hr_contour.h", EDGE_CALL, "double2", node=node, weight=weight, **arrays)
    return found[: len(edges)].T


def test_edge_pairs(device):
    edges = np.array(list(EDGES.values()), float)
    value, error = edge_sums(device, edges)
    for name, rows, found in zip(EDGES, edges, value):
        assert found == pytest.approx(edge_pair(*rows), rel=1e-10), name
    assert (error <= 1e-9 * np.abs(value)).all()


def test_an_edge_with_itself(device):
    """L² (ln L − 3/2)."""
    length = np.array([0.5, 1.0, 3.0])
    edges = np.zeros((3, 4, 3))
    edges[:, [1, 3], 0] = length[:, None]
    np.testing.assert_allclose(edge_sums(device, edges)[0], length**2 * (np.log(length) - 1.5), rtol=1e-14)


def test_edge_pairs_do_not_depend_on_order_or_direction(device):
    rng = np.random.default_rng(4)
    edges = rng.normal(size=(30, 4, 3))
    value = edge_sums(device, edges)[0]
    for order in ([2, 3, 0, 1], [1, 0, 2, 3], [1, 0, 3, 2]):
        np.testing.assert_allclose(edge_sums(device, edges[:, order])[0], value, rtol=1e-9, atol=1e-10)


def lambert(device, points, normals, polygons, halvings=255):
    """hr_lambert for each point and quadrilateral (n, 4, 3)."""
    call = f"({{ const double3 r[4] = {{c0, c1, c2, c3}}; hr_lambert(n, r, 4, {halvings}u); }})"
    rows = {f"c{k}": polygons[:, k] - points for k in range(4)}
    return device_call(device, "hr_lambert.h", call, "double", n=normals, **rows)


def test_points_of_the_catalogue(device):
    points, polygons = (np.array([corners(e, key) for e in POINTS]) for key in ("point", "poly2"))
    normals = np.array([corners(e, "normal") for e in POINTS])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    exact = np.array([float(e["F12"]) for e in POINTS])
    np.testing.assert_allclose(lambert(device, points, normals, polygons), exact, rtol=1e-12, atol=1e-16)


def test_projections_against_lambert_in_float64(device):
    """Random squares, about half of them cut by the horizon, some with edges in it."""
    rng = np.random.default_rng(6)
    turn = Rotation.random(500, random_state=3).as_matrix()
    polygons = np.einsum("nij,kj->nki", turn, SQUARE - 0.5) + rng.normal(size=(500, 1, 3))
    normals = Rotation.random(500, random_state=5).as_matrix()[:, 2].copy()
    normals[:50] = np.cross(polygons[:50, 0], polygons[:50, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = lambert(device, np.zeros((500, 3)), normals, polygons)
    exact = [points_to_polygon(np.zeros((1, 3)), n[None], p)[0] for n, p in zip(normals, polygons)]
    np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("halvings", [0, 1, 2, 5])
def test_chords_are_a_polygon_on_the_hemisphere(device, halvings):
    """The half-angle recurrence against corners that are set on the hemisphere one by one."""
    polygon = np.array([[0.2, -0.5, 0.3], [1.5, 0.1, 0.4], [1.0, 1.0, 1.5], [-0.6, 0.4, 1.2]])
    normal = np.array([0.0, 0.0, 1.0])
    found = lambert(device, np.zeros((1, 3)), normal[None], polygon[None], halvings)[0]
    assert found == pytest.approx(chord_projection(np.zeros(3), normal, polygon, 2**halvings), rel=1e-13)


def some_pairs(n, seed, *, apart):
    """Triangles and quadrilaterals of random turns at a distance [radii]."""
    rng = np.random.default_rng(seed)
    shapes = [SQUARE - 0.5, SQUARE[:3] - 0.4, np.array([[-0.7, -0.3, 0], [0.5, -0.5, 0], [0.6, 0.4, 0], [0.0, 0.6, 0]])]
    for _ in range(n):
        turns = Rotation.random(2, random_state=rng).as_matrix()
        a, b = (shapes[k] @ turn.T for k, turn in zip(rng.integers(3, size=2), turns))
        direction = rng.normal(size=3)
        yield a, b + apart * direction / np.linalg.norm(direction)


@pytest.mark.parametrize("apart", [1.2, 2.0, 6.0])
def test_contour_against_points_of_lambert(device, apart):
    """Horizons cut many of these pairs."""
    pairs = list(some_pairs(40, 8, apart=apart))
    found = form_factor(*zip(*pairs), method="contour", device=device)
    exact = np.zeros(40)
    for i, pair in enumerate(pairs):
        if found.value[i] > 0.0:
            exact[i] = polygon_pair(*pair, tolerance=1e-3)
    assert (exact > 0.0).sum() > 3
    np.testing.assert_allclose(found.value, exact, rtol=1e-3, atol=1e-7)


def test_twins_of_far_pairs_agree(device):
    """Double contour, double area and the device's ladder: three roads to one number."""
    a, b = SQUARE - 0.5, (SQUARE[::-1] - 0.5) @ Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix().T + [1.0, 2.0, 6.0]
    by_area, by_contour = area_pair(a, b, 6), contour_pair(a, b, 12)
    assert by_area == pytest.approx(by_contour, rel=1e-10)
    found = form_factor(a, b, tolerance=1e-8, device=device)
    assert found.method == "contour"
    assert found.value == pytest.approx(by_area, rel=1e-10)
    ladder = form_factor(a, b, tolerance=1e-3, device=device)
    assert ladder.method == "gauss"
    assert abs(ladder.value - by_area) <= ladder.error < 1e-3 * by_area


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4])
def test_ladder_keeps_its_bound(device, tolerance):
    """Pairs from touching spheres to 30 radii: what the ladder takes, it takes within the error that it states."""
    pairs = [pair for k, d in enumerate(np.geomspace(1.5, 30.0, 8)) for pair in some_pairs(200, k, apart=d)]
    found = form_factor(*zip(*pairs), tolerance=tolerance, device=device)
    exact = form_factor(*zip(*pairs), method="contour", tolerance=1e-10, device=device)
    taken = found.method == "gauss"
    assert taken.sum() > 20
    assert (np.abs(found.value - exact.value) <= found.error + exact.error)[taken].all()
    assert (found.error <= tolerance * found.value)[taken].all()


def test_surface_rules_integrate_polynomials():
    """Area, first of convex polygons of 3 to 7 corners and second moments by order 2."""
    angle = [np.sort(np.random.default_rng(n).uniform(0, 2 * np.pi, n)) for n in (3, 4, 5, 6, 7)]
    rings = [np.stack([np.cos(t), np.sin(t), 0 * t], axis=1) for t in angle]
    polygons = polygon_set(*stack_corners(rings, "ring"), [str(k) for k in range(5)])
    rule, fine = surface_rule(polygons, 2).point, surface_rule(polygons, 8).point
    np.testing.assert_allclose(rule[:, 3].sum(axis=1), polygons.area, rtol=1e-13)
    moment = np.einsum("ndp,np->nd", rule[:, :3], rule[:, 3]) / polygons.area[:, None]
    np.testing.assert_allclose(moment, polygons.centre, atol=1e-13)
    second, exact = (np.einsum("ndp,np->nd", r[:, :3] ** 2, r[:, 3]) for r in (rule, fine))
    np.testing.assert_allclose(second, exact, atol=1e-13)


def test_double_exponential_rule():
    """Integral of x^(-1/2) on [0, 1] is 2; of ln x, -1."""
    node, weight = double_exponential(0.125, 3.125)
    assert weight.sum() == pytest.approx(0.5, rel=1e-15)
    for f, exact in ((lambda x: np.log(x), -1.0), (lambda x: x * np.log(x), -0.25)):
        assert (weight * (f(node) + f(1.0 - node))).sum() == pytest.approx(exact, rel=1e-11)
    assert 2.0 * (2.0 * weight[::2]).sum() == pytest.approx(1.0, rel=1e-10)


def test_facing_squares_of_the_twin():
    assert contour_pair(SQUARE, facing_square(1.0), 16) == pytest.approx(0.19982489569838738, rel=1e-12)
