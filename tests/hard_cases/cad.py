"""Meshes as CAD programs export them, and rooms whose light is known whatever stands in them.

A surface of reflectance ρ that gives the exitance (1 - ρ) E makes, together with others of its kind around it, the
irradiance E at every place of a closed space, however the space is shaped. Faults of a model break that.
"""

import numpy as np

from hradiosity.io.scene_toml import load_scene
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene
from hradiosity.space.contact_cuts import cut_at_contacts
from hradiosity.space.lit_sides import find_lit_sides

EVEN = 10.0
"""Irradiance of the even field [W m⁻² in the one band]."""
HEADER = """
[scene]
title = "from CAD"
unit = "{unit}"
bands = {{ edges = [550, 560] }}
[materials]
wall = {{ reflectance = 0.6 }}
dark = {{ reflectance = 0.3 }}
black = {{ reflectance = 0.0 }}
[luminaires]
wall = {{ spectrum = {{ constant = 0.4 }}, absolute = true, sides = "{sides}" }}
dark = {{ spectrum = {{ constant = 0.7 }}, absolute = true, sides = "{sides}" }}
lamp = {{ spectrum = {{ constant = 1.0 }}, absolute = true }}
"""
FAST = Options(replicates=2, elements=600, rays_per_element=64, gather_samples=256, light_samples=16)


def header(unit="m", sides="front"):
    return HEADER.format(unit=unit, sides=sides)


def mesh(file, materials, luminaires=None, unit="m", extra=""):
    def table(entries):
        return "{ " + ", ".join(f'"{key}" = "{value}"' for key, value in entries.items()) + " }"

    return (
        f'[[mesh]]\nname = "cad"\nfile = "{file}"\nunit = "{unit}"\nup = "z"\nmaterials = {table(materials)}\n'
        f"luminaires = {table(luminaires or {})}\n{extra}\n"
    )


def points(positions, normal=(0, 0, 1)):
    listed = [list(map(float, place)) for place in positions]
    return f'[[sensor]]\nname = "eye"\nkind = "points"\npositions = {listed}\nnormal = {list(normal)}\n'


_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
_QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
"""Left, right, front, back, bottom, top; seen from outside."""


def block(low, high, inward=False):
    """(8, 3) corners and (12, 3) triangles of a box."""
    low, high = np.array(low, float), np.array(high, float)
    triangles = np.concatenate([_QUADS[:, [0, 1, 2]], _QUADS[:, [0, 2, 3]]])
    return low + _CORNERS * (high - low), triangles[:, ::-1] if inward else triangles


def joined(*shapes):
    """Several shapes as one."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in shapes)])
    return (
        np.concatenate([vertices for vertices, _ in shapes]),
        np.concatenate([faces + start for (_, faces), start in zip(shapes, first)]),
    )


def grid(corner, edge_u, edge_v, n):
    """A flat sheet of n × n squares, two triangles each."""
    u, v = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij")
    vertices = np.array(corner) + u.reshape(-1, 1) * np.array(edge_u) + v.reshape(-1, 1) * np.array(edge_v)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def write_obj(path, parts, factor=1.0, shift=0.0):
    """Named shapes into an OBJ file."""
    lines, first = [], 1
    for name, (vertices, faces) in parts.items():
        lines += map("v %.9g %.9g %.9g".__mod__, map(tuple, (np.asarray(vertices) * factor + shift).tolist()))
        lines.append(f"o {name}")
        lines += map("f %d %d %d".__mod__, map(tuple, (np.asarray(faces) + first).tolist()))
        first += len(vertices)
    path.write_text("\n".join(lines) + "\n")


def checked(device, folder):
    """The scene of a folder and what a check finds, as the command line does it."""
    scene = load_scene(folder)
    cut = cut_at_contacts(scene)
    lit = find_lit_sides(cut.scene, build_bvh(device, cut.scene.patches)).of_parents(cut.parent)
    return scene, check_scene(scene, build_bvh(device, scene.patches), lit)


def light(device, folder, options=FAST):
    """(n,) irradiance of the readings of the scene in a folder."""
    return solve(load_scene(folder), options, device).readings["eye"].irradiance[:, 0]


def grave(findings):
    return sorted({finding.kind for finding in findings if finding.severity != "info"})


def of_kind(findings, kind):
    return [finding for finding in findings if finding.kind == kind]
