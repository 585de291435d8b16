"""Write a hall of a million triangles: rows of finely tessellated balls and bowls on tables under 24 lamps.

    python examples/make_million.py FOLDER [TRIANGLES]

The meshes are PLY files in binary, forty megabytes together, which is why the repository holds this script instead.
"""

import sys
from pathlib import Path

import numpy as np

COLUMNS, ROWS = 8, 5
PITCH, MARGIN = 2.2, 1.4
HALL = (2 * MARGIN + (COLUMNS - 1) * PITCH, 2 * MARGIN + (ROWS - 1) * PITCH, 3.2)
TABLE_HEIGHT, RADIUS = 0.75, 0.42
PAINTS = {"plaster": 0.62, "brick": 0.31, "moss": 0.22, "slate": 0.12}

HEADER = f"""\
# A hall with statues, a million triangles. Written by examples/make_million.py.

[scene]
title = "Million"
unit = "m"
up = "z"
bands = {{ first = 400, last = 700, step = 20 }}

[materials.wall]
reflectance = 0.7
[materials.floor]
reflectance = 0.25
[materials.table]
reflectance = 0.4

[luminaires.panel]
spectrum = {{ illuminant = "LED-B3" }}
luminous_flux_lm = 4000

[[box]]
name = "hall"
corner = [0, 0, 0]
size = [{HALL[0]:.3f}, {HALL[1]:.3f}, {HALL[2]}]
inside = true
faces = {{ sides = "wall", top = "wall", bottom = "floor" }}

[[sensor]]
name = "aisle"
kind = "grid"
corner = [{MARGIN + PITCH / 2 - 0.4:.3f}, 0.5, 0.0]
edge_u = [0.8, 0, 0]
edge_v = [0, {HALL[1] - 1.0:.3f}, 0]
counts = [3, 12]
height = 0.8

[[view]]
name = "hall"
position = [0.4, 0.4, 2.4]
target = [{HALL[0] / 2:.2f}, {HALL[1] / 2:.2f}, 0.8]
field_of_view_deg = 75.0
"""


def statue(rng: np.random.Generator, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """A ball with bumps: corners (n, 3) [m] around the origin, triangles (m, 3), 4 · steps² − 4 · steps of them."""
    across, along = steps, 2 * steps
    theta = np.pi * np.arange(1, across) / across
    phi = 2.0 * np.pi * np.arange(along) / along
    direction = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(along)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    poles = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    corners = np.concatenate([direction, poles])
    waves = rng.normal(size=(6, 3)) * [3.0, 3.0, 3.0]
    bumps = np.cos(corners @ waves.T + rng.uniform(0, 6, 6)).sum(axis=1) / 6
    corners = corners * (RADIUS * (0.8 + 0.2 * bumps))[:, None]
    ring = np.arange(along)
    after = (ring + 1) % along
    upper = along * np.arange(across - 2)[:, None]
    a, b, c, d = upper + ring, upper + after, upper + along + ring, upper + along + after
    last = along * (across - 2)
    top, bottom = len(direction), len(direction) + 1
    faces = [
        np.stack([a, c, d], axis=-1).reshape(-1, 3),
        np.stack([a, d, b], axis=-1).reshape(-1, 3),
        np.stack([np.full(along, top), ring, after], axis=-1),
        np.stack([last + ring, np.full(along, bottom), last + after], axis=-1),
    ]
    return corners, np.concatenate(faces)


def write_ply(path: Path, corners: np.ndarray, faces: np.ndarray) -> None:
    """Binary PLY."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(corners)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    rows["n"], rows["v"] = 3, faces
    path.write_bytes(header.encode() + corners.astype("<f4").tobytes() + rows.tobytes())


def place(number: int) -> tuple[float, float]:
    """Middle of a table [m]."""
    return MARGIN + (number % COLUMNS) * PITCH, MARGIN + (number // COLUMNS) * PITCH


def tables() -> list[str]:
    """A solid block under each statue."""
    texts = []
    for number in range(COLUMNS * ROWS):
        x, y = place(number)
        texts.append(
            f'[[box]]\nname = "table{number}"\ncorner = [{x - 0.45:.3f}, {y - 0.45:.3f}, 0]\n'
            f'size = [0.9, 0.9, {TABLE_HEIGHT}]\nmaterial = "table"\n'
        )
    return texts


def lamps() -> list[str]:
    """Panels below the ceiling, over the aisles."""
    texts = []
    for number in range(24):
        x = HALL[0] * (number % 6 + 0.5) / 6 - 0.3
        y = HALL[1] * (number // 6 + 0.5) / 4 - 0.3
        texts.append(
            f'[[rectangle]]\nname = "lamp{number}"\ncorner = [{x:.3f}, {y:.3f}, {HALL[2] - 0.05:.3f}]\n'
            'edge_u = [0, 0.6, 0]\nedge_v = [0.6, 0, 0]\nmaterial = "wall"\nluminaire = "panel"\n'
        )
    return texts


def write_million(folder: Path, triangles: int, seed: int = 1984) -> None:
    """Write scene.toml and the meshes, one for each paint, into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    steps = max(3, round(0.5 + np.sqrt(triangles / (4 * COLUMNS * ROWS) + 0.25)))
    texts = [HEADER, *tables(), *lamps()]
    for paint, (name, reflectance) in enumerate(PAINTS.items()):
        corners, faces, count = [], [], 0
        for number in range(paint, COLUMNS * ROWS, len(PAINTS)):
            points, triples = statue(rng, steps)
            corners.append(points + [*place(number), TABLE_HEIGHT + RADIUS + 0.02])
            faces.append(triples + count)
            count += len(points)
        write_ply(folder / f"{name}.ply", np.concatenate(corners), np.concatenate(faces))
        texts.append(f"[materials.{name}]\nreflectance = {reflectance}\n")
        texts.append(f'[[mesh]]\nname = "{name}"\nfile = "{name}.ply"\nunit = "m"\nup = "z"\nmaterial = "{name}"\n')
    (folder / "scene.toml").write_text("\n".join(texts), encoding="utf-8")


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 3:
        sys.exit("usage: python examples/make_million.py FOLDER [TRIANGLES]")
    write_million(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000)
