"""What VTK draws: surfaces, marks and images over them, in one or two parts of a window."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells
from hradiosity.show.window.marks import Lines
from hradiosity.show.window.navigation import Pose
from hradiosity.show.window.picking import CutPlane
from hradiosity.show.window.subject import Paint
from hradiosity.show.window.vertices import swollen

Colour = tuple[float, float, float]
SKY_BLUE: Final[Colour] = (0.337, 0.706, 0.914)
ORANGE: Final[Colour] = (0.902, 0.624, 0.0)
PURPLE: Final[Colour] = (0.8, 0.475, 0.655)
"""Okabe & Ito's colours, which all eyes tell apart: sensors, lamps, cameras."""
YELLOW: Final[Colour] = (1.0, 0.92, 0.2)
SAMPLES: Final = 8
"""Of each pixel of a screenshot; a window that moves has one, which software draws three times as fast."""
_BACKS: Final[Colour] = (0.42, 0.44, 0.48)
_GROUND: Final[Colour] = (0.13, 0.14, 0.16)
LIGHT_LINE: Final[Colour] = (0.85, 0.85, 0.85)
DARK_LINE: Final[Colour] = (0.25, 0.25, 0.28)


class SurfaceActor:
    """All cells as one actor: colours of cells or corners, section, and backs.

    Parameters
    ----------
    renderer : vtkRenderer
    cells : Cells
    """

    def __init__(self, renderer: Any, cells: Cells) -> None:
        self._renderer = renderer
        count = np.where(cells.is_triangle, 3, 4)
        number = np.arange(4 * len(cells)).reshape(-1, 4)
        used = number[np.arange(4) < count[:, None]]
        self._mesh = mesh_of(swollen(cells).reshape(-1, 3), polygons=(used, count))
        self._actor = _surface(self._mesh)
        self._actor.GetProperty().BackfaceCullingOn()
        self._behind = _surface(self._mesh)
        self._behind.GetProperty().FrontfaceCullingOn()
        self._behind.GetProperty().SetColor(_BACKS)
        self._behind.GetMapper().ScalarVisibilityOff()
        self._behind.VisibilityOff()
        # Where one patch has cells on both sides, the coloured one wins.
        mapper = self._behind.GetMapper()
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 8.0)
        for actor in (self._behind, self._actor):
            renderer.AddActor(actor)

    def remove(self) -> None:
        """Take it off the stage."""
        for actor in (self._behind, self._actor):
            self._renderer.RemoveActor(actor)

    def paint(self, paint: Paint) -> None:
        """Show colours. Cells, too, have them at their corners: colours of cells are looked up for every pixel."""
        at_corners = paint.colours if paint.at_corners else np.repeat(paint.colours[:, None], 4, axis=1)
        mapper = self._actor.GetMapper()
        self._mesh.GetPointData().AddArray(_array(at_corners.reshape(-1, 3), "colours"))
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("colours")
        mapper.SetColorModeToDirectScalars()
        mapper.ScalarVisibilityOn()
        self._mesh.Modified()

    def cut(self, plane: CutPlane | None) -> None:
        """Hide what a section hides."""
        for actor in (self._actor, self._behind):
            _cut(actor.GetMapper(), plane)

    def show_backs(self, shown: bool) -> None:
        """Paint faces that look away in grey, or let one look through them."""
        self._behind.SetVisibility(shown)


class LinesActor:
    """Lines, or points, of one colour."""

    def __init__(self, renderer: Any, colour: Colour, *, width: float = 1.5, on_top: bool = False) -> None:
        self._mesh = mesh_of(np.zeros((0, 3)))
        self._actor = _surface(self._mesh)
        about = self._actor.GetProperty()
        about.SetColor(colour)
        about.SetLineWidth(width)
        about.SetPointSize(4.0 * width)
        if on_top:
            mapper = self._actor.GetMapper()
            mapper.SetResolveCoincidentTopologyToPolygonOffset()
            mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -4.0)
        renderer.AddActor(self._actor)

    def show_lines(self, lines: Lines) -> None:
        """Show these and no others."""
        points = np.stack([lines.start, lines.end], axis=1).reshape(-1, 3)
        self._set(mesh_of(points, lines=(np.arange(len(points)), np.full(len(lines.start), 2))))

    def show_points(self, points: NDArray[np.float64], colours: NDArray[np.uint8] | None = None) -> None:
        """Show these, each in its colour if there are colours (n, 3)."""
        mesh = mesh_of(points, vertices=(np.arange(len(points)), np.ones(len(points), np.int64)))
        mapper = self._actor.GetMapper()
        mapper.SetScalarVisibility(colours is not None)
        if colours is not None:
            mesh.GetPointData().SetScalars(_array(colours, "colours"))
            mapper.SetColorModeToDirectScalars()
        self._set(mesh)

    def hug_surfaces(self) -> None:
        """Lie a little less before surfaces than VTK's default: lines behind thin things would show through."""
        mapper = self._actor.GetMapper()
        mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, 2.0)

    def colour(self, colour: Colour) -> None:
        """Draw in another colour."""
        self._actor.GetProperty().SetColor(colour)

    def show(self, shown: bool) -> None:
        """Show it, or not."""
        self._actor.SetVisibility(shown)

    def cut(self, plane: CutPlane | None) -> None:
        """Hide what a section hides."""
        _cut(self._actor.GetMapper(), plane)

    def _set(self, mesh: Any) -> None:
        self._mesh = mesh
        self._actor.GetMapper().SetInputData(mesh)


