"""The Python interface of the README, and reading further points."""

import numpy as np
import pytest

import hradiosity


@pytest.fixture
def solution(room, device):
    options = hradiosity.Options(element_size=0.4, gather_samples=2048, replicates=4)
    return hradiosity.solve(hradiosity.load_scene(room), options, device)


def test_further_points_agree_with_the_sensors(solution):
    desk = solution.readings["desk, left"]
    again = solution.read(desk.position, [0.0, 0.0, 2.0])
    width = np.hypot(desk.illuminance_half_width, again.illuminance_half_width)
    assert np.all(np.abs(again.illuminance - desk.illuminance) <= 2.0 * width)
    assert np.all(again.illuminance_half_width < 0.2 * again.illuminance)
    assert again.irradiance.shape == (6, 9)


def test_one_point(solution):
    assert len(solution.read([1.5, 1.0, 0.5], [0, 0, 1])) == 1


@pytest.mark.parametrize(
    ("points", "normals"),
    [
        ([[0, 0]], [[0, 0, 1]]),
        ([[0, 0, np.nan]], [[0, 0, 1]]),
        ([[0, 0, 1]], [[0, 0, 0]]),
        ([[0, 0, 1]], [[0, 0, 1], [0, 1, 0]]),
    ],
)
def test_bad_points(solution, points, normals):
    with pytest.raises(ValueError, match=r"points|normal"):
        solution.read(points, normals)


def test_a_solution_without_a_solver_says_so(solution):
    from dataclasses import replace

    with pytest.raises(RuntimeError, match="solve the scene"):
        replace(solution, reader=None).read([0, 0, 1], [0, 0, 1])
