"""Write scenes/office: a furnished office for twelve people, 6 × 4 × 3 m, at night.

    python examples/make_office.py [FOLDER]

The scene file in the repository is what this script writes. Sizes and places of books, chairs and papers vary, from
one seed. Reflectances are ColorChecker patches and the curves in ``spectra/``, which were made up to look like the
paints they are named after.
"""

import math
import sys
from pathlib import Path

import numpy as np
from furniture import DESK_DEPTH, DESK_WIDTH, Box, box, cabinet, ceiling_lamp, desk_island, placed, shelf
from scene_text import Curve, box_table, bump, sigmoid, write_spectra
from sensor_grid import clear_grid

WIDTH, DEPTH, HEIGHT = 6.0, 4.0, 3.0
ISLANDS = (1.85, 4.20)
"""x of the two desk islands [m]."""
ISLAND_Y = 1.53
LAMPS = ("cool_led", "violet_led", "tube")
"""Luminaires, from the left of the room to the right."""

CURVES: dict[str, tuple[str, Curve]] = {
    "wall": ("warm white wall paint", lambda w: (0.74 + 0.08 * sigmoid(w, 520, 60)) * sigmoid(w, 392, 9)),
    "ceiling": ("white ceiling paint", lambda w: 0.87 * sigmoid(w, 396, 8)),
    "carpet": ("blue-grey carpet", lambda w: 0.11 + 0.10 * bump(w, 455, 45) + 0.16 * sigmoid(w, 705, 18)),
    "beech": ("varnished beech", lambda w: 0.14 + 0.50 * sigmoid(w, 555, 55)),
    "oak": ("stained oak", lambda w: 0.07 + 0.33 * sigmoid(w, 610, 60)),
    "felt": ("green-blue felt", lambda w: 0.09 + 0.27 * bump(w, 508, 42) + 0.25 * sigmoid(w, 722, 14)),
    "fabric": ("dark red chair fabric", lambda w: 0.05 + 0.06 * bump(w, 435, 30) + 0.42 * sigmoid(w, 622, 16)),
    "lacquer": ("light grey lacquer", lambda w: (0.66 - 0.03 * sigmoid(w, 600, 80)) * sigmoid(w, 394, 8)),
    "paper": ("copying paper without brightener", lambda w: 0.89 * sigmoid(w, 386, 12) - 0.05 * bump(w, 430, 40)),
    "steel": ("brushed steel, as if matt", lambda w: 0.46 + 0.10 * (w - 380) / 400),
}  # fmt: skip

LIBRARY = {
    "white": "white 9.5", "graphite": "neutral 3.5", "screen": "black 2", "red": "red", "yellow": "yellow",
    "green": "green", "navy": "blue", "orange": "orange", "magenta": "magenta", "cyan": "cyan",
    "cream": "light skin", "olive": "foliage",
}  # fmt: skip


def furnished(rng: np.random.Generator, lamps: tuple[str, ...] = LAMPS) -> tuple[Box, ...]:
    """Furniture and lamps of a bay of 6 × 4 m: two islands of desks, two bookcases, a plant and two rows of lamps."""
    pieces: list[Box] = []
    for name, x in zip("ab", ISLANDS, strict=True):
        crowded = tuple(bool(c) for c in rng.permutation([True, True, True, False, False, False]))
        pieces += placed(desk_island(rng, crowded), f"island_{name}", x, ISLAND_Y)
    for k, y in enumerate((0.40, 1.50)):
        pieces += placed(shelf(rng), f"shelf{k}", 0.325, y, 90)
    plant = (
        box("pot", (-0.15, -0.15, 0), (0.30, 0.30, 0.32), "white"),
        box("leaves", (-0.2, -0.2, 0.32), (0.40, 0.40, 0.75), "olive"),
    )
    pieces += placed(plant, "plant", 0.35, 2.95, 8)
    for k, lamp in enumerate(lamps):
        for row, y in enumerate((1.0, 3.0)):
            pieces += placed(ceiling_lamp(lamp), f"ceiling{k}{row}", 1.0 + 2.0 * k, y, 0.0, HEIGHT)
    return tuple(pieces)


def cabinets() -> tuple[Box, ...]:
    """Three low cabinets along the wall at y = 4."""
    row = (placed(cabinet(), f"cabinet{k}", x, DEPTH - 0.44) for k, x in enumerate((0.90, 1.72, 2.54)))
    return tuple(piece for one in row for piece in one)


