"""Mouse, keys and time: from the window system to the viewer's methods."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

from hradiosity.show.window.keys import command_of
from hradiosity.show.window.viewer import Viewer

CLICK: Final = 4
"""Pixels by which the mouse may move while a button is down for that to be a click."""
TICK: Final = 0.25
"""Seconds between two looks at a run that is followed."""


class Events:
    """Listens to the window of a viewer.

    Parameters
    ----------
    viewer : Viewer
        With a window.
    tick : callable, optional
        Called four times a second.
    """

    def __init__(self, viewer: Viewer, tick: Callable[[], None] | None = None) -> None:
        self._viewer, self._tick = viewer, tick
        self._from: tuple[int, int] | None = None
        self._moved = 0
        self._moving = False
        self._drawing_due = False
        self._ticked = 0.0
        from vtkmodules.vtkRenderingCore import vtkRenderWindowInteractor

        # VTK's type hints know neither events by name nor that there may be no style.
        make: Any = vtkRenderWindowInteractor
        self._interactor = make()
        self._interactor.SetRenderWindow(viewer.window)
        self._interactor.SetInteractorStyle(None)
        handlers = {
            "LeftButtonPressEvent": lambda: self._press(move=bool(self._interactor.GetShiftKey())),
            "LeftButtonReleaseEvent": self._release,
            "MiddleButtonPressEvent": lambda: self._press(move=True),
            "MiddleButtonReleaseEvent": self._release,
            "MouseMoveEvent": self._move,
            "MouseWheelForwardEvent": lambda: viewer.wheel(1.0),
            "MouseWheelBackwardEvent": lambda: viewer.wheel(-1.0),
            "KeyPressEvent": self._key,
            "TimerEvent": self._on_time,
            "ConfigureEvent": viewer.resized,
            "ExitEvent": self._interactor.TerminateApp,
        }
        for name, handle in handlers.items():
            self._interactor.AddObserver(name, lambda _caller, _event, handle=handle: handle())

    def run(self) -> None:
        """Until the window is closed."""
        self._interactor.Initialize()
        self._interactor.CreateRepeatingTimer(round(1000.0 * TICK))
        self._viewer.redraw()
        self._interactor.Start()

    def _press(self, *, move: bool) -> None:
        self._from, self._moved, self._moving = self._interactor.GetEventPosition(), 0, move

    def _move(self) -> None:
        if self._from is None:
            return
        x, y = self._interactor.GetEventPosition()
        dx, dy = x - self._from[0], y - self._from[1]
        self._moved += abs(dx) + abs(dy)
        if self._moved > CLICK:
            self._from = x, y
            self._viewer.drag(dx, dy, move=self._moving, draw=False)
            self._draw_soon()

    def _release(self) -> None:
        if self._from is not None and self._moved <= CLICK:
            self._viewer.click(*self._interactor.GetEventPosition())
        self._from = None

    def _key(self) -> None:
        command = command_of(self._interactor.GetKeySym() or "")
        if command:
            self._viewer.command(command)
        if self._viewer.closed:
            self._interactor.TerminateApp()

    def _draw_soon(self) -> None:
        """Draw once all that the mouse did meanwhile is known: it moves more often than slow cards draw."""
        if not self._drawing_due:
            self._drawing_due = True
            self._interactor.CreateOneShotTimer(1)

    def _on_time(self) -> None:
        if self._drawing_due:
            self._drawing_due = False
            self._viewer.redraw()
        now = time.monotonic()
        if self._tick is not None and now - self._ticked > 0.8 * TICK:
            self._ticked = now
            self._tick()
