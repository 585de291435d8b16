"""Rooms that are hard to light well."""

from __future__ import annotations

import numpy as np

from hradiosity.suites.coverage.writing import DOWN, UP, block, entry, grid, lamp, points, room, scene_text

LED = {"spectrum": {"illuminant": "LED-B3"}}
PAINTS = {
    "wall": {"library": "cornell/white"},
    "ceiling": {"library": "colorchecker/white 9.5"},
    "floor": {"library": "colorchecker/orange yellow"},
    "wood": {"library": "colorchecker/light skin"},
    "blue": {"library": "colorchecker/blue sky"},
    "green": {"library": "colorchecker/foliage"},
    "metal": 0.6,
    "dark": 0.05,
}
OFF = 0.001
"""Distance of readings from the surfaces that they lie on [m]."""


def corridor() -> str:
    """20 m long, 1 m wide; the light falls by four orders of magnitude."""
    along = [0.5 + i for i in range(20)]
    entries = [
        room((20.0, 1.0, 2.4), sides="wall", top="ceiling", bottom="floor"),
        lamp((0.3, 0.35, 2.38), 0.6, 0.3, "metal", "lamp"),
        points("floor", [(x, 0.5, OFF) for x in along], UP),
        points("foot of the wall", [(x, 0.01, OFF) for x in along[::3]], UP),
        points("end wall", [(20.0 - OFF, y, z) for y in (0.02, 0.5) for z in (0.02, 1.2, 2.38)], (-1, 0, 0)),
        points("eyes", [(x, 0.5, 1.6) for x in along[1::4]], (-1, 0, 0)),
        points("eyes away", [(x, 0.5, 1.6) for x in along[1::4]], (1, 0, 0)),
    ]
    return scene_text("Corridor", PAINTS, {"lamp": {**LED, "radiant_flux_W": 9.375}}, entries)


def louvres() -> str:
    """A lamp above crossed slats, so that every reading sees it in pieces."""
    pitch, high, z = 0.15, 0.12, 2.8
    across = [1.4 + pitch * i for i in range(9)]
    slats = [
        *(_sheet((x, 1.4, z), (0, 1.2, 0), (0, 0, high), "metal") for x in across),
        *(_sheet((1.4, y, z), (1.2, 0, 0), (0, 0, high), "metal") for y in across),
    ]
    entries = [
        room((4.0, 4.0, 3.0), sides="wall", top="ceiling", bottom="floor"),
        lamp((1.4, 1.4, 2.97), 1.2, 1.2, "metal", "lamp"),
        *slats,
        grid("floor", (0.0, 0.0, OFF), (4.0, 0, 0), (0, 4.0, 0), (5, 5)),
        points("below the slats", [(x, 1.93, 2.6) for x in (1.45, 1.6, 1.83, 2.0, 2.3, 2.58)], UP),
        points("wall", [(OFF, 1.7, z) for z in (0.05, 0.8, 1.6, 2.2, 2.5, 2.7, 2.95)], (1, 0, 0)),
        points("ceiling", [(x, x, 3.0 - OFF) for x in (0.05, 0.5, 1.0, 1.3)], DOWN),
    ]
    return scene_text("Louvres", PAINTS, {"lamp": {**LED, "radiant_flux_W": 18.75}}, entries)


def bright(reflectance: float) -> str:
    """A furnished room whose paints reflect nearly everything, each with other colours."""

    def paint(*losses: float) -> dict[str, list[list[float]]]:
        edges = (377.5, 477.5, 577.5, 677.5, 782.5)
        rows = zip(edges, edges[1:], losses)
        return {"steps": [[low, high, 1.0 - loss * (1.0 - reflectance)] for low, high, loss in rows]}

    paints = {
        "wall": paint(2, 1, 1.5, 1),
        "floor": paint(3, 2, 1, 1),
        "wood": paint(5, 3, 2, 1),
        "metal": paint(*[1] * 4),
    }
    entries = [
        room((5.0, 4.0, 2.8), sides="wall", top="wall", bottom="floor"),
        lamp((2.0, 1.6, 2.77), 0.9, 0.6, "metal", "lamp"),
        block((1.6, 1.4, 1.0), (1.4, 0.8, 0.04), "wood"),
        block((3.4, 1.2, 0.8), (0.5, 0.5, 1.0), "wood"),
        block((0.0, 3.5, 0.0), (1.2, 0.5, 1.6), "wood"),
        grid("table", (1.6, 1.4, 1.04), (1.4, 0, 0), (0, 0.8, 0), (4, 3), height=OFF),
        points("below", [(2.3, 1.8, 0.99), (1.65, 1.45, 0.99), (3.6, 1.4, 0.79), (3.89, 1.69, 0.79)], DOWN),
        grid("floor", (0.0, 0.0, OFF), (5.0, 0, 0), (0, 3.5, 0), (4, 3)),
        points("corners", [(0.01, 0.01, OFF), (1.21, 3.99, OFF), (4.99, 3.99, OFF), (1.205, 3.6, OFF)], UP),
    ]
    title = f"Furnished, reflectance {reflectance:g}"
    return scene_text(title, paints, {"lamp": {**LED, "radiant_flux_W": 12.5}}, entries)


