"""Whether there is a display to open a window on."""

from __future__ import annotations

import os
import sys

from hradiosity.errors import Fault, SceneError


def has_display() -> bool:
    """Whether a window can be opened: on Linux, whether an X server answers."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY"))


def check_display() -> None:
    """Raise `SceneError` where there is no display.

    The X server is asked through a connection of its own, since VTK ends the process where none answers.
    """
    hint = "--screenshot FILE or --html FILE show it without one"
    if not has_display():
        raise SceneError([Fault("view", "", "there is no display (DISPLAY is not set)", hint)])
    if sys.platform.startswith("linux") and not _x_server_answers():
        found = f"the display {os.environ['DISPLAY']} does not answer"
        raise SceneError([Fault("view", "", found, hint)])


def _x_server_answers() -> bool:
    import ctypes
    import ctypes.util

    name = ctypes.util.find_library("X11") or "libX11.so.6"
    try:
        library = ctypes.CDLL(name)
    except OSError:
        return False
    library.XOpenDisplay.restype = ctypes.c_void_p
    library.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = library.XOpenDisplay(None)
    if not display:
        return False
    library.XCloseDisplay(display)
    return True
