"""Guides from what one ray to each part of a hemisphere finds, and further ones where neighbours differ much.

A room that gets its light through a gap, or a sky seen through a small window, is found by chance alone otherwise; and
of the paths that start in a part few meet a gap that fills a fifth of it.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import ACROSS, Guides
from hradiosity.readings.guide_cuts import Blocks, Cuts, blurred, spread
from hradiosity.readings.pilot_light import PilotLight

EVEN_SHARE: Final = 0.2
"""Part of the paths that start evenly, so that none counts more than five times."""
CONTRAST: Final = 4.0
CONTRAST_PATHS: Final = 256
"""Parts are cut where the brightness found next to them differs by so many times that of the reading; with more paths
in a replicate than this, in proportion, by less: cutting then takes about as many rays as the paths that it saves."""
ROUNDS: Final = 16
"""How often neighbours of what was found bright are looked at, at most: rays that are far apart meet a narrow gap here
and there only, and the rest of it is found by following it."""


def make_guides(pilot: PilotLight, other: NDArray[np.float64], n_paths: int) -> Guides:
    """Guides of all points of a pilot.

    Parameters
    ----------
    other : (n,) float64
        Brightness that does not come over paths: beside it contrasts matter less.
    n_paths : int
        Of a reading in a replicate.
    """
    n = len(other)
    cuts = Cuts([Blocks.whole(n)])
    found = pilot.everywhere().ravel()
    least = CONTRAST * min(CONTRAST_PATHS / n_paths, 1.0) * (found.reshape(n, -1).mean(axis=1) + other)
    known = pilot.known_parts()
    for times in (1.0, ACROSS**2):
        blocks, light = _followed(pilot, cuts, found, times * least, known)
        known = known[:0]
        cuts = Cuts([*cuts.blocks, blocks])
        found = np.append(found, light)
    return guides_of(cuts, found)


def _followed(
    pilot: PilotLight, cuts: Cuts, found: NDArray[np.float64], least: NDArray[np.float64], known: NDArray[np.int64]
) -> tuple[Blocks, NDArray[np.float64]]:
    """Finest parts with contrasts of more than `least`, (n,), and those with contrasts to what is found in these; also
    those of which it is known that light may come from there, by their places among the values.

    Returns what was found in their parts as well, (n_blocks, ACROSS, ACROSS).
    """
    level = len(cuts.blocks) - 1
    blocks, near = cuts.blocks[level], cuts.near[level]
    low, high = found.copy(), found.copy()
    cut, wanted = np.zeros(len(found), np.bool_), np.zeros(len(found), np.bool_)
    wanted[known] = True
    keys, lights = [np.zeros(0, np.int64)], [np.zeros((0, ACROSS, ACROSS))]
    active = np.arange(len(near))
    for step in range(ROUNDS):
        around = near[active]
        contrast = spread(high[around], low[around]) > least[blocks.point[active], None, None]
        inside = around[:, 1:-1, 1:-1]
        row, y, x = np.nonzero((contrast | wanted[inside]) & ~cut[inside])
        if not len(row):
            break
        block = active[row]
        point, number = blocks.point[block], (blocks.y[block] * blocks.across + y) * blocks.finest
        number += blocks.x[block] * blocks.across + x
        light = pilot.in_blocks(point, number, ACROSS, blocks.finest, ROUNDS * level + step)
        place = near[block, y + 1, x + 1]
        low[place] = np.minimum(low[place], light.min(axis=(1, 2)))
        high[place] = np.maximum(high[place], light.max(axis=(1, 2)))
        cut[place] = True
        keys.append(point * blocks.finest**2 + number)
        lights.append(light)
        active = np.flatnonzero(np.isin(blocks.point, point))
    key = np.concatenate(keys)
    order = np.argsort(key)
    return Blocks.of_keys(blocks.finest, key[order]), np.concatenate(lights)[order]


def guides_of(cuts: Cuts, found: NDArray[np.float64]) -> Guides:
    """Guides for the brightness found in all parts; even where none was found.

    Within a part directions are alike in density, and the least variance is left by shares in proportion to the root of
    the mean square of the brightness. One ray says little about edges: squares are averaged with those of neighbours.
    """
    squares = found**2
    cuts.average(squares)
    light = np.concatenate([np.sqrt(blurred(squares[near])).ravel() for near in cuts.near])
    cuts.average(light)
    whole = cuts.of_level(light, 0)
    mean = whole.mean(axis=(1, 2))
    shares = []
    for number, level in enumerate(cuts.blocks):
        of_parts, its_mean = cuts.of_level(light, number), mean[level.point][:, None, None]
        relative = np.divide(of_parts, its_mean, out=np.ones_like(of_parts), where=its_mean > 0.0)
        share = ((1.0 - EVEN_SHARE) * relative + EVEN_SHARE) / level.finest**2
        shares.append(share.astype(np.float32).reshape(len(share), level.across**2))
    finer = cuts.blocks[1:]
    first = np.cumsum([0] + [level.side**2 for level in finer])
    point = np.concatenate([level.point for level in finer])
    key = np.concatenate([start + level.number for start, level in zip(first, finer)])
    order = np.lexsort((key, point))
    blocks = np.bincount(point, minlength=len(mean)).astype(np.int64)
    return Guides(shares[0], blocks, key[order].astype(np.uint32), np.concatenate(shares[1:])[order])
