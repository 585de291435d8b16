"""Small rooms for the checks: each test adds one thing that is wrong to a room that is sound."""

from hradiosity.io.scene_toml import load_scene
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene

HEADER = """
[scene]
unit = "m"
bands = { first = 400, last = 700, step = 50 }
[materials.paint]
reflectance = 0.5
[materials.other]
reflectance = 0.3
[materials.shield]
reflectance = 0.5
sides = "front"
[luminaires.lamp]
spectrum = { constant = 1.0 }
radiant_flux_W = 10.0
"""


def rectangle(name, corner, edge_u, edge_v, material="paint", luminaire=None):
    lamp = f'luminaire = "{luminaire}"\n' if luminaire else ""
    return (
        f'[[rectangle]]\nname = "{name}"\ncorner = {list(corner)}\nedge_u = {list(edge_u)}\nedge_v = {list(edge_v)}\n'
        f'material = "{material}"\n{lamp}'
    )


def box(name, corner, size, extra="", material="paint"):
    return f'[[box]]\nname = "{name}"\ncorner = {list(corner)}\nsize = {list(size)}\nmaterial = "{material}"\n{extra}\n'


def points(name, positions, normal=(0.0, 0.0, 1.0)):
    listed = [list(position) for position in positions]
    return f'[[sensor]]\nname = "{name}"\nkind = "points"\npositions = {listed}\nnormal = {list(normal)}\n'


def camera(name, position, target):
    return f'[[view]]\nname = "{name}"\nposition = {list(position)}\ntarget = {list(target)}\nsize = [32, 24]\n'


ROOM = HEADER + box("room", (0, 0, 0), (4, 3, 2.5), "inside = true")
LAMP = rectangle("panel", (1.5, 1.0, 2.3), (0, 0.5, 0), (0.5, 0, 0), luminaire="lamp")
"""Faces down, 0.2 m below the ceiling."""
SOUND = ROOM + LAMP


def findings(device, folder, text):
    """All findings about the scene of this text."""
    file = folder / "scene.toml"
    file.write_text(text, encoding="utf-8")
    scene = load_scene(file)
    return check_scene(scene, build_bvh(device, scene.patches))


def of_kind(found, kind):
    return [finding for finding in found if finding.kind == kind]


def grave(found):
    """Kinds of all faults and warnings."""
    return sorted(finding.kind for finding in found if finding.severity != "info")
