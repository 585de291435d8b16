"""Whole runs with other methods of form factors than rays: known solutions, and the same light as by rays."""

import json
from dataclasses import replace

import numpy as np
import pytest
from box_rooms import CASES, FACES, SENSOR, box_room, expected
from rooms import SceneBuilder

from hradiosity.errors import SceneError
from hradiosity.io.run_record import to_json
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sky
from hradiosity.options import Options
from hradiosity.plan import Calibration
from hradiosity.radiosity import make_solver
from hradiosity.transport.cell_pairs import RAYS_OF_A_PAIR

METHODS = ("hemicube", "point", "point-disk", "hemisphere", "quasi-hemisphere", "monte-carlo", "contour", "auto")
SMALL = Options(element_size=0.5, gather_samples=4096, light_points=64, replicates=4, hemicube_resolution=64)
TINY = replace(SMALL, element_size=0.8, gather_samples=64, light_points=4, replicates=2)


def run(device, scene, options):
    solver = make_solver(scene, options, device)
    for _ in solver.states():
        pass
    return solver


@pytest.mark.parametrize("case", ["room443-panel-752", "cube-iso-rho0.50"])
def test_faces_of_a_box_room_have_the_mean_of_the_continuous_solution(device, case):
    case = CASES[case]
    options = Options(
        element_size=case["dims"][0] / 16, form_factors="contour", light_points=256, replicates=2, gather_samples=1024
    )
    solution = run(device, box_room(case), options).solution()
    area, material = solution.elements.area, solution.elements.row_material
    lux = solution.surfaces.irradiance @ luminous_weights(solution.scene.bands)
    for number, face in enumerate(FACES):
        on_face = material == number
        mean = (lux * area)[on_face].sum() / area[on_face].sum()
        assert mean == pytest.approx(case["face_means"][face]["total"], rel=1e-3), face
    error = solution.readings[SENSOR].illuminance / expected(case) - 1.0
    assert np.sqrt(np.mean(error**2)) < 0.01
    defects = solution.record["defects_before_closure"][0]
    assert defects["row_sum_max"] < 1e-5 and defects["reciprocity_rms"] == 0.0


def furnished(sky=None):
    """A room with a chest in a corner, a table, a card upright and a lamp; without a wall where there is a sky."""
    b = SceneBuilder(2)
    wall, wood = b.material([0.6, 0.3]), b.material([0.2, 0.7])
    faces = b.box((0, 0, 0), (3, 2.5, 2.2), [wall] * 6, inward=True)
    b.box((0, 0, 0), (0.8, 0.6, 0.9), wood, solid=True)
    b.patch((1.2, 0.8, 0.75), (1.2, 0, 0), (0, 0.8, 0), wood)
    b.patch((2.6, 1.7, 0.0), (0.25, 0.25, 0), (0, 0, 1.4), wood)
    b.lamp(b.patch((1.2, 1.0, 2.1), (0, 0.5, 0), (0.5, 0, 0), wall), [10.0, 5.0])
    if sky is not None:
        del b.rows[faces[1]]
        b.emitters = [(row - 1, *rest) for row, *rest in b.emitters]
        b.sky = Sky(np.array(sky))
    places = [(0.3, 1.5, 0.01), (1.8, 1.2, 0.76), (1.8, 1.2, 0.01), (2.7, 2.3, 1.0), (0.4, 0.3, 0.91), (1.5, 0.01, 1.2)]
    b.sensor(places, [(0, 0, 1), (0, 0, 1), (0, 0, 1), (-1, 0, 0), (0, 0, 1), (0, 1, 0)], "places")
    return b.scene()


@pytest.fixture(scope="module")
def by_rays(device):
    return run(device, furnished(), replace(SMALL, rays_per_element=4096)).solution()