def spot() -> str:
    """A lamp in a deep black tube that shines on a small part of the ceiling, which lights all else."""
    low, size, deep = 1.93, 0.14, 0.35
    far = low + size
    entries = [
        room((4.0, 4.0, 2.8), sides="wall", top="ceiling", bottom="floor"),
        lamp((low, low, 1.2), size, size, "metal", "lamp", up=True),
        _sheet((low, low, 1.2), (size, 0, 0), (0, 0, deep), "dark"),
        _sheet((low, far, 1.2), (size, 0, 0), (0, 0, deep), "dark"),
        _sheet((low, low, 1.2), (0, size, 0), (0, 0, deep), "dark"),
        _sheet((far, low, 1.2), (0, size, 0), (0, 0, deep), "dark"),
        grid("floor", (0.0, 0.0, OFF), (4.0, 0, 0), (0, 4.0, 0), (4, 4)),
        points("ceiling", [(2.0 + d, 2.03, 2.8 - OFF) for d in (0.0, 0.2, 0.3, 0.45, 0.6, 0.9, 1.95)], DOWN),
        points("wall", [(OFF, 2.2, z) for z in (0.02, 1.0, 2.0, 2.6, 2.78)], (1, 0, 0)),
        points("eyes", [(1.0, 1.0, 1.6), (3.0, 1.0, 1.6), (0.3, 3.7, 1.2)], [(1, 1, 0.2), (-1, 1, 0), (1, -1, 0)]),
        points("beside the tube", [(1.9, 2.0, 1.5), (1.9, 2.0, 1.0)], [(-1, 0, 0), DOWN]),
    ]
    return scene_text("Spot", PAINTS, {"lamp": {**LED, "radiant_flux_W": 25}}, entries)


def lines() -> str:
    """Saturated paints under lamps of a few lines each: the colours of neighbouring bands have nothing in common."""
    paints = {
        "red": {"library": "colorchecker/red"},
        "green": {"library": "colorchecker/green"},
        "blue": {"library": "colorchecker/blue"},
        "yellow": {"library": "colorchecker/yellow"},
        "band": {"steps": [[380, 430, 0.05], [430, 442, 0.8], [442, 570, 0.04], [570, 583, 0.7], [583, 780, 0.1]]},
        "white": {"library": "colorchecker/white 9.5"},
    }
    mercury = [(404.66, 0.4), (435.83, 1.0), (546.07, 1.2), (576.96, 0.5), (579.07, 0.5), (690.7, 0.06)]
    sodium = [(498.3, 0.05), (568.5, 0.15), (589.0, 1.0), (589.6, 0.9), (616.0, 0.1), (766.5, 0.2)]
    lamps = {
        "mercury": {"spectrum": {"lines": mercury}, "radiant_flux_W": 7.812},
        "sodium": {"spectrum": {"lines": sodium}, "radiant_flux_W": 6.25},
    }
    faces = {"left": "red", "right": "green", "front": "blue", "back": "band", "top": "white", "bottom": "yellow"}
    entries = [
        room((4.0, 3.0, 2.7), **faces),
        lamp((0.6, 1.2, 2.67), 0.3, 0.6, "white", "mercury"),
        lamp((3.1, 1.2, 2.67), 0.3, 0.6, "white", "sodium"),
        block((1.7, 0.9, 0.0), (0.6, 1.2, 0.9), "band"),
        grid("floor", (0.0, 0.0, OFF), (1.7, 0, 0), (0, 3.0, 0), (3, 4)),
        grid("block", (1.7, 0.9, 0.9), (0.6, 0, 0), (0, 1.2, 0), (3, 3), height=OFF),
        points("side walls", [(OFF, 1.5, 1.3), (4 - OFF, 1.5, 1.3)], [(1, 0, 0), (-1, 0, 0)]),
        points("other walls", [(2, OFF, 2.0), (2, 3 - OFF, 0.3)], [(0, 1, 0), (0, -1, 0)]),
        points("corners", [(1.695, 1.5, OFF), (0.01, 0.01, OFF), (3.99, 2.99, OFF)], UP),
        points("ceiling", [(2.0, 1.5, 2.7 - OFF), (0.3, 0.3, 2.7 - OFF)], DOWN),
    ]
    return scene_text("Lines", paints, lamps, entries)


