"""Cells as VTK draws them: no gaps between them."""

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from window_room import NEEDS_GL

from hradiosity.io.drawn_scene import Cells
from hradiosity.io.scene_drawing import draw_scene
from hradiosity.show.window import stage
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.subject import Paint
from hradiosity.show.window.vertices import swollen


@pytest.fixture
def off_screen(monkeypatch, device):
    """VTK draws with EGL, whatever display there is; PoCL comes first, since it aborts after Mesa's LLVM."""
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def strips(seed=2):
    """A plane at a slant, in strips of which each has other cells: corners lie on the edges of their neighbours."""
    rng = np.random.default_rng(seed)
    low = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 1.0, 30)), [1.0]])
    squares = [
        [(low[k], a), (low[k + 1], a), (low[k + 1], b), (low[k], b)]
        for k in range(31)
        for rows in [np.concatenate([[0.0], np.sort(rng.uniform(0.0, 1.0, 9)), [1.0]])]
        for a, b in pairwise(rows)
    ]
    flat = np.array(squares)
    corners = flat[..., :1] * [0.9, 0.3, 0.1] + flat[..., 1:] * [-0.3, 0.9, 0.2]
    n = len(corners)
    none = {f.name: np.zeros(n, np.int32) for f in fields(Cells)}
    shape = {"place": np.zeros((n, 4, 2), np.int32), "grid": np.ones((n, 2), np.int32)}
    return Cells(**{**none, **shape, "corners": corners, "is_triangle": np.zeros(n, np.bool_)})


def test_cells_are_drawn_a_hair_larger(room):
    for cells in (strips(), draw_scene(room).cells):
        drawn, count = swollen(cells), np.where(cells.is_triangle, 3, 4)
        moved = np.linalg.norm(drawn - cells.corners, axis=2)
        assert moved.min() > 0.0 and moved.max() < 1e-4 * scene_size(cells)
        np.testing.assert_array_equal(drawn[cells.is_triangle, 3], drawn[cells.is_triangle, 2])
        larger = replace(cells, corners=drawn)
        assert (larger.area > cells.area).all() and len(count) == len(cells)
        np.testing.assert_allclose(larger.normal, cells.normal, atol=1e-6)


@NEEDS_GL
def test_the_ground_does_not_shine_through_between_cells(off_screen, monkeypatch):
    """Of the pixels of a white plane none is dark; as the cells are, some would be."""
    assert dark_pixels(strips()) == 0
    monkeypatch.setattr(stage, "swollen", lambda cells: cells.corners)
    assert dark_pixels(strips()) > 0, "the test can fail"


def dark_pixels(cells):
    window, (renderer,) = stage.open_window(1, (900, 700), True)
    surface = stage.SurfaceActor(renderer, cells)
    surface.paint(Paint(np.full((len(cells), 3), 255, np.uint8)))
    centre, n, found = cells.corners.mean(axis=(0, 1)), cells.normal[0], 0
    for turn in np.arange(8) * 0.37:
        up = np.array([np.cos(turn), np.sin(turn), 0.0])
        aside = np.cross(n, up)
        position = centre + 0.35 * n + 0.05 * aside
        renderer.GetActiveCamera().SetPosition(*position)
        renderer.GetActiveCamera().SetFocalPoint(*centre)
        renderer.GetActiveCamera().SetViewUp(*up)
        renderer.ResetCameraClippingRange()
        found += int((plain_pixels(window)[250:450, 300:600].max(axis=2) < 250).sum())
    surface.remove()
    window.Finalize()
    return found


def plain_pixels(window):
    """Without smoothing, as a window that moves shows them."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    width, height, _ = grab.GetOutput().GetDimensions()
    return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(height, width, 3)
