"""Whole runs over hierarchical links, against continuous solutions, rows of rays and unbiased paths."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import CASES, FACES, box_room, expected
from rooms import SceneBuilder, cube

from hradiosity.errors import SceneError
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.options import Options
from hradiosity.radiosity import make_solver, solve
from hradiosity.radiosity.linked import LinkedSolver
from hradiosity.radiosity.referee import Referee

LINKS = Options(
    links="hierarchical",
    link_form_factor=0.01,
    elements=1500,
    gather_samples=1024,
    light_samples=64,
    rays_per_element=64,
    light_points=32,
    glow=False,
)


def furnished():
    b = SceneBuilder(1)
    paints = [b.material(r) for r in (0.7, 0.5, 0.6, 0.7, 0.3, 0.8)]
    b.box((0, 0, 0), (4, 3, 2.5), paints, inward=True)
    b.box((1.0, 0.8, 0.7), (2.6, 1.8, 0.75), paints[1], solid=True)
    b.box((3.3, 0.0, 0.0), (4.0, 0.6, 2.0), paints[2], solid=True)
    b.box((0.0, 2.95, 0.9), (0.5, 2.97, 1.3), paints[3], solid=True)
    b.lamp(b.patch((1.5, 1.0, 2.49), (0, 0.6, 0), (0.6, 0, 0), paints[5]), 1000.0)
    position = [
        (0.5, 0.5, 0.01),
        (1.8, 1.3, 0.01),
        (1.8, 1.3, 0.77),
        (0.01, 2.0, 1.2),
        (3.0, 2.5, 1.0),
        (2.0, 1.5, 2.3),
    ]
    normal = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 0, -1)]
    b.sensor(position, normal)
    return b.scene()


def run(scene, options, device):
    solver = make_solver(scene, options, device)
    for _ in solver.states():
        pass
    return solver.solution()


def test_the_option_names_the_solver(device):
    assert isinstance(make_solver(furnished(), LINKS, device), LinkedSolver)


@pytest.mark.parametrize("name", ["cube-iso-rho0.50", "cube-lum-ceiling-A", "room443-panel-752"])
def test_box_rooms(device, name):
    """Paths from points as by rows: three standard errors of the noisiest are 2 %."""
    case = CASES[name]
    scene = box_room(case)
    solution = solve(scene, replace(LINKS, link_form_factor=0.005), device)
    (readings,) = solution.readings.values()
    assert np.abs(readings.illuminance / expected(case) - 1).max() < 0.02
    elements = solution.elements
    material = elements.row_material
    received = np.bincount(material, elements.area * solution.surfaces.irradiance[:, 0])
    mean = luminous_weights(scene.bands)[0] * received / np.bincount(material, elements.area)
    faces = mean / [case["face_means"][face]["total"] for face in FACES] - 1
    assert np.abs(faces).max() < 0.005


def test_furnished_room_against_unbiased_paths(device):
    scene = furnished()
    referee = Referee(scene, device, 1 << 15, 1)
    for _ in referee.states():
        pass
    samples = referee.samples()
    wanted = samples.per_scramble.mean(axis=0)[:, 0]
    found = run(scene, replace(LINKS, gather_samples=8192), device).readings["s0"].irradiance[:, 0]
    np.testing.assert_allclose(found, wanted, rtol=0.02)


def test_finer_links_bring_the_elements_nearer_to_rows(device):
    scene = furnished()
    rows = run(scene, replace(LINKS, links="rows", rays_per_element=2048), device).surfaces.irradiance[:, 0]
    error = []
    for largest in (0.3, 0.03):
        found = run(scene, replace(LINKS, link_form_factor=largest, rays_per_element=256), device)
        lit = np.flatnonzero(rows)
        change = found.surfaces.irradiance[lit, 0] / rows[lit] - 1.0
        error.append(np.sqrt(np.average(change**2, weights=found.elements.area[lit])))
    assert error[1] < 0.7 * error[0] and error[1] < 0.05


def test_small_lamp_over_a_large_floor_balances(device):
    """All light is absorbed; links that were counted twice would add some."""
    b = cube([0.5, 0.6, 0.7, 0.4, 0.8, 0.3])
    b.lamp(b.patch((0.48, 0.48, 0.9), (0, 0.04, 0), (0.04, 0, 0), b.material(0.5)), 100.0)
    scene = b.scene()
    solution = run(scene, replace(LINKS, light_points=512, elements=800), device)
    absorbed = 1.0 - np.append(scene.reflectance[:, 0], 0.0)[solution.elements.row_material]
    power = float((absorbed * solution.elements.area * solution.surfaces.irradiance[:, 0]).sum())
    direct = float((solution.elements.area * solution.surfaces.direct[:, 0]).sum())
    assert direct == pytest.approx(0.16, rel=0.02)
    assert power == pytest.approx(direct, rel=2e-3)


def test_a_sealed_room_stays_exactly_dark(device):
    b = SceneBuilder(1)
    paint = b.material(0.7)
    b.box((0, 0, 0), (3, 1, 1), paint, inward=True)
    b.patch((1.5, 0, 0), (0, 0, 1), (0, 1, 0), paint)
    b.lamp(b.patch((0.5, 0.4, 0.99), (0, 0.2, 0), (0.2, 0, 0), paint), 100.0)
    b.sensor([(0.5, 0.5, 0.1), (2.5, 0.5, 0.1), (1.6, 0.1, 0.9)], [(0, 0, 1), (0, 0, 1), (1, 0, 0)])
    readings = run(b.scene(), LINKS, device).readings["s0"].irradiance[:, 0]
    assert readings[0] > 0.0 and not readings[1:].any()


@pytest.mark.parametrize("solver", ["jacobi", "gauss-seidel", "southwell", "auto", "gaussian-elimination"])
def test_other_solvers_agree(device, solver):
    options = replace(LINKS, elements=400, replicates=2, tolerance=1e-4)
    wanted = run(furnished(), options, device).surfaces.irradiance
    found = run(furnished(), replace(options, solver=solver), device).surfaces.irradiance
    np.testing.assert_allclose(found, wanted, rtol=2e-3, atol=2e-3 * wanted.max())


def test_direct_solvers_are_refused_for_many_elements(device):
    with pytest.raises(SceneError, match="gaussian-elimination"):
        _ = make_solver(furnished(), replace(LINKS, elements=40000, solver="gaussian-elimination"), device).plan


def test_resumed_run_ends_with_the_same_bits(device):
    options = replace(LINKS, elements=400, replicates=3)
    whole = run(furnished(), options, device)
    first = make_solver(furnished(), options, device)
    states = first.states()
    while first.replicates < 2:
        next(states)
    second = make_solver(furnished(), options, device)
    second.restore(first.checkpoint())
    for _ in second.states():
        pass
    resumed = second.solution()
    np.testing.assert_array_equal(resumed.surfaces.irradiance, whole.surfaces.irradiance)
    np.testing.assert_array_equal(resumed.readings["s0"].irradiance, whole.readings["s0"].irradiance)


def test_plan_and_record_tell_about_the_links(device):
    solver = make_solver(furnished(), replace(LINKS, elements=400, replicates=2), device)
    count = solver.plan.links
    assert any("links of form factors up to 0.01" in line for line in solver.plan.lines())
    assert solver.plan.seconds is None
    for _ in solver.states():
        pass
    record = solver.solution().record["links"]
    assert record["total"] == count.total == sum(record["per_level"]) > 1000
    assert 0.0 < record["proved_share"] < 1.0 and 0.0 < record["blocked"] < 1.0 and record["partly_hidden"] > 0.0


@pytest.mark.parametrize(
    ("change", "named"),
    [({"links": "some"}, "links"), ({"link_form_factor": 0.0}, "link_form_factor"), ({"mode": "classic"}, "links")],
)
def test_wrong_options_are_refused(change, named):
    with pytest.raises(ValueError, match=named):
        replace(LINKS, **change)
