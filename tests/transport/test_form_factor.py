"""Point receivers on the device against Lambert's formula in float64, class by class of difficulty.

Tolerances are what single precision allows. The input is rounded before both sides see it, so that only the formula is
judged. Each class is tried in 40 rotations; `python -m pytest -rP -k accuracy` prints the largest errors.
"""

import numpy as np
import pytest
from device_call import device_call
from scipy.spatial.transform import Rotation

from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.suites.validation.data import form_factors

HEADER = "hr_form_factor.h"
PATCH_CALL = "hr_point_to_patch(x, n, i, m, in_origin, in_edge_u, in_edge_v, in_m, in_kind)"
CATALOGUE = form_factors()


def single(array):
    return np.ascontiguousarray(array, np.float32)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def device_factors(device, x, n, origin, edge_u, edge_v, triangle):
    return device_call(
        device,
        HEADER,
        PATCH_CALL,
        x=single(x),
        n=single(n),
        m=single(unit(np.cross(edge_u, edge_v))),
        origin=single(origin),
        edge_u=single(edge_u),
        edge_v=single(edge_v),
        kind=np.asarray(triangle, np.uint32),
    ).astype(float)


def reference_factors(x, n, origin, edge_u, edge_v, triangle):
    """Lambert in float64, of the rounded input; 0 behind the patch."""
    out = []
    for k in range(len(x)):
        far = [] if triangle[k] else [edge_u[k] + edge_v[k]]
        polygon = origin[k] + np.array([0 * edge_u[k], edge_u[k], *far, edge_v[k]])
        front = np.cross(edge_u[k], edge_v[k]) @ (x[k] - origin[k]) > 0
        out.append(points_to_polygon(x[k][None], unit(n[k])[None], polygon)[0] if front else 0.0)
    return np.array(out)


def both(device, origin, edge_u, edge_v, normal=(0, 0, 1), triangle=False, point=(0, 0, 0), count=40):
    """Factors on the device and in float64 of one arrangement in many rotations."""
    turns = Rotation.random(count, random_state=5).as_matrix()
    arrays = [single(turns @ np.array(v, float)).astype(float) for v in (point, normal, origin, edge_u, edge_v)]
    kinds = np.full(count, triangle)
    return device_factors(device, *arrays, kinds), reference_factors(*arrays, kinds)


def plate(side, distance):
    """Above the point, which lies under no edge of it, be it a parallelogram or a triangle."""
    return (-0.3 * side, -0.3 * side, distance), (0, side, 0), (side, 0, 0)


def wall(distance, bottom=0.0, height=1.0, width=1.0):
    return (distance, -width / 2, bottom), (0, 0, height), (0, width, 0)


# Class: arrangement, largest relative error, largest absolute error (the larger of the two counts).
CLASSES = {
    **{f"plate of side {s:g} at 1": (plate(s, 1), 8e-7, 0) for s in (1, 0.1, 1e-2, 1e-3, 1e-4)},
    **{f"plate of side 1 at {h:g}": (plate(1, h), 8e-7, 0) for h in (0.1, 1e-3, 1e-6)},
    **{f"plate at {d:g} diameters": (plate(1, d * 2**0.5), 1e-6, 0) for d in (1.1, 2.9, 3.1, 15.9, 16.1, 300)},
    **{f"wall, {d:g} from the common edge": (wall(d), 8e-7, 0) for d in (0.1, 1e-3)},
    "wall, 1e-6 from the common edge": (wall(1e-6), 2e-3, 0),
    "sliver of width 1e-1": (((-0.5, -0.05, 1), (0, 0.1, 0), (1, 0, 0)), 2e-6, 0),
    "sliver of width 1e-3": (((-0.5, -5e-4, 1), (0, 1e-3, 0), (1, 0, 0)), 2e-4, 0),
    "sliver of width 1e-6": (((-0.5, -5e-7, 1), (0, 1e-6, 0), (1, 0, 0)), 1e-1, 0),
    **{f"low wall of height {h:g}": (wall(1, height=h), 0, 1e-7) for h in (0.1, 1e-2, 1e-3, 1e-4)},
    **{f"distant low wall of height {h:g}": (wall(2, height=h), 1e-3, 0) for h in (0.1, 1e-2, 1e-3)},
    **{f"wall from {z:g} to {1 + z:g}": (wall(1, bottom=z), 3e-6, 1e-7) for z in (-1e-4, -0.1, -0.5, -0.9, -0.999)},
    "small wall half below": (wall(1, -5e-4, 1e-3, 1e-3), 0, 1e-10),
}


@pytest.mark.parametrize("triangle", [False, True], ids=["parallelogram", "triangle"])
@pytest.mark.parametrize("name", CLASSES)
def test_accuracy_of_each_class(device, name, triangle):
    arrangement, relative, absolute = CLASSES[name]
    found, expected = both(device, *arrangement, triangle=triangle)
    error = np.abs(found - expected)
    print(f"{name:40s} F {expected.mean():8.1e} relative {(error / expected).max():7.1e} absolute {error.max():7.1e}")
    assert (error <= np.maximum(relative * expected, absolute)).all()


@pytest.mark.parametrize("normal", [(0.6, 0, 0.8), (0.8, -0.36, 0.48), (0, -0.96, -0.28)])
def test_tilted_receivers(device, normal):
    for arrangement in (plate(1, 0.3), plate(3, 0.3), plate(0.5, 2), wall(0.2, bottom=-0.3)):
        found, expected = both(device, *arrangement, normal=normal)
        np.testing.assert_allclose(found, expected, rtol=3e-6, atol=1e-7)