@pytest.mark.parametrize("method", METHODS)
def test_a_furnished_room_is_lit_as_by_rays(device, by_rays, method):
    """Within the intervals of both, and what centres and random points of cells with a common edge get wrong."""
    solver = run(device, furnished(), replace(SMALL, form_factors=method))
    solution = solver.solution()
    found, known = solution.readings["places"], by_rays.readings["places"]
    allowed = 0.02 if method.startswith(("point", "monte")) else 0.005
    margin = np.hypot(found.half_width, known.half_width) + allowed * known.irradiance
    assert (np.abs(found.irradiance - known.irradiance) < margin).all()
    assert np.median(found.half_width / found.irradiance) < 0.05
    account = solution.record["form_factors"]
    assert account["method"] == method
    assert any(method in note.place and "replicate" in note.message for note in solution.scene.notes)
    assert any("form factors" in line and method in line for line in solver.plan.lines())
    area = solution.elements.area
    mean = (solution.surfaces.irradiance * area[:, None]).sum() / (by_rays.surfaces.irradiance * area[:, None]).sum()
    assert mean == pytest.approx(1.0, abs=0.02)
    if method != "hemicube":
        assert 0.0 < account["proved_share"] < 1.0
        assert 0.0 < account["mean_visibility_error"] < 0.1
        assert 0.5 < account["open_share"] < 1.0
        assert account["cell_pairs"] >= account["element_pairs"] > 1000
    assert json.loads(to_json(account)) == account


@pytest.mark.parametrize("method", ["auto", "hemicube"])
def test_light_of_the_sky_comes_in_as_by_rays(device, method):
    scene = furnished(sky=[3.0, 4.0])
    known = run(device, scene, replace(SMALL, rays_per_element=4096)).solution().readings["places"]
    found = run(device, scene, replace(SMALL, form_factors=method)).solution().readings["places"]
    margin = np.hypot(found.half_width, known.half_width) + 0.02 * known.irradiance
    assert (np.abs(found.irradiance - known.irradiance) < margin).all()


def test_form_factors_are_computed_once_unless_they_are_random(device):
    counts = {}
    for method in ("point", "monte-carlo"):
        solver = run(device, furnished(), replace(TINY, form_factors=method))
        seconds = solver.record.seconds
        counts[method] = [key for key in ("pairs", "form factors", "visibility") if key in seconds]
        surfaces = solver._prepare()
        kept = surfaces._pairs
        surfaces.replicate(99)
        assert (surfaces._pairs is kept) == (method == "point")
    assert counts["point"] == ["pairs", "form factors", "visibility"]


@pytest.mark.parametrize("method", ["monte-carlo", "auto", "hemicube"])
def test_same_bits_for_the_same_seed_and_from_a_checkpoint(device, method):
    options = replace(TINY, form_factors=method)
    one = run(device, furnished(), options).solution()
    begun = make_solver(furnished(), options, device)
    next(state for state in begun.states() if state.replicate == 1)
    resumed = make_solver(furnished(), options, device)
    resumed.restore(begun.checkpoint())
    for _ in resumed.states():
        pass
    other = resumed.solution()
    np.testing.assert_array_equal(one.surfaces.irradiance, other.surfaces.irradiance)
    np.testing.assert_array_equal(one.readings["places"].irradiance, other.readings["places"].irradiance)


def test_too_many_pairs_are_refused_before_they_are_made(device):
    options = Options(element_size=0.03, form_factors="auto")
    with pytest.raises(SceneError, match="--elements"):
        _ = make_solver(furnished(), options, device).plan


def test_the_plan_tells_pairs_what_fits_and_seconds(device, monkeypatch):
    """A method that takes more rays for a pair takes longer, by just the rays of the pairs."""
    monkeypatch.setattr("hradiosity.radiosity.rounds.with_geometry", lambda plan, spent: plan)
    rates = Calibration(1e6, 1e6, 1e6, 1e-6, 1e-7)
    plans = {
        method: make_solver(furnished(), replace(TINY, form_factors=method), device, rates).plan
        for method in ("rays", "auto", "contour")
    }
    pairs = plans["auto"].pairs
    assert 1000 < pairs == plans["contour"].pairs
    assert any(f"{pairs / 1e6:.2g} million pairs of cells" in line for line in plans["auto"].lines())
    assert plans["rays"].seconds < plans["auto"].seconds
    more = (RAYS_OF_A_PAIR["contour"] - RAYS_OF_A_PAIR["auto"]) * pairs / rates.exchange_rays_per_s
    assert plans["contour"].seconds - plans["auto"].seconds == pytest.approx(more, rel=1e-6)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"mode": "classic", "form_factors": "contour"}, "must be hemicube in the classic mode"),
        ({"links": "hierarchical", "form_factors": "contour"}, "links must be rows"),
        ({"form_factors": "spheres"}, "form_factors must be one of rays, hemicube"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        Options(**settings)
    Options(mode="classic", form_factors="hemicube")
