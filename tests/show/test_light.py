"""Indirect light between the row elements."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK
from rooms import SceneBuilder, cube

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.radiosity import solve
from hradiosity.show.light import picture_scene, row_light
from hradiosity.show.seams import level_seams
from hradiosity.show.shading import indirect_at
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cell_lookup import locate_cells


def room_with_a_wall_in_three_patches():
    """Two patches of other divisions meet a third one at a T-junction; all are one wall, y = 2."""
    b = SceneBuilder()
    white = b.material(0.6)
    b.box((0, 0, 0), (2, 2, 2), white, inward=True)
    origin, u, v = (np.asarray(a, float) for a in b.rows[3][:3])
    b.rows[3] = (origin, 0.4 * u, v, *b.rows[3][3:])
    b.patch(origin + 0.4 * u, 0.6 * u, 0.37 * v, white)
    b.patch(origin + 0.4 * u + 0.37 * v, 0.6 * u, 0.63 * v, white)
    b.lamp(b.patch((0.8, 0.8, 1.99), (0, 0.4, 0), (0.4, 0, 0), white), 1.0)
    return b.scene()


def light_on_sides(picture, rows, patch, u, v):
    side = np.full(len(u), 2 * patch)
    cell, s, t = locate_cells(picture.elements, picture.scene.patches.is_triangle, side, u, v)
    return indirect_at(picture, rows, cell, s, t)[:, 3]


def steps(picture, rows):
    """Rms step over the mean across the three seams of the wall."""
    t = np.linspace(0.02, 0.98, 300).astype(np.float32)
    zero, one = np.zeros_like(t), np.ones_like(t)
    pairs = [
        ((3, one, 0.37 * t), (6, zero, t)),
        ((3, one, 0.37 + 0.63 * t), (7, zero, t)),
        ((6, t, one), (7, t, zero)),
    ]
    here, there = (np.concatenate([light_on_sides(picture, rows, *pair[k]) for pair in pairs]) for k in (0, 1))
    return float(np.sqrt(np.mean((here - there) ** 2)) / here.mean())


@pytest.fixture(scope="module")
def wall(device):
    scene = room_with_a_wall_in_three_patches()
    solution = solve(scene, replace(QUICK, rays_per_element=32), device)
    picture = picture_scene(solution)
    return picture, row_light(picture, solution, None), build_bvh(device, scene.patches), solution.surfaces.exposed


def test_seams_are_levelled(wall):
    picture, rows, bvh, exposed = wall
    before, after = steps(picture, rows), steps(picture, level_seams(picture, bvh, rows, exposed))
    print(f"step across seams {before:.4f} before, {after:.4f} after")
    assert before > 0.02 and after < 0.4 * before


def test_levelling_keeps_what_is_shared_already(device):
    """A cube's faces have no coplanar neighbour: nothing changes."""
    room = cube([0.1, 0.3, 0.5, 0.7, 0.9, 0.2])
    room.lamp(5, 1.0)
    scene = room.scene()
    solution = solve(scene, QUICK, device)
    picture = picture_scene(solution)
    rows = row_light(picture, solution, None)
    levelled = level_seams(picture, build_bvh(device, scene.patches), rows, solution.surfaces.exposed)
    np.testing.assert_array_equal(levelled.at_vertex, rows.at_vertex)


def test_what_a_box_covers_does_not_darken_the_floor_beside_it(device):
    """Everything shines, E = 2 all over; the floor is cut at the box, with other divisions on both sides of the cut."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (2, 2, 2), paint, inward=True)
    b.rows[4] = ((0, 0, 0), (1.2, 0, 0), (0, 2, 0), *b.rows[4][3:])
    b.patch((1.2, 0, 0), (0.8, 0, 0), (0, 0.9, 0), paint)
    b.patch((1.2, 0.9, 0), (0.8, 0, 0), (0, 1.1, 0), paint)
    b.box((1.2, 0.9, 0), (2, 2, 1), paint, solid=True)
    for patch in range(len(b.rows)):
        b.lamp(patch, 1.0)
    scene = b.scene()
    solution = solve(scene, replace(QUICK, gather_samples=8), device)
    picture, bvh = picture_scene(solution), build_bvh(device, solution.scene.patches)
    rows = level_seams(picture, bvh, row_light(picture, solution, None), solution.surfaces.exposed)
    along = np.linspace(0.01, 0.99, 99).astype(np.float32)
    edge = light_on_sides(picture, rows, 4, np.ones_like(along), along)
    assert len(solution.scene.patches) == len(scene.patches)
    weights = luminous_weights(scene.bands)
    np.testing.assert_allclose(edge, 2.0 * weights.sum(), rtol=0.01)


def test_vertices_never_mix_surfaces(device):
    """A black face has no reflected light at its rim, however bright its neighbours are."""
    room = cube([0.8, 0.8, 0.8, 0.8, 0.0, 0.8])
    room.lamp(5, 1.0)
    solution = solve(room.scene(), QUICK, device)
    picture = picture_scene(solution)
    rows = row_light(picture, solution, None)
    black = picture.frames.side == 8
    at_corners = rows.at_vertex[rows.vertex]
    assert (at_corners[black][:, :, :3] == 0).all() and (at_corners[black][:, :, 3] > 0).all()
    assert (at_corners[~black & (picture.frames.side % 2 == 0)][:, :, 1] > 0).all()