def test_world_offset_costs_only_what_the_input_lost(device):
    """Coordinates about 1000: the difference of patch and point is exact, and so is the rest."""
    found, expected = both(device, (1000 - 0.5, 999.5, 1001), (0, 1, 0), (1, 0, 0), point=(1000, 1000, 1000))
    np.testing.assert_allclose(found, expected, rtol=4e-7)


@pytest.mark.parametrize("triangle", [False, True])
def test_behind_is_exactly_zero(device, triangle):
    """Points behind the patch, and patches below the point's horizon."""
    for arrangement, normal in (
        (((-0.5, -0.5, 1), (1, 0, 0), (0, 1, 0)), (0, 0, 1)),
        (plate(1, 1), (0, 0, -1)),
        (wall(1, bottom=-1.2), (0, 0, 1)),
    ):
        assert (both(device, *arrangement, normal=normal, triangle=triangle)[0] == 0).all()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (0.6, 0, 0.8), (1, 0, 0)])
@pytest.mark.parametrize("offset", [(0, 0, 0), (3, -5, 2)])
def test_a_patch_gives_nothing_to_points_on_it(device, normal, offset):
    """A meter laid on a luminous panel reads 0 from it in every rotation, whatever way the rounding goes."""
    corner = np.array([-0.5, -0.5, 0.0]) + offset
    for edges in (((0, 1, 0), (1, 0, 0)), ((1, 0, 0), (0, 1, 0))):
        found = both(device, corner, *edges, normal=normal, point=offset, count=200)[0]
        assert (found == 0).all()


def test_points_in_the_plane_beside_a_patch_receive_nothing(device):
    for normal in ((0, 0, 1), (0.6, 0, 0.8), (1, 0, 0)):
        assert both(device, (1, -0.5, 0), (0, 1, 0), (1, 0, 0), normal=normal, count=200)[0].max() < 1e-8


@pytest.mark.parametrize("entry", [e for e in CATALOGUE if e["kind"] == "point-polygon"], ids=lambda e: e["id"])
def test_catalogue(device, entry):
    point, normal, polygon = (np.array(entry[key], float) for key in ("point", "normal", "poly2"))
    edges = polygon[1] - polygon[0], polygon[3] - polygon[0]
    if np.cross(*edges) @ (point - polygon[0]) < 0:
        edges = edges[::-1]
    found = device_factors(device, *(a[None] for a in (point, unit(normal), polygon[0], *edges)), [False])[0]
    assert found == pytest.approx(float(entry["F12"]), rel=1e-6, abs=1e-7)


def test_any_convex_polygon(device):
    """hr_polygon_factor on random pentagons, some of them cut by the horizon or all below it."""
    rng = np.random.default_rng(8)
    n = 2000
    angle = np.sort(rng.uniform(0, 2 * np.pi, (n, 5)), axis=1)
    flat = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    turn = Rotation.random(n, random_state=9).as_matrix()
    corners = single(np.einsum("nij,nkj->nki", turn, flat) + rng.normal(size=(n, 1, 3)) * 1.5).astype(float)
    normals = single(unit(rng.normal(size=(n, 3)))).astype(float)
    # The corners go into a private array: a statement expression makes one inside the helper's single expression.
    load = "float3 r[5]; for (uint k = 0; k < 5; ++k) r[k] = vload3(5 * i + k, in_corners);"
    call = f"({{ {load} hr_polygon_factor(n, r, 5); }})"
    found = device_call(device, HEADER, call, n=single(normals), corners=single(corners))
    expected = np.array([points_to_polygon(np.zeros((1, 3)), unit(n)[None], p)[0] for n, p in zip(normals, corners)])
    assert 0.2 < (expected == 0).mean() < 0.5
    # A point within 1e-3 of an edge may lose more; 1 in 1000 here.
    error = np.abs(found - expected)
    assert np.quantile(error, 0.99) < 2e-7 and error.max() < 5e-5


def test_atan2(device):
    rng = np.random.default_rng(10)
    decades = 10.0 ** rng.uniform(-30, 10, (2, 20000)) * [[1], [-1]]
    y = np.concatenate([np.abs(rng.normal(size=20000)), decades[0], decades[0], np.zeros(11), [0, 1, 1]])
    x = np.concatenate([rng.normal(size=20000), decades[1], -decades[1], np.linspace(-1, 1, 11), [0, 0, 1e-30]])
    y, x = single(y), single(x)
    expected = np.arctan2(y.astype(float), x.astype(float))
    found = device_call(device, HEADER, "hr_atan2_upper(y, x)", y=y, x=x)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=3e-7)


@pytest.mark.parametrize("triangle", [0, 1])
@pytest.mark.parametrize("order", [2, 3, 4])
def test_area_rule_converges_with_its_order(device, order, triangle):
    """Gauss points of order k a direction: error bounds seen at two diameters, where the edge form is exact to 1e-6."""
    origin, edge_u, edge_v = (np.array(v, float) for v in plate(1, 2 * 2**0.5))
    polygon = origin + np.array([0 * edge_u, edge_u, *([] if triangle else [edge_u + edge_v]), edge_v])
    expected = points_to_polygon(np.zeros((1, 3)), np.array([[0.0, 0.6, 0.8]]), polygon)[0]
    found = device_call(
        device,
        HEADER,
        "hr_area_rule(n, r, u, v, m, triangle, order)",
        n=single([[0, 0.6, 0.8]]),
        m=single([[0, 0, -1]]),
        r=single([origin]),
        u=single([edge_u]),
        v=single([edge_v]),
        triangle=np.array([triangle], np.uint32),
        order=np.array([order], np.uint32),
    )[0]
    assert found == pytest.approx(expected, rel={2: 3e-3, 3: 1e-4, 4: 2e-6}[order])
