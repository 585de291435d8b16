"""Spectral radiosity for lighting research.

``load_scene(path)``, ``solve(scene, Options(…))``, ``audit(solution)`` and the values they deal in;
``compare(scene, [make_variant(scene, …)])`` for other paints and lamps; ``rate_glare(solution)`` for observers;
``gather_image(solution, device, view)`` for the light of every pixel;
``form_factor(a, b)`` and ``form_factor_matrix(polygons)`` for those who need no more; the layers below are there for
those who build on them.
Nothing heavy is imported before it is used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hradiosity.device import Device as Device
    from hradiosity.errors import SceneError as SceneError
    from hradiosity.io.scene_toml import load_scene as load_scene
    from hradiosity.model.variants import Factor as Factor
    from hradiosity.model.variants import make_variant as make_variant
    from hradiosity.options import Options as Options
    from hradiosity.radiosity import compare as compare
    from hradiosity.radiosity import solve as solve
    from hradiosity.radiosity.auditing import audit as audit
    from hradiosity.readings.glare import rate_glare as rate_glare
    from hradiosity.show.image import gather_image as gather_image
    from hradiosity.solution import Solution as Solution
    from hradiosity.transport.form_factor.interface import FormFactors as FormFactors
    from hradiosity.transport.form_factor.interface import form_factor as form_factor
    from hradiosity.transport.form_factor.interface import form_factor_matrix as form_factor_matrix

__version__ = "0.1.0"

_HOMES = {
    "Device": "hradiosity.device",
    "Factor": "hradiosity.model.variants",
    "FormFactors": "hradiosity.transport.form_factor.interface",
    "Options": "hradiosity.options",
    "SceneError": "hradiosity.errors",
    "Solution": "hradiosity.solution",
    "audit": "hradiosity.radiosity.auditing",
    "compare": "hradiosity.radiosity",
    "form_factor": "hradiosity.transport.form_factor.interface",
    "form_factor_matrix": "hradiosity.transport.form_factor.interface",
    "gather_image": "hradiosity.show.image",
    "load_scene": "hradiosity.io.scene_toml",
    "make_variant": "hradiosity.model.variants",
    "rate_glare": "hradiosity.readings.glare",
    "solve": "hradiosity.radiosity",
}

__all__ = [
    "Device",
    "Factor",
    "FormFactors",
    "Options",
    "SceneError",
    "Solution",
    "__version__",
    "audit",
    "compare",
    "form_factor",
    "form_factor_matrix",
    "gather_image",
    "load_scene",
    "make_variant",
    "rate_glare",
    "solve",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(home), name)


def __dir__() -> list[str]:
    return sorted(__all__)