def clutter() -> str:
    """A hundred small things on a table and on the floor; readings between them, at the corners of their cells."""
    random = np.random.default_rng(7)
    names = ("wood", "blue", "green", "metal", "dark", "wall")
    things = [
        *_scattered(random, (1.2, 1.4, 0.74), (0.16, 0.1), (10, 8), (0.02, 0.15), names),
        *_scattered(random, (0.3, 2.6, 0.0), (0.4, 0.3), (8, 4), (0.05, 0.5), names),
    ]
    entries = [
        room((4.0, 4.0, 2.8), sides="wall", top="ceiling", bottom="floor"),
        lamp((1.0, 1.2, 2.77), 1.2, 0.3, "metal", "lamp"),
        block((1.2, 1.4, 0.7), (1.6, 0.8, 0.04), "wood"),
        *things,
        points(
            "table", [(1.2 + 0.16 * i, 1.4 + 0.1 * j, 0.74 + OFF) for i in (1, 3, 5, 7, 9) for j in (1, 3, 5, 7)], UP
        ),
        points("floor", [(0.3 + 0.4 * i, 2.6 + 0.3 * j, OFF) for i in (1, 3, 5, 7) for j in (1, 2, 3)], UP),
        points("above", [(1.2 + 0.4 * i, 1.8, 1.1) for i in range(5)], UP),
        points("below the table", [(1.3, 1.5, OFF), (2.0, 1.8, OFF), (2.0, 1.8, 0.69)], [UP, UP, DOWN]),
    ]
    return scene_text("Clutter", PAINTS, {"lamp": {**LED, "radiant_flux_W": 12.5}}, entries)


def slots() -> str:
    """Readings where little light comes: between cupboards, below them, under a desk, in corners."""
    entries = [
        room((4.0, 4.0, 2.8), sides="wall", top="ceiling", bottom="floor"),
        lamp((1.7, 1.4, 2.77), 0.6, 1.2, "metal", "lamp"),
        block((0.5, 3.45, 0.0), (0.8, 0.5, 1.8), "wood"),
        block((1.35, 3.45, 0.0), (0.8, 0.5, 1.8), "blue"),
        block((2.6, 3.4, 0.03), (1.0, 0.6, 1.0), "green"),
        block((0.0, 0.6, 0.7), (0.8, 1.6, 0.03), "wood"),
        block((0.05, 0.62, 0.0), (0.7, 0.03, 0.7), "metal"),
        block((0.3, 1.0, 0.73), (0.2, 0.3, 0.02), "dark"),
        points("in the slot", [(1.31, y, z) for y in (3.48, 3.6, 3.8, 3.9) for z in (0.05, 0.9, 1.7)], (0, -1, 0)),
        points("below the cupboard", [(3.1, y, OFF) for y in (3.38, 3.41, 3.45, 3.55, 3.8, 3.99)], UP),
        points("under the desk", [(x, y, OFF) for x in (0.02, 0.4, 0.78) for y in (0.66, 1.2, 2.1)], UP),
        points("desk", [(0.29, 1.1, 0.73 + OFF), (0.505, 1.15, 0.73 + OFF), (0.7, 2.0, 0.73 + OFF)], UP),
        points("contacts", [(2.0, 3.445, OFF), (0.005, 0.005, OFF), (3.995, 2.0, OFF), (0.06, 0.66, OFF)], UP),
        points("behind", [(0.9, 3.97, 1.0), (1.75, 3.97, 0.05)], (0, -1, 0)),
    ]
    return scene_text("Slots", PAINTS, {"lamp": {**LED, "radiant_flux_W": 12.5}}, entries)


def _sheet(corner: tuple[float, ...], edge_u: tuple[float, ...], edge_v: tuple[float, ...], material: str) -> str:
    return entry("rectangle", corner=corner, edge_u=edge_u, edge_v=edge_v, material=material)


def _scattered(
    random: np.random.Generator,
    corner: tuple[float, float, float],
    cell: tuple[float, float],
    counts: tuple[int, int],
    heights: tuple[float, float],
    materials: tuple[str, ...],
) -> list[str]:
    """Blocks, each inside its own cell of a grid."""
    things = []
    for i, j in np.ndindex(*counts):
        size = np.array(cell) * random.uniform(0.25, 0.8, 2)
        place = np.array(cell) * (i, j) + (np.array(cell) - size) * random.uniform(0.1, 0.9, 2)
        height, material = float(random.uniform(*heights)), materials[random.integers(len(materials))]
        where = (corner[0] + float(place[0]), corner[1] + float(place[1]), corner[2])
        things.append(block(where, (float(size[0]), float(size[1]), height), material))
    return things
