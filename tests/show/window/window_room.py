"""A small room, solved and written to disk, for the tests of the window."""

import ctypes.util
import sys

import pytest
from small_room import SHELL

from hradiosity.options import Options

NEEDS_GL = pytest.mark.skipif(
    sys.platform.startswith("linux") and ctypes.util.find_library("EGL") is None,
    reason="drawing without a display needs libEGL (libegl1 and libgl1-mesa-dri in Debian)",
)
ROOM = f"""
[scene]
title = "Window <room>"
{SHELL}
[materials.screen]
reflectance = 0.5

[[polygon]]
name = "sail"
vertices = [[0.5, 1.5, 0.4], [1.0, 1.5, 0.4], [0.5, 1.5, 1.2]]
material = "screen"

[[sensor]]
name = "desk"
kind = "grid"
corner = [0.3, 0.3, 0.8]
edge_u = [2.4, 0.0, 0.0]
edge_v = [0.0, 1.4, 0.0]
counts = [3, 2]

[[sensor]]
name = "gaze"
kind = "luminance"
eye = [2.0, 1.0, 1.2]
targets = [[0.0, 1.0, 1.2], [1.0, 2.0, 1.0]]

[[view]]
name = "door"
position = [2.8, 0.2, 1.6]
target = [0.5, 1.5, 0.8]
size = [64, 48]

[[view]]
name = "corner"
position = [0.2, 0.2, 2.2]
target = [2.5, 1.8, 0.2]
size = [64, 48]
"""
QUICK = Options(
    element_size=0.4,
    rays_per_element=64,
    light_points=16,
    gather_samples=16,
    light_samples=8,
    replicates=2,
    refinement=False,
)
