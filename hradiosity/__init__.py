"""Spectral radiosity for lighting research.

``load_scene(path)``, ``solve(scene, Options(…))`` and the values they deal in; the layers below are there for those who
build on them. Nothing heavy is imported before it is used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hradiosity.device import Device as Device
    from hradiosity.errors import SceneError as SceneError
    from hradiosity.io.scene_toml import load_scene as load_scene
    from hradiosity.options import Options as Options
    from hradiosity.radiosity.solver import solve as solve
    from hradiosity.solution import Solution as Solution

__version__ = "0.1.0"

_HOMES = {
    "Device": "hradiosity.device",
    "Options": "hradiosity.options",
    "SceneError": "hradiosity.errors",
    "Solution": "hradiosity.solution",
    "load_scene": "hradiosity.io.scene_toml",
    "solve": "hradiosity.radiosity.solver",
}

__all__ = ["Device", "Options", "SceneError", "Solution", "__version__", "load_scene", "solve"]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(home), name)


def __dir__() -> list[str]:
    return sorted(__all__)
