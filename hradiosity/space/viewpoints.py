"""Where to put a camera if the user named none."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK
from hradiosity.model.scene import Scene, View
from hradiosity.space.bvh import Bvh
from hradiosity.space.visibility import trace_closest

RAYS: Final = 256
AUTOMATIC_FIELD: Final = 75.0
"""Horizontal angle of a view that was chosen here [degrees]."""
_EYE_HEIGHT: Final = 1.7
_SHARES: Final = ((0.06, 0.06), (0.94, 0.06), (0.06, 0.94), (0.94, 0.94), (0.5, 0.06), (0.5, 0.94), (0.06, 0.5),
                  (0.94, 0.5))  # fmt: skip


def automatic_view(scene: Scene, bvh: Bvh, lit: NDArray[np.bool_]) -> View:
    """A view of a scene that has none: of a few places in its corners and around it the one that sees most.

    Parameters
    ----------
    scene : Scene
        With at least one patch.
    bvh : Bvh
    lit : (n_patches, 2) bool
        Sides that are worth seeing.
    """
    low, high = scene.patches.bounds()
    centre, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    places = _candidates(low, high)
    scores = [_seen(scene, bvh, lit, place, centre, size) for place in places]
    position = places[int(np.argmax(scores))]
    return _looking_at(position, centre)


def _candidates(low: NDArray[np.float64], high: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Places inside the bounding box at eye height, then places around it."""
    extent = high - low
    eye = low[2] + min(_EYE_HEIGHT, 0.6 * extent[2])
    inside = [np.array([*(low[:2] + share * extent[:2]), eye]) for share in np.array(_SHARES)]
    centre, reach = 0.5 * (low + high), 1.2 * float(np.linalg.norm(extent))
    turns = np.radians(np.arange(8) * 45.0 + 20.0)
    around = [centre + reach * np.array([np.cos(a), np.sin(a), 0.45]) / np.hypot(1.0, 0.45) for a in turns]
    return inside + around


def _looking_at(position: NDArray[np.float64], target: NDArray[np.float64]) -> View:
    direction = target - position
    return View(
        name="automatic",
        position=position,
        direction=direction / np.linalg.norm(direction),
        up=np.array([0.0, 0.0, 1.0]),
        field_of_view=AUTOMATIC_FIELD,
    )


def _is_enclosed(scene: Scene, bvh: Bvh, position: NDArray[np.float64]) -> bool:
    """Whether most rays in all directions, spread evenly (a Fibonacci spiral), meet the inside of a solid first."""
    number = np.arange(RAYS) + 0.5
    height = 1.0 - 2.0 * number / RAYS
    angle = np.pi * (3.0 - np.sqrt(5.0)) * number
    radius = np.sqrt(1.0 - height**2)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    hits = trace_closest(bvh, np.broadcast_to(position, directions.shape), directions)
    inside = (hits.patch >= 0) & (hits.side == BACK) & (scene.patches.solid[hits.patch] >= 0)
    return 2 * int(inside.sum()) > RAYS


def _seen(
    scene: Scene, bvh: Bvh, lit: NDArray[np.bool_], place: NDArray[np.float64], centre: NDArray[np.float64], size: float
) -> float:
    """Mean over a coarse picture of how far lit surfaces are, as a share of the scene and at most a half."""
    if float(np.linalg.norm(centre - place)) < 1e-6 * size or _is_enclosed(scene, bvh, place):
        return -1.0
    view = _looking_at(place, centre)
    right = np.cross(view.direction, view.up)
    right /= max(float(np.linalg.norm(right)), 1e-9)
    up = np.cross(right, view.direction)
    half = np.tan(np.radians(view.field_of_view / 2.0))
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-half, half, 24), 0.75 * np.linspace(-half, half, 18)))
    directions = view.direction + x[:, None] * right + y[:, None] * up
    hits = trace_closest(bvh, np.broadcast_to(place, directions.shape), directions)
    good = (hits.patch >= 0) & lit[np.maximum(hits.patch, 0), hits.side]
    return float(np.where(good, np.minimum(np.where(good, hits.t, 0.0) / size, 0.5), 0.0).mean())
