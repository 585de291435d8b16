"""Which sides of which patches light can reach at all, found by a few rays from each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, NONE, Patches
from hradiosity.model.scene import Scene
from hradiosity.model.welding import connected
from hradiosity.space.bvh import Bvh
from hradiosity.space.slots import slot_divisions
from hradiosity.space.visibility import trace_any, trace_closest

RAYS_PER_SIDE = 16
RAYS_PER_SOURCE = 4096


@dataclass(frozen=True)
class LitSides:
    """Sides that take part, and the spaces they form.

    lit : (n_patches, 2) bool, light can reach the front and the back
    space : (n_patches, 2) int32, number of the connected space that the side looks into; −1 where not lit
    open : (n_spaces,) bool, rays leave the space
    free_path : mean distance that light goes from a lit surface to the next one [m], 4V/S of an empty convex room
    slots : (n_patches, 2) int64, cells that walls of slots should have along both edges, see `slot_divisions`
    """

    lit: NDArray[np.bool_]
    space: NDArray[np.int32]
    open: NDArray[np.bool_]
    free_path: float
    slots: NDArray[np.int64]

    def of_parents(self, parent: NDArray[np.int64]) -> LitSides:
        """The same for the patches that pieces were cut from: lit where a piece is, in the space of one that is lit.

        Parameters
        ----------
        parent : (n_patches,) int64
            Of each piece; every number up to the largest has one.
        """
        space = np.full((int(parent.max(initial=-1)) + 1, 2), -1, np.int32)
        np.maximum.at(space, parent, self.space)
        slots = np.zeros_like(space, np.int64)
        np.maximum.at(slots, parent, self.slots)
        return LitSides(space >= 0, space, self.open, self.free_path, slots)


@dataclass(frozen=True)
class _Pilot:
    """Where rays from all sides went.

    origin : (n_rays,) int64, side the ray left
    start : (n_rays, 3) float64, a hair in front of that side [m]
    target : (n_rays,) int64, side it ended on; −1 for none
    left : (n_rays,) bool, it left the scene
    left_upward : (n_rays,) bool, and above the horizon
    distance : (n_rays,) float64, to the target; 0 for none [m]
    height : (n_rays,) float64, of the target above the side; inf for none [m]
    """

    origin: NDArray[np.int64]
    start: NDArray[np.float64]
    target: NDArray[np.int64]
    left: NDArray[np.bool_]
    left_upward: NDArray[np.bool_]
    distance: NDArray[np.float64]
    height: NDArray[np.float64]

    def heights(self, n_patches: int) -> NDArray[np.float64]:
        """(n_patches, 2, RAYS_PER_SIDE); inf for sides that send no rays."""
        height = np.full((2 * n_patches, RAYS_PER_SIDE), np.inf)
        height[self.origin[::RAYS_PER_SIDE]] = self.height.reshape(-1, RAYS_PER_SIDE)
        return height.reshape(n_patches, 2, RAYS_PER_SIDE)


def find_lit_sides(scene: Scene, bvh: Bvh, *, seed: int = 0, known_links: NDArray[np.int64] | None = None) -> LitSides:
    """Connect sides that see each other, and keep the connected sets that a source of light shines into.

    Parameters
    ----------
    scene : Scene
    bvh : Bvh
    seed : int
    known_links : (n, 2) int64, optional
        Pairs of sides (2 · patch + side) that are known to see each other, beside those the rays find.

    Notes
    -----
    A ray that ends on the back of a solid started inside it, and connects nothing.
    """
    patches = scene.patches
    n_sides = 2 * len(patches)
    rng = np.random.Generator(np.random.Philox(key=seed))
    pilot = _trace_from_sides(patches, bvh, rng)
    sees = pilot.target >= 0
    pairs = np.column_stack([pilot.origin[sees], pilot.target[sees]])
    if known_links is not None:
        pairs = np.concatenate([pairs, known_links])
    label = connected(pairs[:, 0], pairs[:, 1], n_sides)
    n_sets = int(label.max(initial=-1)) + 1
    bright = np.zeros(n_sets, bool)
    bright[label[_emitting_sides(scene)]] = True
    bright[label[_sides_seen_by_points(scene, bvh, rng)]] = True
    bright[label[_sides_that_see_points(scene, bvh, pilot)]] = True
    if scene.sky is not None:
        bright[label[pilot.origin[pilot.left_upward]]] = True
    leaves = np.zeros(n_sets, bool)
    leaves[label[pilot.origin[pilot.left]]] = True
    lit = bright[label]
    lit[1::2] &= patches.solid < 0
    number = np.cumsum(bright) - 1
    lit = lit.reshape(-1, 2)
    free_path = _free_path(pilot, lit.ravel(), patches.area, bvh.scale)
    return LitSides(
        lit=lit,
        space=np.where(lit, number[label].reshape(-1, 2), -1).astype(np.int32),
        open=leaves[bright],
        free_path=free_path,
        slots=slot_divisions(patches, bvh, pilot.heights(len(patches)), lit, free_path, seed),
    )


def _free_path(pilot: _Pilot, lit: NDArray[np.bool_], area: NDArray[np.float64], scale: float) -> float:
    """Mean length of the rays between lit surfaces, by area; the scene's half extent where there are none."""
    counts = (pilot.target >= 0) & lit[pilot.origin]
    weight = area[pilot.origin[counts] // 2]
    total = float(weight.sum())
    return float((weight * pilot.distance[counts]).sum() / total) if total > 0.0 else scale


def _trace_from_sides(patches: Patches, bvh: Bvh, rng: np.random.Generator) -> _Pilot:
    side = np.repeat(np.arange(2 * len(patches)), RAYS_PER_SIDE)
    matter = (side % 2 == BACK) & (patches.solid[side // 2] >= 0)
    side = side[~matter]
    patch = side // 2
    uv = rng.random((len(side), 2))
    fold = patches.is_triangle[patch] & (uv.sum(axis=1) > 1.0)
    uv[fold] = 1.0 - uv[fold]
    point = patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
    normal = patches.normal[patch] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
    direction = normal + _random_directions(rng, len(side))
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-12)
    # Of the scene's size and not of its world coordinates: a scene a million metres off would be jumped over.
    start = point + 2.0**-20 * bvh.scale * normal
    hits = trace_closest(bvh, start, direction, skip_patch=patch)
    missed = hits.patch < 0
    rise = hits.t * np.einsum("rd,rd->r", direction, normal)
    target = np.where(missed, 0, hits.patch).astype(np.int64)
    inside = ~missed & (hits.side == BACK) & (patches.solid[target] >= 0)
    return _Pilot(
        origin=side,
        start=start,
        target=np.where(missed | inside, -1, 2 * target + hits.side),
        left=missed,
        left_upward=missed & (direction[:, 2] > 0.0),
        distance=np.where(missed | inside, 0.0, hits.t).astype(np.float64),
        height=np.where(missed | inside, np.inf, rise).astype(np.float64),
    )


def _emitting_sides(scene: Scene) -> NDArray[np.int64]:
    emits = scene.emitters.patch != NONE
    front = 2 * scene.emitters.patch[emits].astype(np.int64)
    both = np.array([lamp.two_sided for lamp in scene.luminaires], bool)[scene.emitters.luminaire[emits]]
    return np.concatenate([front, front[both] + 1])


def _sides_seen_by_points(scene: Scene, bvh: Bvh, rng: np.random.Generator) -> NDArray[np.int64]:
    position = np.repeat(scene.emitters.position[scene.emitters.patch == NONE], RAYS_PER_SOURCE, axis=0)
    hits = trace_closest(bvh, position, _random_directions(rng, len(position)))
    hit = hits.patch >= 0
    return np.unique(2 * hits.patch[hit].astype(np.int64) + hits.side[hit])


def _sides_that_see_points(scene: Scene, bvh: Bvh, pilot: _Pilot) -> NDArray[np.int64]:
    """The other way round, for sides that are small or far away: a source's own rays would hardly ever find them."""
    position = scene.emitters.position[scene.emitters.patch == NONE]
    outward = np.where(pilot.origin % 2 == BACK, -1.0, 1.0)
    normal = scene.patches.normal[pilot.origin // 2] * outward[:, None]
    seen = []
    for place in position:
        towards = place - pilot.start
        facing = np.flatnonzero(np.einsum("rd,rd->r", towards, normal) > 0.0)
        origin = pilot.origin[facing]
        hidden = trace_any(bvh, pilot.start[facing], towards[facing], t_max=1.0, skip_patch=origin // 2)
        seen.append(origin[~hidden])
    return np.unique(np.concatenate(seen)) if seen else np.zeros(0, np.int64)


def _random_directions(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    direction = rng.standard_normal((n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return direction
