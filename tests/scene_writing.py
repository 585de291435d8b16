"""Small scene files for tests."""

from pathlib import Path

from hradiosity.errors import SceneError
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene

HEADER = '[scene]\nunit = "m"\n'
PAINT = "[materials.paint]\nreflectance = 0.5\n"
LAMP = "[luminaires.lamp]\nspectrum = { constant = 1.0 }\nabsolute = true\n"
FLOOR = """
[[rectangle]]
name = "floor"
corner = [0.0, 0.0, 0.0]
edge_u = [4.0, 0.0, 0.0]
edge_v = [0.0, 2.0, 0.0]
material = "paint"
"""
PANEL = """
[[rectangle]]
name = "panel"
corner = [0.0, 0.0, 3.0]
edge_u = [0.0, 1.0, 0.0]
edge_v = [1.0, 0.0, 0.0]
material = "paint"
luminaire = "lamp"
"""
OPEN_ROOM = HEADER + PAINT + LAMP + FLOOR + PANEL
"""A floor and a lamp above it; valid as it stands."""


def write(folder: Path, text: str) -> Path:
    """The scene file with this text."""
    file = folder / "scene.toml"
    file.write_text(text, encoding="utf-8")
    return file


def load(folder: Path, text: str) -> Scene:
    """The scene that this text describes."""
    return load_scene(write(folder, text))


def faults(folder: Path, text: str) -> list[str]:
    """All faults of this text, one sentence each; none if it is a valid scene."""
    try:
        load(folder, text)
    except SceneError as error:
        return [str(fault) for fault in error.faults]
    return []


def warnings(scene: Scene) -> list[str]:
    """What the scene warns of."""
    return [str(note) for note in scene.notes if note.kind == "warning"]
