"""The float64 twins against a catalogue of form factors that was computed at 30 digits by other methods."""

import numpy as np
import pytest

from hradiosity.reference.form_factors import (
    coaxial_disks,
    parallel_rectangles,
    perpendicular_rectangles,
    point_to_disk,
    polygon_pair,
)
from hradiosity.reference.point_factors import point_to_patch, points_to_polygon
from hradiosity.reference.radiosity import solve_dense
from hradiosity.suites.validation.data import form_factors

CATALOGUE = form_factors()


def catalogue(kind):
    return [pytest.param(entry, id=entry["id"]) for entry in CATALOGUE if entry["kind"] == kind]


@pytest.mark.parametrize("entry", catalogue("polygon-polygon"))
def test_polygon_pairs(entry):
    """Where one polygon crosses the plane of the other (H03, H05) the integrand jumps, and sums of points creep."""
    pair = np.array(entry["poly1"], float), np.array(entry["poly2"], float)
    if entry["id"] in ("H03", "H05"):
        with pytest.raises(RuntimeError, match="did not settle"):
            polygon_pair(*pair)
        assert polygon_pair(*pair, tolerance=2e-2) == pytest.approx(float(entry["F12"]), rel=2e-2)
    elif float(entry["F12"]) == 0.0:
        assert polygon_pair(*pair, tolerance=10.0) < 1e-15
    else:
        assert polygon_pair(*pair, tolerance=1e-7) == pytest.approx(float(entry["F12"]), rel=1e-9)


@pytest.mark.parametrize("entry", catalogue("point-polygon"))
def test_point_receivers(entry):
    point, normal, polygon = (np.array(entry[key], float) for key in ("point", "normal", "poly2"))
    normal /= np.linalg.norm(normal)
    found = points_to_polygon(point[None], normal[None], polygon)[0]
    assert found == pytest.approx(float(entry["F12"]), rel=1e-12, abs=1e-16)


@pytest.mark.parametrize("entry", catalogue("disk-disk"))
def test_disks(entry):
    radius, other, distance = (float(entry["shape"][key]) for key in ("r1", "r2", "h"))
    assert coaxial_disks(radius, other, distance) == pytest.approx(float(entry["F12"]), rel=1e-12)


def test_closed_forms_make_a_cube_close():
    assert parallel_rectangles(1, 1, 1) + 4 * perpendicular_rectangles(1, 1, 1) == pytest.approx(1.0, abs=1e-14)


def test_lambert_and_area_integral_and_disk_agree():
    rng = np.random.default_rng(1)
    for _ in range(20):
        origin = np.array([0.3, -0.2, 2.0]) + 0.3 * rng.normal(size=3)
        edge_v, edge_u = [1.0, 0.2, 0.1] + 0.1 * rng.normal(size=(3,)), [-0.1, 0.8, 0.2] + 0.1 * rng.normal(size=3)
        point, normal = np.zeros(3), np.array([0.0, 0.0, 1.0])
        for triangle in (False, True):
            corners = [origin, origin + edge_u, origin + edge_u + edge_v, origin + edge_v]
            polygon = np.array([c for i, c in enumerate(corners) if not (triangle and i == 2)])
            lambert = points_to_polygon(point[None], normal[None], polygon)[0]
            assert point_to_patch(point, normal, origin, edge_u, edge_v, triangle=triangle) == pytest.approx(
                lambert, rel=1e-12
            )
    angle = np.linspace(0, 2 * np.pi, 20001)[:-1]
    disk = np.stack([0.7 * np.cos(angle), 0.7 * np.sin(angle), np.full_like(angle, 1.3)], axis=-1)
    assert points_to_polygon(point[None], normal[None], disk)[0] == pytest.approx(point_to_disk(0.7, 1.3), rel=1e-7)


def test_dense_solution_of_a_furnace():
    """Uniform emission in a closed space: E = 1/(1 − ρ)."""
    rng = np.random.default_rng(2)
    area = rng.uniform(0.1, 1.0, 30)
    exchange = np.outer(area, area) / area.sum()
    reflectance = np.full((30, 2), [0.5, 0.999])
    irradiance = solve_dense(exchange, area, reflectance, np.ones((30, 2)))
    np.testing.assert_allclose(irradiance, np.broadcast_to([2.0, 1000.0], (30, 2)), rtol=1e-12)