def on_the_cabinets() -> tuple[Box, ...]:
    """A printer, a plant and folders."""
    top = 0.72
    return (
        box("printer", (1.05, 3.62, top), (0.46, 0.34, 0.24), "lacquer"),
        box("printer_tray", (1.12, 3.545, top + 0.04), (0.32, 0.072, 0.012), "graphite"),
        box("planter", (1.98, 3.68, top), (0.30, 0.18, 0.14), "white"),
        box("hedge", (2.00, 3.70, top + 0.14), (0.26, 0.14, 0.22), "olive"),
        *(
            box(f"folder{k}", (2.70 + 0.08 * k, 3.66, top), (0.075, 0.28, 0.32), material)
            for k, material in enumerate(("graphite", "graphite", "red", "graphite", "navy"))
        ),
    )


def door() -> tuple[Box, ...]:
    """Door with its frame and handle on the wall at y = 4, x from 4.55 to 5.55."""
    thick = 0.05
    return (
        box("door_leaf", (4.65, DEPTH - 0.04, 0.006), (0.80, 0.04, 2.03), "oak"),
        box("door_handle", (4.70, DEPTH - 0.075, 1.02), (0.12, 0.035, 0.02), "steel"),
        box("door_frame_left", (4.58, DEPTH - thick, 0), (0.066, thick, 2.11), "white"),
        box("door_frame_right", (5.454, DEPTH - thick, 0), (0.066, thick, 2.11), "white"),
        box("door_frame_top", (4.646, DEPTH - thick, 2.04), (0.808, thick, 0.07), "white"),
    )


def window() -> tuple[Box, ...]:
    """Dark window on the wall at y = 0, two panes, its frame and sill, and a blind drawn up."""
    left, width, low, height, bar, deep = 1.0, 4.0, 1.20, 1.20, 0.06, 0.05
    half = (width - 3 * bar) / 2
    panes = [
        box(f"pane{k}", (left + bar + k * (half + bar), 0, low + bar), (half, 0.02, height - 2 * bar), "night_glass")
        for k in range(2)
    ]
    bars = [
        box(f"window_bar{k}", (left + k * (half + bar), 0, low + bar), (bar, deep, height - 2 * bar), "white")
        for k in range(3)
    ]
    return (
        *panes,
        *bars,
        box("window_bottom", (left, 0, low), (width, deep, bar), "white"),
        box("window_top", (left, 0, low + height - bar), (width, deep, bar), "white"),
        box("sill", (left - 0.05, 0, low - 0.03), (width + 0.10, 0.18, 0.03), "beech"),
        box("blind", (left - 0.02, 0, low + height + 0.01), (width + 0.04, 0.09, 0.10), "lacquer"),
    )


def on_the_walls() -> tuple[Box, ...]:
    """Skirting boards, a white board, posters, a cork board and a waste bin."""
    high, thick = 0.08, 0.012
    return (
        box("skirting_front", (0, 0, 0), (WIDTH, thick, high), "white"),
        box("skirting_back_left", (0, DEPTH - thick, 0), (4.575, thick, high), "white"),
        box("skirting_back_right", (5.525, DEPTH - thick, 0), (WIDTH - 5.525, thick, high), "white"),
        box("skirting_left", (0, thick, 0), (thick, DEPTH - 2 * thick, high), "white"),
        box("skirting_right", (WIDTH - thick, thick, 0), (thick, DEPTH - 2 * thick, high), "white"),
        box("white_board", (WIDTH - 0.025, 1.0, 0.95), (0.025, 1.8, 1.10), "white"),
        box("white_board_tray", (WIDTH - 0.085, 1.2, 0.92), (0.085, 1.4, 0.015), "steel"),
        box("poster_red", (1.10, DEPTH - 0.015, 1.35), (0.60, 0.015, 0.85), "red"),
        box("poster_yellow", (1.90, DEPTH - 0.015, 1.35), (0.60, 0.015, 0.85), "yellow"),
        box("poster_cyan", (2.70, DEPTH - 0.015, 1.35), (0.60, 0.015, 0.85), "cyan"),
        box("cork_board", (3.55, DEPTH - 0.02, 1.30), (0.80, 0.02, 0.95), "beech"),
        box("note0", (3.63, DEPTH - 0.022, 1.75), (0.21, 0.002, 0.297), "paper"),
        box("note1", (3.92, DEPTH - 0.022, 1.42), (0.297, 0.002, 0.21), "paper"),
        box("bin", (5.62, 3.62, 0), (0.26, 0.26, 0.34), "graphite"),
    )