class ImageActor:
    """An image over the picture, pixel by pixel."""

    def __init__(self, renderer: Any) -> None:
        from vtkmodules.vtkRenderingCore import vtkPolyDataMapper2D, vtkTexture, vtkTexturedActor2D

        self._mapper, self._texture, self._actor = vtkPolyDataMapper2D(), vtkTexture(), vtkTexturedActor2D()
        self._texture.InterpolateOff()
        self._actor.SetMapper(self._mapper)
        self._actor.SetTexture(self._texture)
        self._actor.VisibilityOff()
        renderer.AddViewProp(self._actor)

    def hide(self) -> None:
        """Show nothing."""
        self._actor.VisibilityOff()

    def show(self, pixels: NDArray[np.uint8], left: int, top: int, window_height: int) -> None:
        """Show pixels (h, w, 4) with their upper left corner at a place, in pixels from the window's upper left one."""
        from vtkmodules.vtkCommonDataModel import vtkImageData

        height, width = pixels.shape[:2]
        image = vtkImageData()
        image.SetDimensions(width, height, 1)
        image.GetPointData().SetScalars(_array(pixels[::-1].reshape(-1, 4), "pixels"))
        self._texture.SetInputData(image)
        low = window_height - top - height
        points = np.array([[left, low], [left + width, low], [left + width, low + height], [left, low + height]])
        corners = np.column_stack([points, np.zeros(4)]).astype(np.float64)
        quad = mesh_of(corners, polygons=(np.arange(4), np.array([4])))
        texture = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
        quad.GetPointData().SetTCoords(_array(texture, "texture"))
        self._mapper.SetInputData(quad)
        self._actor.VisibilityOn()


def place_camera(renderer: Any, pose: Pose, size: float) -> None:
    """Look from a pose at a scene of a size [m]."""
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*pose.position)
    camera.SetFocalPoint(*pose.focus)
    camera.SetViewUp(*pose.up)
    camera.SetViewAngle(float(np.degrees(pose.angle)))
    renderer.ResetCameraClippingRange()
    near, far = camera.GetClippingRange()
    camera.SetClippingRange(max(min(near, 0.01 * size), 2e-4 * size), max(far, size))


def new_ground(renderer: Any) -> None:
    """The colour behind everything."""
    renderer.SetBackground(*_GROUND)
    renderer.GradientBackgroundOff()


def open_window(n_parts: int, size: tuple[int, int], off_screen: bool) -> tuple[Any, list[Any]]:
    """A window, or none, and the renderers of its parts; its pixels have one sample each, as software draws it."""
    # Without these imports VTK has no classes that draw, and no letters.
    import vtkmodules.vtkInteractionStyle
    import vtkmodules.vtkRenderingFreeType
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

    window = vtkRenderWindow()
    window.SetOffScreenRendering(off_screen)
    window.SetSize(*size)
    window.SetMultiSamples(0)
    renderers = [vtkRenderer() for _ in range(n_parts)]
    for renderer in renderers:
        window.AddRenderer(renderer)
    return window, renderers


def window_pixels(window: Any) -> NDArray[np.uint8]:
    """(height, width, 3) what a window shows, with smooth edges."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    window.SetMultiSamples(SAMPLES)
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGB()
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    window.SetMultiSamples(0)
    to_numpy: Any = vtk_to_numpy
    flat: NDArray[np.uint8] = to_numpy(image.GetPointData().GetScalars())
    return flat.reshape(height, width, 3)[::-1].copy()


def _surface(mesh: Any) -> Any:
    """An actor that shines as it is painted, without lights."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    mapper.StaticOff()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    return actor


def _cut(mapper: Any, plane: CutPlane | None) -> None:
    from vtkmodules.vtkCommonDataModel import vtkPlane

    mapper.RemoveAllClippingPlanes()
    if plane is not None:
        cut = vtkPlane()
        cut.SetNormal(*(-plane.normal))
        cut.SetOrigin(*(plane.offset * plane.normal))
        mapper.AddClippingPlane(cut)


Cellular = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Numbers of the points of all cells in a row, and how many each cell has."""


def mesh_of(
    points: NDArray[np.float64],
    *,
    polygons: Cellular | None = None,
    lines: Cellular | None = None,
    vertices: Cellular | None = None,
) -> Any:
    """VtkPolyData of points (n, 3)."""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    mesh, places = vtkPolyData(), vtkPoints()
    places.SetData(_array(points.astype(np.float32), "points"))
    mesh.SetPoints(places)
    for given, put in ((polygons, mesh.SetPolys), (lines, mesh.SetLines), (vertices, mesh.SetVerts)):
        if given is not None:
            numbers, counts = given
            cells = vtkCellArray()
            offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
            cells.SetData(_array(offsets, "offsets"), _array(numbers.astype(np.int64), "points of cells"))
            put(cells)
    return mesh


def _array(values: NDArray[Any], name: str) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk

    to_vtk: Any = numpy_to_vtk
    array = to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    return array
