"""One part of the window: the surfaces and marks of one subject, or of a difference."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Cells
from hradiosity.model.scene import View
from hradiosity.show.window.look import NO_LINES, Look, Section
from hradiosity.show.window.marks import (
    CAMERA,
    Lines,
    camera_lines,
    joined,
    lamp_lines,
    scene_size,
    sensor_lines,
    sensor_marks,
)
from hradiosity.show.window.navigation import Pose
from hradiosity.show.window.outlines import FacingOutlines, edge_ends, edge_flags
from hradiosity.show.window.picking import CutPlane, Picked
from hradiosity.show.window.stage import (
    DARK_LINE,
    LIGHT_LINE,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    YELLOW,
    LinesActor,
    SurfaceActor,
    new_ground,
    place_camera,
)
from hradiosity.show.window.subject import Paint, Subject

_LIGHT_LINES: Final = ("wireframe",)
"""Modes whose outlines are light: pictures have them so."""


class Stand:
    """Surfaces and marks of one subject in one renderer.

    Parameters
    ----------
    renderer : vtkRenderer
    subject : Subject
    """

    def __init__(self, renderer: Any, subject: Subject) -> None:
        self._renderer = renderer
        new_ground(renderer)
        self.subject = subject
        self._surface = SurfaceActor(renderer, subject.cells)
        self._outlines = LinesActor(renderer, DARK_LINE, width=1.0)
        self._outlines.hug_surfaces()
        self._outline_level: int | None = None
        self._facing: FacingOutlines | None = None
        self._sensors = LinesActor(renderer, SKY_BLUE)
        self._points = LinesActor(renderer, SKY_BLUE, width=1.6)
        self._lamps = LinesActor(renderer, ORANGE, width=2.0)
        self._cameras = LinesActor(renderer, PURPLE)
        self._chosen = LinesActor(renderer, YELLOW, width=2.5, on_top=True)
        self._seen_views: tuple[View, ...] | None = None
        self._place_marks()

    def take_subject(self, subject: Subject) -> None:
        """Show another mesh: what was drawn goes."""
        self._surface.remove()
        self.subject = subject
        self._surface = SurfaceActor(self._renderer, subject.cells)
        self._outline_level = None
        self._place_marks()

    @property
    def sensor_marks(self) -> NDArray[np.float64]:
        """(n, 3) where readings are picked [m]."""
        return self._marks

    @property
    def renderer(self) -> Any:
        """The vtkRenderer."""
        return self._renderer

    def show(self, look: Look, paint: Paint | None = None) -> None:
        """Show it as a look says, in the subject's own colours or in others."""
        self._surface.paint(self.subject.paint(look) if paint is None else paint)
        self._outline(look, paint is not None)
        self._surface.show_backs(look.backs)
        plane = cut_plane(self.subject.cells, look.section)
        self._surface.cut(plane)
        for actor in (self._outlines, self._sensors, self._points, self._lamps, self._cameras, self._chosen):
            actor.cut(plane)
        for actor in (self._sensors, self._points, self._lamps, self._cameras):
            actor.show(look.marks)
        self._colour_sensors(look)

    def mark(self, picked: Picked | None) -> None:
        """Draw around what was picked."""
        if picked is None:
            self._chosen.show_lines(joined())
        elif picked.kind == "sensor":
            size = 0.012 * scene_size(self.subject.cells)
            at = picked.point
            self._chosen.show_lines(joined(*(Lines(at - [size * axis], at + [size * axis]) for axis in np.eye(3))))
        else:
            self._chosen.show_lines(element_outline(self.subject.cells, picked.number))

    def look_from(self, pose: Pose) -> None:
        """Move the camera; the mark of a camera that one looks through would be in the way."""
        views, size = self.subject.drawn.views, scene_size(self.subject.cells)
        away = tuple(v for v in views if np.linalg.norm(v.position - pose.position) > 2.0 * CAMERA * size)
        if away != self._seen_views:
            self._seen_views = away
            self._cameras.show_lines(camera_lines(away, size))
        lines = None if self._facing is None else self._facing.seen_from(pose.position)
        if lines is not None:
            self._outlines.show_lines(lines)
        place_camera(self._renderer, pose, size)

    def _outline(self, look: Look, on_white: bool) -> None:
        """Choose outlines; which of them are seen is found where the camera is placed."""
        lined = look.lines != NO_LINES or (look.mode == "wireframe" and not on_white)
        self._outlines.show(lined)
        light = not on_white and (look.mode in _LIGHT_LINES or self.subject.values is not None)
        self._outlines.colour(LIGHT_LINE if light else DARK_LINE)
        level = max(look.lines, 0) if lined else None
        if level != self._outline_level:
            cells = self.subject.cells
            self._facing = None if level is None else FacingOutlines(cells, edge_flags(cells, level))
            self._outline_level = level

    def _place_marks(self) -> None:
        drawn = self.subject.drawn
        size = scene_size(drawn.cells)
        self._sensors.show_lines(sensor_lines(drawn))
        self._marks = sensor_marks(drawn)
        self._points.show_points(self._marks)
        self._lamps.show_lines(lamp_lines(drawn, size))
        self._seen_views = None
        self._chosen.show_lines(joined())

    def _colour_sensors(self, look: Look) -> None:
        """By their own illuminance where false colours stand for that."""
        sensors = self.subject.drawn.sensors
        told = sensors.numbers.get("illuminance_lx")
        if told is None or look.mode != "false-color" or look.quantity != "illuminance" or not len(sensors):
            self._points.show_points(self._marks)
            return
        colours = self.subject.colours_on_scale(told, look)
        colours[np.isnan(told)] = np.rint(255.0 * np.array(SKY_BLUE))
        self._points.show_points(self._marks, colours)


def cut_plane(cells: Cells, section: Section | None) -> CutPlane | None:
    """The plane of a section through all cells."""
    if section is None or not len(cells):
        return None
    low, high = (float(corner[section.axis]) for corner in cells.bounds)
    place = low + section.share * (high - low)
    normal = np.eye(3)[section.axis]
    return CutPlane(-normal, -place) if section.flipped else CutPlane(normal, place)


def element_outline(cells: Cells, cell: int) -> Lines:
    """Outlines of all cells of the element that a cell is part of, lifted a little towards who looks."""
    those = np.flatnonzero(cells.element == cells.element[cell])
    flags = edge_flags(cells, 0)[those].astype(np.bool_)
    lift = 5e-4 * scene_size(cells) * cells.normal[those][:, None, :]
    corners: NDArray[np.float64] = cells.corners[those] + lift
    return Lines(corners[flags], edge_ends(corners, cells.is_triangle[those])[flags])
