"""Spectral radiosity for lighting research.

``load_scene(path)``, ``solve(scene, Options(…))`` and the values they deal in; the layers below are there for those who
build on them. Nothing heavy is imported before it is used.
"""

import sys
from importlib import import_module
from types import ModuleType
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


class _Package(ModuleType):
    """The package itself, in which ``solve`` is the function, though the iterations are in a folder of that name.

    Importing that folder would put it in the function's place; ``from hradiosity.solve.krylov import …`` does not need
    the attribute.
    """

    @property
    def solve(self) -> Any:
        """`hradiosity.radiosity.solver.solve`."""
        return __getattr__("solve")

    @solve.setter
    def solve(self, folder: ModuleType) -> None:
        """Leave it as it is."""


sys.modules[__name__].__class__ = _Package
