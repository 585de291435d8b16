"""Primary rays go where the camera looks."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import camera, furnace, furnished_room
from rooms import SceneBuilder

from hradiosity.show.camera import ABOVE, NOTHING, picture_points, project, trace_view, view_axes
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.viewpoints import automatic_view


def test_rays_meet_what_projects_to_their_pixel(device):
    """Each ray's point, projected by the pinhole formula, is the middle of its sample."""
    scene = furnished_room()
    view = camera((0.3, 0.4, 1.6), (2.5, 3.5, 0.8), field_of_view=80, width=40, height=30)
    hits = trace_view(build_bvh(device, scene.patches), view, 3)
    patches, patch = scene.patches, hits.side // 2
    assert (hits.side >= 0).all()
    points = patches.origin[patch] + hits.u[:, None] * patches.edge_u[patch] + hits.v[:, None] * patches.edge_v[patch]
    x, y = project(view, points).T.reshape(2, 90, 120)
    np.testing.assert_allclose(x, np.broadcast_to((np.arange(120) + 0.5) / 3, x.shape), atol=1e-3)
    np.testing.assert_allclose(y, np.broadcast_to(((np.arange(90) + 0.5) / 3)[:, None], y.shape), atol=1e-3)
    np.testing.assert_allclose(hits.depth, (points - view.position) @ view_axes(view)[0], rtol=1e-4)


def test_known_point_of_a_picture():
    """90° wide: a point as far aside as ahead is on the edge; half as far up, at the top of a 2:1 picture."""
    view = camera((1, 2, 3), (2, 2, 3), field_of_view=90, width=200, height=100)
    aside, up = (1 + 4, 2 - 4, 3), (1 + 4, 2, 3 + 2)
    found = project(view, np.array([aside, up, (9, 2, 3), (0, 2, 3)], float))
    np.testing.assert_allclose(found[:3], [(200, 50), (100, 0), (100, 50)], atol=1e-9)
    assert np.isnan(found[3]).all()


def test_rays_that_leave_the_scene_know_the_sky(device):
    b = SceneBuilder()
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), b.material(0.5))
    hits = trace_view(build_bvh(device, b.scene().patches), camera((0, -5, 1), (0, 0, 1)), 1)
    side = hits.side.reshape(48, 64)
    assert (side[:24] == ABOVE).all() and (side[-1, :8] == NOTHING).all() and (side == 0).any()


def test_points_cover_every_pixel_once(device):
    hits = trace_view(build_bvh(device, furnished_room().patches), camera((0.3, 0.4, 1.6), (2, 3, 0.8)), 3)
    points = picture_points(hits, 3)
    np.testing.assert_allclose(np.bincount(points.pixel, points.weight), 1, rtol=1e-6)
    assert len(points.pixel) < 0.4 * len(hits.side)
    with pytest.raises(ValueError, match="odd"):
        picture_points(hits, 2)


def test_camera_that_looks_along_its_up():
    view = replace(camera((0, 0, 0), (1, 0, 0)), up=np.array([-2.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match="along its own up"):
        view_axes(view)


@pytest.mark.parametrize("scene", [furnished_room(), furnace()], ids=["furnished", "cube"])
def test_automatic_view_stands_in_the_room(device, scene):
    bvh = build_bvh(device, scene.patches)
    view = automatic_view(scene, bvh, np.array([[True, False]] * len(scene.patches)))
    low, high = scene.patches.bounds()
    assert ((view.position > low) & (view.position < high)).all()
    assert (trace_view(bvh, view, 1).side % 2 == 0).mean() > 0.95


def test_automatic_view_of_a_thing_in_the_open_stands_outside(device):
    b = SceneBuilder()
    b.box((0, 0, 0), (1, 1, 1), b.material(0.5), solid=True)
    scene = b.scene()
    bvh = build_bvh(device, scene.patches)
    view = automatic_view(scene, bvh, np.array([[True, False]] * 6))
    side = trace_view(bvh, view, 1).side
    assert (side >= 0).mean() > 0.05 and (side[side >= 0] % 2 == 0).all()
