"""Write a hall of twenty open offices: 240 desks, 120 lamps, 39 000 faces and 5800 readings.

    python examples/make_open_plan.py FOLDER [COLUMNS ROWS]

COLUMNS and ROWS of bays, 5 and 4 if left out, make a smaller or a larger hall. The furniture is that of
``make_office.py``, arranged anew in each bay. The file is a megabyte long, which is why the repository holds this
script instead.
"""

import sys
from pathlib import Path

import numpy as np
from furniture import Box, box, placed
from make_office import CURVES, HEIGHT, ISLAND_Y, ISLANDS, cabinets, furnished, luminaires_text, materials_text
from scene_text import box_table, number, write_spectra
from sensor_grid import clear_grid

COLUMNS, ROWS = 5, 4
"""Bays along x and y."""
PITCH = (6.8, 5.2)
"""Distance of neighbouring bays along x and y [m]."""
MARGIN = 0.9

HEADER = """\
# A hall of twenty open offices. Written by examples/make_open_plan.py.

[scene]
title = "Open plan"
unit = "m"
up = "z"
"""


def hall_size(columns: int, rows: int) -> tuple[float, float]:
    """Extent of the hall along x and y [m]."""
    return 2 * MARGIN + columns * PITCH[0] - 0.8, 2 * MARGIN + rows * PITCH[1] - 1.2


def view(size: tuple[float, float]) -> str:
    """From above the corner at the origin to the middle of the hall."""
    return (
        '[[view]]\nname = "hall"\nposition = [0.4, 0.4, 2.7]\n'
        f"target = [{size[0] / 2:.1f}, {size[1] / 2:.1f}, 0.5]\nfield_of_view_deg = 80.0\n"
    )


def partitions() -> tuple[Box, ...]:
    """Screens as high as a person behind the bookcases and behind the desks of a bay."""
    thick, high = 0.04, 1.60
    return (
        box("partition_left", (-thick, -thick, 0), (thick, 4.0 + thick, high), "felt"),
        box("partition_front", (0, -thick, 0), (6.0, thick, high), "felt"),
    )


def column() -> tuple[Box, ...]:
    """A concrete column around the origin, floor to ceiling."""
    return (box("column", (-0.2, -0.2, 0), (0.4, 0.4, HEIGHT), "wall"),)


def bay_corner(column_number: int, row: int) -> tuple[float, float]:
    """Where a bay's origin lies in the hall [m]."""
    return MARGIN + column_number * PITCH[0], MARGIN + row * PITCH[1]


def bay(rng: np.random.Generator, column_number: int, row: int) -> tuple[tuple[Box, ...], str]:
    """Furniture of one bay, and its sensors: 289 points above the desks, and one pair of eyes."""
    x, y = bay_corner(column_number, row)
    name = f"bay{row}{column_number}"
    pieces = placed((*furnished(rng), *cabinets(), *partitions()), name, x, y)
    grid = clear_grid(f"{name}_desk", pieces, (x + 0.5, y + 0.1, 0.8), (4.8, 3.3), (17, 17))
    eye = f"[{number(x + ISLANDS[0] + 0.72)}, {number(y + ISLAND_Y)}, 0.0]"
    eyes = f'[[sensor]]\nname = "{name}_eye"\nkind = "eye"\npositions = [{eye}]\n'
    eyes += "eye_height = 1.2\ngaze = [-1.0, 0.0, -0.18]\n"
    return pieces, f"{grid}\n{eyes}"


def scene_text(columns: int = COLUMNS, rows: int = ROWS, seed: int = 1988) -> str:
    """The whole scene file."""
    rng = np.random.default_rng(seed)
    bays = [bay(rng, c, r) for r in range(rows) for c in range(columns)]
    posts: list[Box] = []
    for c in range(1, columns):
        for r in range(1, rows):
            x, y = bay_corner(c, r)
            posts += placed(column(), f"c{r}{c}", x - 0.4, y - 0.6)
    size = hall_size(columns, rows)
    hall = (
        f'[[box]]\nname = "hall"\ncorner = [0.0, 0.0, 0.0]\nsize = [{number(size[0])}, {number(size[1])}, {HEIGHT}]\n'
    )
    hall += 'material = "wall"\nfaces = { bottom = "carpet", top = "ceiling" }\ninside = true\n'
    furniture = [piece for pieces, _ in bays for piece in pieces]
    return "\n".join(
        [
            HEADER,
            materials_text(),
            luminaires_text(3400.0),
            hall,
            *(box_table(piece) for piece in (*furniture, *posts)),
            *(sensors for _, sensors in bays),
            view(size),
        ]
    )


def write_open_plan(folder: Path, columns: int = COLUMNS, rows: int = ROWS) -> None:
    """Write scene.toml and spectra/ into ``folder``."""
    write_spectra(folder / "spectra", CURVES)
    (folder / "scene.toml").write_text(scene_text(columns, rows), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 4):
        sys.exit("usage: python examples/make_open_plan.py FOLDER [COLUMNS ROWS]")
    write_open_plan(Path(sys.argv[1]), *(int(argument) for argument in sys.argv[2:]))
