"""Slots that light goes through: narrow gaps whose ends open into places that hardly see each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import BACK, Patches
from hradiosity.space.bvh import Bvh
from hradiosity.space.visibility import trace_any, trace_closest

RAYS: Final = 32
"""Rays out of each end of a slot, and pairs of places that are tried for sight."""
NARROW: Final = 0.75
"""Share of a side's rays that have to end within twice the gap's width."""
DEEP: Final = 2.0
"""Depth of a slot, in widths, from which on its walls are cut."""
_BEYOND: Final = 0.4
"""An end is open where this share of the width is free beyond it; a bend of the same width is."""
_OPEN: Final = 0.25
_SAME_PLACE: Final = 0.125
"""Share of open rays that make an end open, and of sights that make both ends one place."""
_FAR: Final = 0.25
"""Both ends open into places where rays go this share of the scene's mean free path: gaps between books end in the dark
behind them, of which no reading and no other light depends."""
_CELL: Final = 0.75
"""Wanted length of a cell across the slot, in widths."""
MOST_CELLS: Final = 16
"""Cells from end to end: with as many, all slots with walls up to a reflectance of 0.9 pass within 3.5 % of the right
light (strips by crossed strings, depths of 2 to 100 widths), with 8 within 13 %, and with one nine times as much."""
EXTRA_SHARE: Final = 0.25
EXTRA_ANYWAY: Final = 1000
"""Slots may add this share of the cells, and so many in any scene; where they want more, all are cut more coarsely."""


@dataclass(frozen=True)
class _Ends:
    """Both ends of gaps in front of sides, along one edge of the patches.

    start : (n, 2, RAYS, 3) float64, halfway between the walls, a little outside each end [m]
    outward : (n, 2, 3) float64, unit
    open : (n, 2, RAYS) bool, there is room beyond
    depth : (n,) float64, from end to end [m]
    """

    start: NDArray[np.float64]
    outward: NDArray[np.float64]
    open: NDArray[np.bool_]
    depth: NDArray[np.float64]


def slot_divisions(
    patches: Patches,
    bvh: Bvh,
    height: NDArray[np.float64],
    lit: NDArray[np.bool_],
    free_path: float,
    seed: int,
) -> NDArray[np.int64]:
    """Cells that walls of slots should have along edge_u and edge_v, even; 0 where any number will do.

    One value for the whole depth of a slot lets through up to nine times the light. The gap in front of a side is the
    median height of what its rays meet; it is a slot along an edge where both ends open into places of some size that
    hardly see each other.

    Parameters
    ----------
    patches : Patches
    bvh : Bvh
    height : (n_patches, 2, n_rays) float64
        How far above a side its rays ended; inf for those that met nothing [m].
    lit : (n_patches, 2) bool
    free_path : float
        Of the whole scene [m].
    seed : int

    Returns
    -------
    (n_patches, 2) int64
        The same twice for a triangle.
    """
    wanted = np.zeros((len(patches), 2), np.int64)
    gap = np.median(height, axis=2) if len(patches) else np.zeros((0, 2))
    edges = np.stack([patches.edge_u, patches.edge_v], axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    deep = lit & (gap > 0.0) & (DEEP * gap <= longest[:, None])
    deep &= (height <= 2.0 * gap[:, :, None]).mean(axis=2) >= NARROW
    patch, side = np.nonzero(deep)
    if not len(patch):
        return wanted
    rng = np.random.Generator(np.random.Philox(key=seed ^ 0x736C6F74))
    width = gap[patch, side]
    inward = patches.normal[patch] * np.where(side == BACK, -1.0, 1.0)[:, None]
    for axis in (0, 1):
        along, across = edges[patch, axis], edges[patch, 1 - axis]
        ends = _ends(bvh, patches.origin[patch], along, across, inward, width)
        slots = np.flatnonzero((ends.depth >= DEEP * width) & (ends.open.mean(axis=2) >= _OPEN).all(axis=1))
        slots = slots[~_joins_nothing(bvh, ends, slots, _FAR * free_path, rng)]
        cells = np.minimum(2 * np.ceil(ends.depth[slots] / (2.0 * _CELL * width[slots])), MOST_CELLS)
        np.maximum.at(wanted[:, axis], patch[slots], cells.astype(np.int64))
    wanted[patches.is_triangle] = wanted[patches.is_triangle].max(axis=1, keepdims=True)
    return wanted


def with_slots(
    patches: Patches, n_lit: NDArray[np.int64], divisions: NDArray[np.int64], wanted: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The divisions (n_patches, 2), raised to what slots want as far as the bound on their number lets them.

    Parameters
    ----------
    patches : Patches
    n_lit : (n_patches,) int64, sides that are cut
    divisions : (n_patches, 2) int64
    wanted : (n_patches, 2) int64, see `slot_divisions`
    """

    def cells(grid: NDArray[np.int64]) -> int:
        return int((n_lit * np.where(patches.is_triangle, grid[:, 0] ** 2, grid.prod(axis=1))).sum())

    before = cells(divisions)
    most = before + max(int(EXTRA_SHARE * before), EXTRA_ANYWAY)
    while True:
        raised = np.maximum(divisions, wanted)
        if cells(raised) <= most:
            return raised
        wanted = 2 * (wanted // 4)


def _ends(
    bvh: Bvh,
    origin: NDArray[np.float64],
    along: NDArray[np.float64],
    across: NDArray[np.float64],
    inward: NDArray[np.float64],
    width: NDArray[np.float64],
) -> _Ends:
    """The ends that a gap in front of parallelograms has along one edge."""
    out = np.cross(across, inward)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    out *= np.sign(np.einsum("nd,nd->n", out, along))[:, None]
    depth = np.asarray(np.einsum("nd,nd->n", out, along), np.float64)
    place = (np.arange(RAYS) + 0.5) / RAYS
    middle = origin + 0.5 * width[:, None] * inward
    edge = middle[:, None] + place[:, None] * across[:, None]
    border = np.stack([edge, edge + along[:, None]], axis=1)
    outward = np.stack([-out, out], axis=1)
    free = _BEYOND * width
    back = 0.5 * free[:, None, None, None] * outward[:, :, None]
    direction = np.broadcast_to(outward[:, :, None], border.shape)
    reach = np.broadcast_to((1.5 * free)[:, None, None], border.shape[:3]).ravel()
    met = trace_any(bvh, (border - back).reshape(-1, 3), direction.reshape(-1, 3), t_max=reach)
    return _Ends(border + back, outward, ~met.reshape(border.shape[:3]), depth)


def _joins_nothing(
    bvh: Bvh, ends: _Ends, which: NDArray[np.int64], far: float, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Whether what is beyond one end is seen from beyond the other, or beyond one of them is not much."""
    start = ends.start[which]
    direction = rng.standard_normal(start.shape)
    direction /= np.linalg.norm(direction, axis=3, keepdims=True)
    direction = 1.001 * ends.outward[which][:, :, None] + direction
    direction /= np.linalg.norm(direction, axis=3, keepdims=True)
    hits = trace_closest(bvh, start.reshape(-1, 3), direction.reshape(-1, 3))
    length = np.minimum(hits.t.astype(np.float64), 4.0 * bvh.scale).reshape(start.shape[:3])
    met = start + 0.999 * length[..., None] * direction
    pairing = rng.permutation(RAYS)
    other = met[:, 1][:, pairing]
    both = ends.open[which, 0] & ends.open[which, 1][:, pairing]
    hidden = trace_any(bvh, met[:, 0].reshape(-1, 3), (other - met[:, 0]).reshape(-1, 3), t_max=1.0)
    seen = (~hidden.reshape(both.shape) & both).sum(axis=1)
    is_far = (length > far) & ends.open[which]
    small = (2 * is_far.sum(axis=2) < ends.open[which].sum(axis=2)).any(axis=1)
    return np.asarray(small | (seen >= _SAME_PLACE * both.sum(axis=1)), bool)
