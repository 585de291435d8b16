"""Intervals of the classic mode hold the truth, and smaller elements bring an accuracy that these are in the way of."""

import numpy as np
import pytest
from box_rooms import CASES, SENSOR, box_faces, box_room, expected, patches_of, scene_of
from rooms import SceneBuilder
from scipy.sparse import csr_array

from hradiosity.estimate import MESH
from hradiosity.options import Options
from hradiosity.radiosity.classic import ClassicSolver
from hradiosity.radiosity.classic_companion import WEIGHT, ClassicCompanion
from hradiosity.solvers.southwell import ShootingSystem, shoot

ROOMS = ("room443-panel-752", "room443-panel-uniform0.5", "room443-offset-mixed", "cube-lum-ceiling-A")
UP = np.array([[0.0, 0.0, 1.0]])


def solved(device, scene, **options):
    settings = {"element_size": 1.0, "hemicube_resolution": 32, "replicates": 8, "light_samples": 256} | options
    solver = ClassicSolver(scene, Options(mode="classic", **settings), device)
    for _ in solver.states():
        pass
    return solver


@pytest.fixture(scope="module")
def coarse_rooms(device):
    """Illuminance of rooms with patches of 1 m, and what is true; replicates enough to leave little but the mesh."""
    found = []
    for name in ROOMS:
        solution = solved(device, box_room(CASES[name]), replicates=32).solution()
        found.append((solution.readings[SENSOR].numbers["illuminance"], expected(CASES[name])))
    return found


def test_intervals_hold_the_exact_values_with_the_mesh_part_and_not_without(coarse_rooms):
    error = np.concatenate([np.abs(found.value - exact) for found, exact in coarse_rooms])
    whole = np.concatenate([found.half_width for found, _ in coarse_rooms])
    without = np.concatenate([np.sqrt(found.half_width**2 - found.parts[MESH] ** 2) for found, _ in coarse_rooms])
    assert len(error) == 71
    assert np.mean(error <= whole) >= 0.88
    assert np.mean(error <= without) < 0.75


def test_intervals_are_no_wider_than_errors_call_for(coarse_rooms):
    error = np.concatenate([(found.value - exact) / exact for found, exact in coarse_rooms])
    width = np.concatenate([found.half_width / exact for found, exact in coarse_rooms])
    assert np.median(width) < 3.0 * np.sqrt(np.mean(error**2))


def test_where_light_is_even_larger_elements_change_nothing(device):
    """A furnace: every side emits 1 − ρ and reflects ρ, so that E = 1 on elements of any size."""
    patches = patches_of(box_faces(2, 2, 2), np.zeros(6))
    scene = scene_of(patches, [[0.5]], [(k, [0.5]) for k in range(6)], [[0.7, 0.6, 0.0]], UP)
    found = solved(device, scene, tolerance=1e-5).solution().readings[SENSOR].numbers["irradiance"]
    assert found.value == pytest.approx(1.0, abs=0.02)
    assert found.parts[MESH].max() < 5e-3


def test_coarser_patches_solve_the_system_of_their_sums():
    """Four patches in two pairs against elimination with the exchange areas of the pairs added up."""
    random = np.random.default_rng(2)
    n, pair = 6, np.array([0, 0, 1, 1, 2, 2])
    area = random.uniform(0.5, 2.0, n)
    exchange = np.triu(random.uniform(0.0, 0.15, (n, n)), 1)
    exchange += exchange.T
    direct = random.uniform(1.0, 2.0, (n, 2))
    reflectance = np.array([0.5, 0.8, 0.3])[pair][:, None] * np.ones((1, 2))
    fine = ShootingSystem(area, reflectance, direct, lambda chosen: csr_array(exchange[chosen]))
    coarse = ClassicCompanion(pair, pair).system(fine, fine.rows)
    *_, end = shoot(coarse, np.ones(2), tolerance=1e-10, max_shots=10_000)
    joins = np.equal.outer(np.arange(3), pair).astype(float)
    total = joins @ area
    moved = (joins @ exchange @ joins.T) * np.array([0.5, 0.8, 0.3])[None, :] / total[:, None]
    exact = np.linalg.solve(np.eye(3) - moved, joins @ (area[:, None] * direct) / total[:, None])
    assert coarse.area == pytest.approx(total)
    assert end.irradiance == pytest.approx(exact, rel=1e-8)


def test_covered_elements_take_no_part_in_coarser_ones():
    """The mean of a pair is that of its exposed part, and what is covered changes nothing."""
    companion = ClassicCompanion(np.zeros(2, np.int64), np.zeros(2, np.int64))
    change = companion.change(np.array([[1.0], [0.0]]), np.array([[3.0], [9.0]]), np.array([2.0, 0.0]))
    assert change == pytest.approx(WEIGHT * np.array([[2.0], [0.0]]))


def uneven_room():
    """A lamp close to one wall: light falls off steeply."""
    room = SceneBuilder(1)
    paint = room.material([0.7])
    room.box((0, 0, 0), (4, 2, 2), paint, inward=True)
    lamp = room.patch((0.1, 0.8, 1.99), (0, 0.4, 0), (0.3, 0, 0), paint)
    room.lamp(lamp, [1000.0])
    room.sensor(np.array([[0.8, 1.0, 0.1], [2.0, 1.0, 0.1], [3.5, 1.0, 0.1]]), (0, 0, 1))
    return room.scene()


@pytest.fixture(scope="module")
def accurate(device):
    return solved(device, uneven_room(), accuracy=0.02)


def test_elements_become_smaller_where_they_are_in_the_way_of_an_accuracy(accurate):
    """Patches of 1 m leave 5.5 % to the mesh at the far end of the room, which replicates do not narrow."""
    given_up = accurate.solution().record["rounds_given_up"]
    assert accurate.accuracy_reached
    assert MESH in accurate.solution().record["interval_parts"]
    assert [found["replicates"] for found in given_up] == [8]
    assert given_up[0]["error"] > 0.02
    assert accurate.solution().plan.element_size <= 0.5


def test_what_an_accuracy_took_can_be_asked_for(accurate, device):
    """The last replicates are those of a run that starts with their elements and tolerance, bit for bit."""
    plan = accurate.solution().plan
    again = solved(device, uneven_room(), element_size=plan.element_size, replicates=accurate.replicates)
    lux = [next(iter(solver.solution().readings.values())).illuminance for solver in (accurate, again)]
    assert np.array_equal(*lux)


def test_further_points_are_read_from_the_last_elements_alone(accurate):
    """Light of elements that were given up does not count, or a point that is read again would differ."""
    readings = next(iter(accurate.solution().readings.values()))
    again = accurate.solution().read(readings.position, readings.normal)
    assert again.illuminance == pytest.approx(readings.illuminance, rel=1e-9)
