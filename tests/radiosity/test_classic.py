"""The classic mode against continuous solutions, and the promises that both modes keep."""

import numpy as np
import pytest
from box_rooms import (
    CASES,
    FACES,
    SENSOR,
    box_faces,
    box_room,
    expected,
    patches_of,
    scene_of,
    solid_box,
)

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver, make_solver
from hradiosity.radiosity.classic import ClassicSolver
from hradiosity.reference.point_factors import points_to_polygon

UP = np.array([[0.0, 0.0, 1.0]])


def classic(element_size, **options):
    settings = {"hemicube_resolution": 128, "replicates": 4, "light_samples": 256} | options
    return Options(mode="classic", element_size=element_size, **settings)


def run(device, scene, options, **how):
    solver = ClassicSolver(scene, options, device, **how)
    for _ in solver.states():
        pass
    return solver


@pytest.fixture(scope="module")
def panel_room(device):
    return run(device, box_room(CASES["room443-panel-752"]), classic(0.5))


def test_readings_of_a_box_room_are_those_of_the_continuous_solution(panel_room):
    readings = panel_room.solution().readings[SENSOR]
    error = readings.illuminance / expected(CASES["room443-panel-752"]) - 1.0
    assert np.abs(error).max() < 0.015
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert np.median(readings.accuracy) < 0.01


def test_faces_of_a_box_room_have_the_mean_of_the_continuous_solution(panel_room):
    case, solution = CASES["room443-panel-752"], panel_room.solution()
    area, material = solution.elements.area, solution.elements.row_material
    lux = solution.surfaces.irradiance @ luminous_weights(solution.scene.bands)
    for number, face in enumerate(FACES):
        on_face = material == number
        mean = (lux * area)[on_face].sum() / area[on_face].sum()
        assert mean == pytest.approx(case["face_means"][face]["total"], rel=0.015)


def test_elements_are_split_where_light_changes(panel_room):
    """Walls beside the panel fade towards the ceiling; rows are then smaller than patches, and never larger."""
    elements = panel_room.solution().elements
    assert elements.area.max() < 0.5**2 * 1.6
    assert len(np.unique(np.round(elements.area, 6))) >= 3
    assert elements.area.sum() == pytest.approx(2 * 16 + 4 * 12, rel=1e-9)


def test_point_sources_light_elements_by_shadow_rays(device):
    case = CASES["cube-iso-rho0.50"]
    solver = run(device, box_room(case), classic(0.6, hemicube_resolution=64))
    readings = solver.solution().readings[SENSOR]
    away = np.abs(readings.position - 2.0).max(axis=1) + np.sort(np.abs(readings.position - 2.0), axis=1)[:, 1] < 3.6
    error = readings.illuminance / expected(case) - 1.0
    assert away.sum() >= 5
    assert np.abs(error[away]).max() < 0.02


@pytest.mark.parametrize("lamps_in_view", [False, True])
def test_a_small_lamp_over_a_large_floor(device, lamps_in_view):
    """Nothing reflects but the floor, and nothing sees the floor but the lamp: direct light, exactly known."""
    floor = [[-10.0, -10.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]
    lamp = [[-0.1, -0.1, 2.0], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0]]
    patches = patches_of([floor, lamp], [0, 1])
    position = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.0], [3.0, 0.0, 0.0]])
    scene = scene_of(patches, [[0.5], [0.0]], [(1, [1000.0])], position, np.repeat(UP, 3, axis=0))
    options = classic(1.0, hemicube_resolution=256, replicates=8 if lamps_in_view else 4)
    solution = run(device, scene, options, lamps_in_view=lamps_in_view).solution()
    exact = 1000.0 * points_to_polygon(position, np.repeat(UP, 3, axis=0), patches.corners()[1])
    found = solution.readings[SENSOR].irradiance[:, 0]
    assert found == pytest.approx(exact, rel=0.05 if lamps_in_view else 1e-4)
    row_power = solution.surfaces.direct[:, 0] * solution.elements.area
    on_floor = solution.elements.row_material == 0
    shares = points_to_polygon(*lamp_points(lamp), patches.corners()[0]).mean()
    assert row_power[on_floor].sum() == pytest.approx(1000.0 * 0.04 * shares, rel=3e-3)


def lamp_points(lamp):
    """Points of the lamp, and its normal at each."""
    share = (np.arange(4) + 0.5) / 4
    s, t = (grid.ravel() for grid in np.meshgrid(share, share))
    points = np.array(lamp[0]) + s[:, None] * np.array(lamp[1]) + t[:, None] * np.array(lamp[2])
    return points, np.repeat(-UP, len(points), axis=0)


