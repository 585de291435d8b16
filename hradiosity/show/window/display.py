"""Whether there is a display to open a window on."""

from __future__ import annotations

import os
import sys
from typing import Any

from hradiosity.errors import Fault, SceneError


def has_display() -> bool:
    """Whether a display is named; elsewhere than on Linux there always is one."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY"))


def check_display(hint: str = "--screenshot FILE or --html FILE show it without one") -> None:
    """Raise `SceneError` where there is no display; the hint tells what to do then.

    The X server is asked through a connection of its own, since VTK ends the process where none answers.
    """
    if not has_display():
        raise SceneError([Fault("view", "", "there is no display (DISPLAY is not set)", hint)])
    if sys.platform.startswith("linux") and not _x_server_answers():
        found = f"the display {os.environ['DISPLAY']} does not answer"
        raise SceneError([Fault("view", "", found, hint)])


def use_off_screen() -> None:
    """Let VTK draw without a display: by EGL where that is installed, or else by an X server without a window.

    Raises
    ------
    SceneError
        Where there is neither: VTK would end the process.
    """
    if not sys.platform.startswith("linux") or "VTK_DEFAULT_OPENGL_WINDOW" in os.environ:
        return
    if _library("EGL", "libEGL.so.1") is not None:
        os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    elif not (has_display() and _x_server_answers()):
        hint = "in Debian: apt-get install libegl1 libgl1-mesa-dri; --html FILE needs none"
        raise SceneError([Fault("view", "--screenshot", "there is neither libEGL nor a display", hint)])


def _library(name: str, file: str) -> Any:
    """A library of the system, None where it is missing."""
    import ctypes
    import ctypes.util

    try:
        return ctypes.CDLL(ctypes.util.find_library(name) or file)
    except OSError:
        return None


def _x_server_answers() -> bool:
    import ctypes

    library = _library("X11", "libX11.so.6")
    if library is None:
        return False
    library.XOpenDisplay.restype = ctypes.c_void_p
    library.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = library.XOpenDisplay(None)
    if not display:
        return False
    library.XCloseDisplay(display)
    return True