def materials_text() -> str:
    """``[materials.…]`` tables of all paints."""
    files = [f'[materials.{name}]\nreflectance = {{ file = "spectra/{name}.csv" }}\n' for name in CURVES]
    library = [
        f'[materials.{name}]\nreflectance = {{ library = "colorchecker/{patch}" }}\n' for name, patch in LIBRARY.items()
    ]
    return "\n".join([*files, *library, "[materials.night_glass]\nreflectance = 0.06\n"])


def luminaires_text(flux: float) -> str:
    """``[luminaires.…]`` tables of the three lamps, each of ``flux`` lumens."""
    return "\n".join(
        f'[luminaires.{name}]\nspectrum = {{ illuminant = "{illuminant}" }}\nluminous_flux_lm = {flux}\n'
        for name, illuminant in zip(LAMPS, ("LED-B3", "LED-V1", "FL11"), strict=True)
    )


def seated_eyes() -> str:
    """``eye`` sensor: six people at their desks, looking at their monitors."""
    reach, pitch = 0.02 + DESK_DEPTH + 0.10, DESK_WIDTH + 0.01
    left, right = ISLANDS
    seats = [
        (left - reach, ISLAND_Y - pitch, 1),
        (left - reach, ISLAND_Y + pitch, 1),
        (left + reach, ISLAND_Y, -1),
        (right - reach, ISLAND_Y, 1),
        (right + reach, ISLAND_Y - pitch, -1),
        (right + reach, ISLAND_Y + pitch, -1),
    ]
    down = math.radians(10)
    positions = ",\n".join(f"    [{x:.2f}, {y:.2f}, 0.0]" for x, y, _ in seats)
    gazes = ",\n".join(f"    [{side * math.cos(down):.4f}, 0.0, {-math.sin(down):.4f}]" for *_, side in seats)
    return (
        f'[[sensor]]\nname = "eyes"\nkind = "eye"\npositions = [\n{positions},\n]\neye_height = 1.2\n'
        f"gazes = [\n{gazes},\n]\n"
    )


HEADER = """\
# A furnished office for twelve people at night. Written by examples/make_office.py: edit that, not this.

[scene]
title = "Office"
unit = "m"
up = "z"
"""

VIEWS = """\
[[view]]
name = "room"
position = [5.75, 3.75, 2.3]
target = [2.2, 1.2, 0.7]
field_of_view_deg = 80.0

[[view]]
name = "desk"
position = [0.85, 1.95, 1.35]
target = [1.55, 1.50, 0.76]
field_of_view_deg = 60.0
"""


def scene_text(seed: int = 1984) -> str:
    """The whole scene file."""
    room = f'[[box]]\nname = "room"\ncorner = [0.0, 0.0, 0.0]\nsize = [{WIDTH}, {DEPTH}, {HEIGHT}]\n'
    room += 'material = "wall"\nfaces = { bottom = "carpet", top = "ceiling" }\ninside = true\n'
    rng = np.random.default_rng(seed)
    pieces = (*furnished(rng), *cabinets(), *on_the_cabinets(), *door(), *window(), *on_the_walls())
    return "\n".join(
        [
            HEADER,
            materials_text(),
            luminaires_text(3400.0),
            room,
            *(box_table(piece) for piece in pieces),
            "# 380 points above the table tops, looking up.",
            clear_grid("desk", pieces, (0.5, 0.1, 0.8), (4.8, 3.4), (20, 19)),
            seated_eyes(),
            VIEWS,
        ]
    )


def write_office(folder: Path) -> None:
    """Write scene.toml and spectra/ into ``folder``."""
    write_spectra(folder / "spectra", CURVES)
    (folder / "scene.toml").write_text(scene_text(), encoding="utf-8")


if __name__ == "__main__":
    default = Path(__file__).resolve().parents[1] / "scenes" / "office"
    write_office(Path(sys.argv[1]) if len(sys.argv) > 1 else default)
