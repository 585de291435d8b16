"""Office furniture made of boxes, for the scenes that the scripts beside this file write.

Every piece is a tuple of `Box` in a frame of its own: x to the right, y away from the person who uses it, z up, the
floor at z = 0, metres. `placed` turns and moves a piece to where it stands. Pieces touch where real ones do (a leg and
the floor), and nowhere else do two surfaces share a plane.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

DESK_WIDTH = 0.94
DESK_DEPTH = 0.60
DESK_HEIGHT = 0.745
SHELF_WIDTH = 1.00
BINDINGS = ("red", "yellow", "green", "navy", "orange", "magenta", "cyan", "cream", "graphite", "olive")
"""Materials that books and folders are bound in."""


@dataclass(frozen=True)
class Box:
    """A box, turned about the vertical axis through its centre.

    centre, size : three lengths [m]
    turn : angle from the x axis towards the y axis [degrees]
    faces : other materials of single faces, as pairs of face and material
    lamp : luminaire of the bottom face, if that gives light
    """

    name: str
    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    material: str
    turn: float = 0.0
    faces: tuple[tuple[str, str], ...] = ()
    lamp: str | None = None


def box(name: str, low: tuple[float, float, float], size: tuple[float, float, float], material: str) -> Box:
    """Box from its lowest corner and its size [m]."""
    centre = (low[0] + size[0] / 2, low[1] + size[1] / 2, low[2] + size[2] / 2)
    return Box(name, centre, size, material)


def length(rng: np.random.Generator, low: float, high: float) -> float:
    """Random length in whole millimetres [m]: pieces that stand on each other then meet exactly in the file too."""
    return round(float(rng.uniform(low, high)), 3)


def placed(
    pieces: Iterable[Box], prefix: str, x: float, y: float, turn: float = 0.0, z: float = 0.0
) -> tuple[Box, ...]:
    """Pieces turned about their own vertical axis by ``turn`` degrees, then moved by (x, y, z) metres."""
    cosine, sine = math.cos(math.radians(turn)), math.sin(math.radians(turn))

    def moved(piece: Box) -> Box:
        px, py, pz = piece.centre
        centre = (x + cosine * px - sine * py, y + sine * px + cosine * py, z + pz)
        return replace(piece, name=f"{prefix}_{piece.name}", centre=centre, turn=piece.turn + turn)

    return tuple(moved(piece) for piece in pieces)


def desk() -> tuple[Box, ...]:
    """Table top on four legs; the person sits at y < 0, the top covers y from 0 to its depth."""
    thickness, leg, inset = 0.025, 0.045, 0.03
    under = DESK_HEIGHT - thickness
    top = box("top", (-DESK_WIDTH / 2, 0, under), (DESK_WIDTH, DESK_DEPTH, thickness), "beech")
    left, right = -DESK_WIDTH / 2 + inset, DESK_WIDTH / 2 - inset - leg
    near, far = inset, DESK_DEPTH - inset - leg
    corners = [(left, near), (right, near), (left, far), (right, far)]
    return (top, *(box(f"leg{k}", (x, y, 0), (leg, leg, under), "steel") for k, (x, y) in enumerate(corners)))


def chair() -> tuple[Box, ...]:
    """Seat, low back (0.78 m) and four legs around the origin; the person looks along y."""
    width, leg, inset, seat = 0.44, 0.035, 0.02, 0.43
    low, high = -width / 2 + inset, width / 2 - inset - leg
    corners = [(low, low), (high, low), (low, high), (high, high)]
    return (
        box("seat", (-width / 2, -width / 2, seat), (width, width, 0.05), "fabric"),
        box("back", (-0.20, -width / 2 + 0.01, seat + 0.05), (0.40, 0.04, 0.30), "fabric"),
        *(box(f"leg{k}", (x, y, 0), (leg, leg, seat), "steel") for k, (x, y) in enumerate(corners)),
    )


def monitor() -> tuple[Box, ...]:
    """Screen on a post and a foot, standing at z = 0 and facing the person at y < 0."""
    panel = box("panel", (-0.27, -0.015, 0.11), (0.54, 0.03, 0.33), "graphite")
    return (
        box("foot", (-0.11, -0.07, 0), (0.22, 0.16, 0.012), "graphite"),
        box("post", (-0.025, -0.01, 0.012), (0.05, 0.02, 0.098), "steel"),
        replace(panel, faces=(("front", "screen"),)),
    )


def desk_things(rng: np.random.Generator, crowded: bool) -> tuple[Box, ...]:
    """Monitor, keyboard and, on a crowded desk, mouse, mug, papers and a book, on the table top of `desk`."""
    shift = 0.02 + rng.uniform(-0.025, 0.025)
    turn = rng.uniform(-7, 7)
    things = [
        *placed(monitor(), "monitor", shift, 0.42, turn, DESK_HEIGHT),
        *placed(
            [box("keyboard", (-0.21, -0.07, 0), (0.42, 0.14, 0.018), "graphite")],
            "set", shift, 0.15, turn / 2, DESK_HEIGHT,
        ),
    ]  # fmt: skip
    if crowded:
        binding = str(rng.choice(BINDINGS))
        loose = [
            (box("mouse", (-0.03, -0.05, 0), (0.06, 0.10, 0.03), "graphite"), 0.31, 0.15),
            (box("mug", (-0.04, -0.04, 0), (0.08, 0.08, 0.09), str(rng.choice(("white", "red", "cyan")))), 0.40, 0.34),
            (box("papers", (-0.105, -0.148, 0), (0.21, 0.297, length(rng, 0.004, 0.03)), "paper"), -0.355, 0.17),
            (box("book", (-0.07, -0.10, 0), (0.14, 0.20, length(rng, 0.012, 0.04)), binding), -0.38, 0.475),
        ]
        for piece, x, y in loose:
            things += placed([piece], "on", x, y, rng.uniform(-3, 3), DESK_HEIGHT)
    return tuple(things)


def workplace(rng: np.random.Generator, crowded: bool) -> tuple[Box, ...]:
    """Desk with its things and a chair that somebody left a little askew."""
    back = rng.uniform(0.12, 0.22)
    seat = placed(chair(), "chair", rng.uniform(-0.05, 0.05), -back, rng.uniform(-14, 14))
    return (*placed(desk(), "desk", 0, 0), *seat, *desk_things(rng, crowded))


def books(rng: np.random.Generator, width: float, fill: float) -> tuple[Box, ...]:
    """A row of standing books from x = 0, spines towards y = 0, with gaps of 1 to 3 mm.

    width : length of the board [m]
    fill : share of it to fill
    """
    row: list[Box] = []
    x = 0.004
    while True:
        thickness, height, depth = length(rng, 0.035, 0.1), length(rng, 0.2, 0.29), length(rng, 0.16, 0.22)
        if x + thickness > fill * width - 0.002:
            return tuple(row)
        low = (x, length(rng, 0.0, 0.02), 0.0)
        row.append(box(f"book{len(row)}", low, (thickness, depth, height), str(rng.choice(BINDINGS))))
        x += thickness + length(rng, 0.001, 0.003)


def shelf(rng: np.random.Generator, levels: int = 4) -> tuple[Box, ...]:
    """Bookcase, x from 0 to its width, opening at y = 0, its back at y = 0.306, filled with books."""
    side, depth, clear, board = 0.02, 0.30, 0.32, 0.02
    inner = SHELF_WIDTH - 2 * side
    height = levels * (clear + board) + board
    pieces = [
        box("left", (0, 0, 0), (side, depth, height), "beech"),
        box("right", (SHELF_WIDTH - side, 0, 0), (side, depth, height), "beech"),
        box("back", (0, depth, 0), (SHELF_WIDTH, 0.006, height), "beech"),
    ]
    for level in range(levels + 1):
        z = level * (clear + board)
        pieces.append(box(f"board{level}", (side, 0.004, z), (inner, depth - 0.004, board), "beech"))
        if level < levels:
            row = books(rng, inner, rng.uniform(0.35, 0.95))
            pieces += placed(row, f"row{level}", side, 0.03, 0.0, z + board)
    return tuple(pieces)


def cabinet() -> tuple[Box, ...]:
    """Low cabinet, x from 0 to 0.8, two doors with handles towards y = 0, a top and a plinth."""
    width, depth, height = 0.80, 0.42, 0.70
    pieces = [
        box("plinth", (0.02, 0.04, 0), (width - 0.04, depth - 0.05, 0.06), "graphite"),
        box("body", (0, 0.02, 0.06), (width, depth - 0.02, height - 0.06), "lacquer"),
        box("top", (-0.005, -0.005, height), (width + 0.01, depth + 0.005, 0.02), "beech"),
    ]
    for k, x in enumerate((0.003, width / 2 + 0.0015)):
        pieces.append(box(f"door{k}", (x, 0.002, 0.065), (width / 2 - 0.0045, 0.018, height - 0.07), "lacquer"))
    for k, x in enumerate((width / 2 - 0.055, width / 2 + 0.04)):
        pieces.append(box(f"handle{k}", (x, -0.016, 0.45), (0.015, 0.018, 0.14), "steel"))
    return tuple(pieces)


def ceiling_lamp(lamp: str) -> tuple[Box, ...]:
    """Panel luminaire around the origin, 6 cm high, to hang under a ceiling; its bottom gives the light."""
    return (replace(box("lamp", (-0.30, -0.30, -0.06), (0.60, 0.60, 0.06), "lacquer"), lamp=lamp),)


def desk_island(rng: np.random.Generator, crowded: tuple[bool, ...]) -> tuple[Box, ...]:
    """Six workplaces, three on each side of a screen along y, around the origin."""
    pitch, half_gap = DESK_WIDTH + 0.01, 0.02
    screen = box("screen", (-0.012, -1.5 * pitch, 0.55), (0.024, 3 * pitch, 0.60), "felt")
    feet = [box(f"screenfoot{k}", (-0.012, y, 0), (0.024, 0.04, 0.55), "steel") for k, y in enumerate((-1.0, 0.96))]
    pieces = [screen, *feet]
    for k, is_crowded in enumerate(crowded):
        y = (k % 3 - 1) * pitch
        side, turn = (-1, -90) if k < 3 else (1, 90)
        near = side * (half_gap + DESK_DEPTH)
        pieces += placed(workplace(rng, is_crowded), f"place{k}", near, y, turn)
    return tuple(pieces)
