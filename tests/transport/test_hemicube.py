"""Hemicubes against closed forms, Lambert's formula in double precision, and their own completeness."""

import numpy as np
import pytest
from box_rooms import box_faces, patches_of, scene_of, solid_box

from hradiosity.errors import DeviceError
from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.transport.device_scene import upload_scene
from hradiosity.transport.form_factor.hemicube import Hemicube, delta_factors

ROOM = (4.0, 3.0, 2.5)


def hemicube_of(device, patches, resolution=256, size=10.0):
    """Hemicube over patches that are cut into elements of about `size`, one element a cell."""
    scene = scene_of(patches, [[0.5]], [(0, [1.0])], np.zeros((1, 3)), [[0, 0, 1]])
    space = np.column_stack([np.zeros(len(patches), int), np.where(patches.solid < 0, 0, -1)])
    elements = build_elements(patches, space, np.array([True]), size, grouping=False)
    on_device = upload_scene(device, scene, build_bvh(device, patches), occlusion=True)
    return Hemicube(on_device, patches, elements, resolution), elements


def furnished(rng, n_boxes=40):
    """A room with boxes standing and hanging in it, some of them on the floor and against walls."""
    low = rng.uniform(0.0, 1.0, (n_boxes, 3)) * (np.array(ROOM) - 0.6)
    low[: n_boxes // 2, 2] = 0.0
    low[: n_boxes // 4, 0] = 0.0
    boxes = [solid_box(a, a + rng.uniform(0.05, 0.6, 3)) for a in low]
    faces = np.concatenate([box_faces(*ROOM), *boxes])
    solid = np.concatenate([np.full(6, -1), np.repeat(np.arange(n_boxes), 6)])
    return patches_of(faces, np.zeros(len(faces)), solid)


def floor_points(side):
    """(side², 3) midpoints of equal cells of the unit square in z = 0."""
    middle = (np.arange(side) + 0.5) / side
    x, y = (grid.ravel() for grid in np.meshgrid(middle, middle, indexing="ij"))
    return np.column_stack([x, y, np.zeros(side * side)])


def by_patch(factor, elements, n):
    """(n_points, n) factors to the fronts of the first n patches."""
    return np.stack([factor[:, elements.cell_side == 2 * k].sum(axis=1) for k in range(n)], axis=1)


def test_delta_factors_add_up_to_one_and_are_those_of_the_pixels():
    weight = delta_factors(64).astype(float)
    top, side = weight[: 64 * 64], weight[64 * 64 :]
    assert top.sum() + 4 * side.sum() == pytest.approx(1.0, abs=1e-6)
    # The top face is a square of half width 1 at distance 1: closed form of a point under its centre.
    corners = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
    exact = points_to_polygon(np.zeros((1, 3)), np.array([[0, 0, 1.0]]), corners)[0]
    assert top.sum() == pytest.approx(exact, abs=1e-4)


def test_points_see_each_wall_of_a_room_as_lambert_says(device):
    rng = np.random.default_rng(2)
    patches = patches_of(box_faces(*ROOM), np.zeros(6))
    cube, elements = hemicube_of(device, patches, resolution=512)
    position = rng.uniform(0.05, 0.95, (24, 3)) * ROOM
    position[:8, 2] = 0.02
    normal = rng.standard_normal((24, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    views = cube.views(position, normal, rng.random(24) * 2 * np.pi)
    exact = np.stack([points_to_polygon(position, normal, corners) for corners in patches.corners()], axis=1)
    found = by_patch(views.factor.toarray(), elements, 6)
    assert np.abs(found - exact).max() < 2.5e-3
    assert np.abs(found - exact).std() < 5e-4


def test_the_error_falls_with_the_pixel_size(device):
    rng = np.random.default_rng(3)
    patches = patches_of(box_faces(*ROOM), np.zeros(6))
    position = rng.uniform(0.1, 0.9, (128, 3)) * ROOM
    normal = np.broadcast_to([0.0, 0.0, 1.0], position.shape)
    exact = np.stack([points_to_polygon(position, normal, corners) for corners in patches.corners()], axis=1)
    error = []
    for resolution in (32, 64, 128, 256):
        cube, elements = hemicube_of(device, patches, resolution)
        found = by_patch(cube.views(position, normal, rng.random(128) * 2 * np.pi).factor.toarray(), elements, 6)
        error.append(np.sqrt(np.mean((found - exact) ** 2)))
    order = np.polyfit(np.log2([32, 64, 128, 256]), np.log2(error), 1)[0]
    assert order < -0.9


def test_faces_of_a_cube_see_each_other_as_the_closed_forms_say(device):
    rng = np.random.default_rng(4)
    cube, elements = hemicube_of(device, patches_of(box_faces(1, 1, 1), np.zeros(6)), resolution=128)
    points = floor_points(24)
    views = cube.views(points, np.broadcast_to([0.0, 0.0, 1.0], points.shape), rng.random(576) * 6.28, own_patch=4)
    by_face = by_patch(views.factor.toarray(), elements, 6).mean(axis=0)
    assert parallel_rectangles(1, 1, 1) == pytest.approx(0.19982490, abs=1e-8)
    assert perpendicular_rectangles(1, 1, 1) == pytest.approx(0.20004378, abs=1e-8)
    assert by_face[5] == pytest.approx(parallel_rectangles(1, 1, 1), abs=2e-4)
    assert np.abs(by_face[:4] - perpendicular_rectangles(1, 1, 1)).max() < 3e-4
    assert by_face[4] == 0.0


def test_a_small_card_hides_part_of_the_opposite_square(device):
    """A 0.1 m card midway between unit squares: its shadow is counted as a share, and not as yes or no."""
    rng = np.random.default_rng(5)
    square = box_faces(1, 1, 1)[[4, 5]]
    card = np.array([[[0.45, 0.45, 0.5], [0.1, 0, 0], [0, 0.1, 0]]])
    patches = patches_of(np.concatenate([square, card]), np.zeros(3))
    cube, elements = hemicube_of(device, patches, resolution=128)
    points = floor_points(24)
    up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    views = cube.views(points, up, rng.random(576) * 6.28, own_patch=0)
    open_share = by_patch(views.factor.toarray(), elements, 2).mean(axis=0)[1]
    assert open_share == pytest.approx(hidden_by_card(points), abs=4e-4)
    assert 0.193 < open_share < 0.195


def hidden_by_card(points):
    """Mean of the point factors to the upper square, less its part behind the card, by Lambert's formula: seen from
    the floor, the card's shadow on the ceiling is a square of twice its size."""
    up = np.array([[0.0, 0.0, 1.0]])
    ceiling = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    total = 0.0
    for point in points:
        low = np.clip(2 * np.array([0.45, 0.45]) - point[:2], 0, 1)
        high = np.clip(2 * np.array([0.55, 0.55]) - point[:2], 0, 1)
        shadow = np.array([[low[0], low[1], 1], [high[0], low[1], 1], [high[0], high[1], 1], [low[0], high[1], 1]])
        total += points_to_polygon(point[None], up, ceiling)[0] - points_to_polygon(point[None], up, shadow)[0]
    return total / len(points)


def test_the_factors_of_a_closed_room_add_up_to_one_next_to_its_walls(device):
    rng = np.random.default_rng(6)
    faces = box_faces(*ROOM)
    cube, _ = hemicube_of(device, patches_of(faces, np.zeros(6)), resolution=128)
    far = rng.uniform(0.2, 0.8, (32, 2))
    near = np.column_stack([np.full(32, 1e-3), far[:, 0] * 3, np.where(np.arange(32) % 2, 1e-3, far[:, 1] * 2.5)])
    normal = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]], 8, axis=0)
    views = cube.views(near, normal, rng.random(32) * 6.28)
    total = np.asarray(views.factor.sum(axis=1)).ravel()
    assert np.abs(total - 1.0).max() < 1e-5
    assert views.miss.max() == views.sky.max() == views.covered.max() == views.unlit.max() == 0.0


def test_the_factors_of_a_furnished_room_add_up_to_one(device):
    rng = np.random.default_rng(7)
    patches = furnished(rng)
    cube, _ = hemicube_of(device, patches, resolution=128, size=0.3)
    patch = rng.integers(len(patches), size=384)
    uv = rng.uniform(0.001, 0.999, (384, 2))
    uv[:96, 0] = 1e-3
    points = patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
    free = exposed(points + 1e-4 * patches.normal[patch], patches)
    assert free.sum() > 128
    points, patch = points[free], patch[free]
    views = cube.views(points, patches.normal[patch], rng.random(len(points)) * 6.28, own_patch=patch)
    total = np.asarray(views.factor.sum(axis=1)).ravel()
    assert np.abs(total - 1.0).max() < 1e-3


def exposed(points, patches):
    """Which points lie inside the room and in no box (six faces each, after the six of the room)."""
    inside = ((points > 0.0) & (points < ROOM)).all(axis=1)
    for first in range(6, len(patches), 6):
        corners = patches.corners()[first : first + 6].reshape(-1, 3)
        inside &= ((points < corners.min(axis=0)) | (points > corners.max(axis=0))).any(axis=1)
    return inside


def test_pixels_belong_to_the_element_they_show(device):
    rng = np.random.default_rng(8)
    patches = patches_of(box_faces(*ROOM), np.zeros(6))
    cube, elements = hemicube_of(device, patches, resolution=512, size=1.0)
    position = np.array([[1.3, 1.1, 0.4]])
    factor = cube.views(position, np.array([[0.0, 0.0, 1.0]]), rng.random(1)).factor.toarray()[0]
    ceiling = np.flatnonzero(elements.cell_side == 2 * 5)
    nu, nv = elements.divisions[5]
    for k, row in enumerate(ceiling):
        u, v = np.array([k % nu, k % nu + 1]) / nu, np.array([k // nu, k // nu + 1]) / nv
        cell = np.array([[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]])
        corners = patches.origin[5] + cell[:, :1] * patches.edge_u[5] + cell[:, 1:] * patches.edge_v[5]
        exact = points_to_polygon(position, np.array([[0.0, 0.0, 1.0]]), corners)[0]
        assert factor[row] == pytest.approx(exact, abs=2e-4)


def test_the_same_numbers_come_in_any_batch(device):
    rng = np.random.default_rng(9)
    patches = furnished(rng, 10)
    cube, _ = hemicube_of(device, patches, resolution=64, size=0.5)
    position = rng.uniform(0.1, 0.9, (70, 3)) * ROOM
    normal = np.broadcast_to([0.0, 0.0, 1.0], position.shape)
    angle = rng.random(70) * 6.28
    together = cube.views(position, normal, angle)
    alone = cube.views(position[66:67], normal[66:67], angle[66:67])
    assert (together.factor[[66]] != alone.factor).nnz == 0


@pytest.mark.parametrize("resolution", [0, 6, 33])
def test_a_senseless_resolution_is_refused(device, resolution):
    with pytest.raises(ValueError, match="even and at least 8"):
        hemicube_of(device, patches_of(box_faces(1, 1, 1), np.zeros(6)), resolution)


def test_a_device_without_double_precision_is_refused(device, monkeypatch):
    from dataclasses import replace

    monkeypatch.setattr(device, "info", replace(device.info, has_double=False))
    with pytest.raises(DeviceError, match="double precision"):
        hemicube_of(device, patches_of(box_faces(1, 1, 1), np.zeros(6)))
