"""Sensors and views stand where the scene file says."""

import numpy as np
import pytest
from scene_writing import OPEN_ROOM, load

UP = [0.0, 0.0, 1.0]


def sensor(tmp_path, text, unit="m", up="z"):
    header = OPEN_ROOM.replace('unit = "m"', f'unit = "{unit}"\nup = "{up}"')
    return load(tmp_path, header + f'[[sensor]]\nname = "s"\n{text}\n').sensors[0]


def test_points_with_one_normal_and_with_many(tmp_path):
    one = sensor(tmp_path, 'kind = "points"\npositions = [[0, 0, 1], [1, 2, 3]]\nnormal = [0, 0, 5]')
    np.testing.assert_array_equal(one.normal, [UP, UP])
    many = sensor(tmp_path, 'kind = "points"\npositions = [[0, 0, 1], [1, 2, 3]]\nnormals = [[0, 0, 1], [3, 0, 4]]')
    np.testing.assert_allclose(many.normal, [UP, [0.6, 0, 0.8]], rtol=1e-15)
    assert many.grid is None


def test_grid_points_are_cell_centres_along_u_first(tmp_path):
    grid = sensor(
        tmp_path,
        'kind = "grid"\ncorner = [1, 1, 0]\nedge_u = [3, 0, 0]\nedge_v = [0, 2, 0]\ncounts = [3, 2]\nheight = 0.8',
    )
    expected = [[1.5, 1.5], [2.5, 1.5], [3.5, 1.5], [1.5, 2.5], [2.5, 2.5], [3.5, 2.5]]
    np.testing.assert_allclose(grid.position, [[*xy, 0.8] for xy in expected], rtol=1e-15)
    assert grid.grid == (2, 3)
    np.testing.assert_array_equal(grid.normal, np.tile(UP, (6, 1)))


def test_grid_in_millimetres_with_y_up(tmp_path):
    grid = sensor(
        tmp_path,
        'kind = "grid"\ncorner = [0, 0, 0]\nedge_u = [0, 0, 1000]\nedge_v = [1000, 0, 0]\ncounts = [1, 1]\n'
        "height = 750",
        "mm",
        "y",
    )
    np.testing.assert_allclose(grid.position, [[0.5, -0.5, 0.75]], rtol=1e-15)
    np.testing.assert_array_equal(grid.normal, [UP])


@pytest.mark.parametrize(("side", "sign"), [("front", 1.0), ("back", -1.0)])
def test_points_on_a_surface(tmp_path, side, sign):
    spread = sensor(tmp_path, f'kind = "surface"\nobject = "floor"\nspacing = 1.0\nside = "{side}"\noffset = 0.01')
    assert spread.grid == (2, 4)
    np.testing.assert_allclose(spread.position[:, 2], sign * 0.01)
    np.testing.assert_allclose(spread.position[:, :2].mean(axis=0), [2, 1], rtol=1e-15)
    np.testing.assert_array_equal(spread.normal[0], [0, 0, sign])


def test_points_on_triangles_lie_inside_and_spread_evenly(tmp_path):
    triangle = '[[polygon]]\nname = "t"\nvertices = [[0, 0, 1], [3, 0, 1], [0, 3, 1]]\nmaterial = "paint"\n'
    text = f'{OPEN_ROOM}{triangle}[[sensor]]\nname = "s"\nkind = "surface"\nobject = "t"\ncounts = [5, 3]\n'
    points = load(tmp_path, text).sensors[0].position
    assert len(points) == 25
    assert len(np.unique(points.round(9), axis=0)) == 25
    assert (points[:, :2] > 0).all()
    assert (points[:, 0] + points[:, 1] < 3).all()
    np.testing.assert_allclose(points.mean(axis=0), [1, 1, 1.001], rtol=1e-14)


def test_eyes(tmp_path):
    eye = sensor(tmp_path, 'kind = "eye"\npositions = [[0, 0, 0], [2, 0, 0]]\neye_height = 1.2\ntarget = [1, 0, 1.2]')
    np.testing.assert_allclose(eye.position, [[0, 0, 1.2], [2, 0, 1.2]], rtol=1e-15)
    np.testing.assert_allclose(eye.normal, [[1, 0, 0], [-1, 0, 0]], atol=1e-15)
    one = sensor(tmp_path, 'kind = "eye"\npositions = [[0, 0, 0], [2, 0, 0]]\ngaze = [0, 2, 0]')
    np.testing.assert_array_equal(one.normal, [[0, 1, 0], [0, 1, 0]])


def test_views(tmp_path):
    text = OPEN_ROOM + (
        '[[view]]\nname = "a"\nposition = [1, 0, 1]\ntarget = [1, 5, 1]\nsize = [100, 50]\nfield_of_view_deg = 45\n'
        '[[view]]\nname = "plan"\nposition = [1, 0, 9]\ndirection = [0, 0, -1]\n'
    )
    front, plan = load(tmp_path, text).views
    np.testing.assert_array_equal([front.direction, front.up], [[0, 1, 0], UP])
    assert (front.width, front.height, front.field_of_view) == (100, 50, 45.0)
    np.testing.assert_array_equal(plan.up, [0, 1, 0])