def test_a_lamp_that_reflects_is_a_patch_like_any_other(device):
    """A cube of reflectance 0.8 all over, lamp included, with one face that emits M: the mean of E over all faces is
    M / 6 / (1 − 0.8), which a lamp that swallows light, or counts its own twice, would miss."""
    faces = box_faces(1, 1, 1)
    scene = scene_of(patches_of(faces, np.zeros(6)), [[0.8]], [(5, [100.0])], [[0.5, 0.5, 0.0]], UP)
    solution = run(device, scene, classic(0.25, hemicube_resolution=64, tolerance=1e-4)).solution()
    area = solution.elements.area
    mean = (solution.surfaces.irradiance[:, 0] * area).sum() / area.sum()
    assert mean == pytest.approx(100.0 / 6.0 / 0.2, rel=5e-4)


def test_a_furnace_has_one_radiance_everywhere(device):
    """All faces emit 1 − ρ and reflect ρ: E = 1 wherever one looks, in a room with a box on its floor. The bottom of
    the box looks out of the room."""
    faces = np.concatenate([box_faces(2, 2, 2), solid_box((0.6, 0.6, 0.0), (1.1, 1.2, 0.7))])
    patches = patches_of(faces, np.zeros(12), np.concatenate([np.full(6, -1), np.zeros(6)]))
    lamps = [(k, [0.5]) for k in range(12)]
    position = np.array([[0.3, 0.3, 0.0], [1.5, 1.5, 1.0], [0.7, 0.7, 0.9]])
    scene = scene_of(patches, [[0.5]], lamps, position, np.repeat(UP, 3, axis=0))
    solution = run(device, scene, classic(0.5, hemicube_resolution=64, tolerance=1e-4), lamps_in_view=True).solution()
    assert solution.readings[SENSOR].irradiance[:, 0] == pytest.approx(1.0, abs=0.01)
    elements = solution.elements
    bottom = elements.cell_side[elements.row_cell[elements.row_start[:-1]]] // 2 == 10
    exposed_area = np.where(bottom, 0.0, elements.area * solution.surfaces.exposed)
    mean = (solution.surfaces.irradiance[:, 0] * exposed_area).sum() / exposed_area.sum()
    assert mean == pytest.approx(1.0, abs=3e-3)


def test_light_from_the_sky_comes_through_the_open_side(device):
    """A pit 1 m deep without a lid, black: the middle of its floor sees the sky through the opening alone."""
    faces = box_faces(1, 1, 1)[:5]
    position = np.array([[0.5, 0.5, 0.0]])
    scene = scene_of(patches_of(faces, np.zeros(5)), [[0.0]], [], position, UP, sky=[2.0])
    readings = run(device, scene, classic(0.5, replicates=8)).solution().readings[SENSOR]
    opening = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    exact = 2.0 * np.pi * points_to_polygon(position, UP, opening)
    assert readings.irradiance[:, 0] == pytest.approx(exact, rel=5e-3)


def test_the_same_seed_gives_the_same_bits_and_a_checkpoint_goes_on(device):
    scene = box_room(CASES["room443-offset-mixed"])
    options = classic(1.0, hemicube_resolution=32, replicates=3)
    whole = run(device, scene, options).solution().readings[SENSOR]
    broken = ClassicSolver(scene, options, device)
    states = broken.states()
    for _ in range(2):
        next(states)
    resumed = ClassicSolver(scene, options, device)
    resumed.restore(broken.checkpoint())
    for _ in resumed.states():
        pass
    assert np.array_equal(resumed.solution().readings[SENSOR].irradiance, whole.irradiance)


def test_further_points_are_read_without_solving_again(panel_room):
    readings = panel_room.solution().readings[SENSOR]
    hemicubes = panel_room.record.convergence[-1].products
    again = panel_room.solution().read(readings.position, readings.normal)
    assert again.illuminance == pytest.approx(readings.illuminance, rel=1e-9)
    assert panel_room.record.convergence[-1].products == hemicubes


def test_the_mode_chooses_the_solver(device):
    scene = box_room(CASES["room443-panel-752"])
    assert type(make_solver(scene, Options(), device)) is RadiositySolver
    assert type(make_solver(scene, Options(mode="classic"), device)) is ClassicSolver


@pytest.mark.parametrize("wrong", [{"mode": "modern"}, {"hemicube_resolution": 33}, {"hemicube_resolution": 4}])
def test_senseless_options_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Options(**wrong)
