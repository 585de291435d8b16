"""Sensor grids that avoid what stands in the room."""

from collections.abc import Sequence

import numpy as np
from furniture import Box
from numpy.typing import NDArray
from scene_text import number


def clearance(points: NDArray[np.float64], boxes: Sequence[Box]) -> float:
    """Distance of the point nearest to a box, along the nearest axis of that box; negative inside one [m].

    points : (n, 3) [m]
    """
    centre = np.array([piece.centre for piece in boxes])
    half = 0.5 * np.array([piece.size for piece in boxes])
    turn = np.radians([piece.turn for piece in boxes])
    dx, dy, dz = np.moveaxis(points[:, None] - centre, -1, 0)
    cosine, sine = np.cos(turn), np.sin(turn)
    local = np.stack([cosine * dx + sine * dy, cosine * dy - sine * dx, dz], axis=-1)
    return float((np.abs(local) - half).max(axis=-1).min())


def clear_grid(
    name: str,
    boxes: Sequence[Box],
    corner: tuple[float, float, float],
    extent: tuple[float, float],
    counts: tuple[int, int],
) -> str:
    """``grid`` sensor that looks up, moved as little as keeps its points 5 mm away from all boxes.

    corner : lowest corner before the grid is moved, by up to 20 cm along x and y; extent : lengths along x and y [m]

    Raises ``ValueError`` when no such place is found.
    """
    u, v = np.meshgrid(*((np.arange(n) + 0.5) / n * length for n, length in zip(counts, extent, strict=True)))
    grid = np.stack([u.ravel(), v.ravel(), np.zeros(u.size)], axis=1)
    near = [piece for piece in boxes if abs(piece.centre[2] - corner[2]) < piece.size[2] / 2 + 0.005]
    steps = 0.02 * np.arange(11)
    for shift in sorted(((x, y) for x in steps for y in steps), key=sum):
        place = (corner[0] + shift[0], corner[1] + shift[1], corner[2])
        if clearance(grid + np.array(place), near) >= 0.005:
            return _grid_table(name, place, extent, counts)
    raise ValueError(f"{name}: nowhere do all points keep out of the furniture")


def _grid_table(
    name: str, corner: tuple[float, float, float], extent: tuple[float, float], counts: tuple[int, int]
) -> str:
    return "\n".join(
        [
            "[[sensor]]",
            f'name = "{name}"',
            'kind = "grid"',
            f"corner = [{', '.join(number(x) for x in corner)}]",
            f"edge_u = [{number(extent[0])}, 0.0, 0.0]",
            f"edge_v = [0.0, {number(extent[1])}, 0.0]",
            f"counts = [{counts[0]}, {counts[1]}]\n",
        ]
    )
