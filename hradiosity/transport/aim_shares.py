"""Where aimed rays pay: spots that catch what makes readings noisy, and how many rays each row sends there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.space.hierarchy import COVERED, SKY, UNLIT, Elements
from hradiosity.space.row_squares import row_squares
from hradiosity.transport.aims import Aims, Lines, row_rays, trace_aimed_rows
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.exchange import RowHits
from hradiosity.transport.waists import Spots, find_spots, passes

CONTRAST: Final = 8.0
"""Rays are rare if they change readings by so many times more than the mean one, for the exchange they stand for."""
MOST_LINES: Final = 1024
"""Rare rays that spots are found by."""
MOST_WEIGHT: Final = 3.0
"""Of a rare ray over their median: spots that follow few rays of much noise miss what others would find."""
WORTHWHILE: Final = 0.5
"""Variance that aimed rays must leave, at most, of what there was."""
MOST_AIMED: Final = 0.5
"""Share of a row's rays; the others see the rest of the scene, and no ray counts more than 1 / (1 - this) times."""
LEAST_AIMED: Final = 0.03
PILOT_RAYS: Final = 2
"""From each row to each spot."""
BLOCK: Final = 8
"""Cells along both edges of a block of rows."""
OWN: Final = 0.75
"""Of what a row's rays to a spot found; for the rest what its rays found at all spots in the mean."""


@dataclass(frozen=True)
class Smoothing:
    """Means over blocks of neighbouring rows: few rays of single ones are luck, which aims must not follow.

    block : (n_rows,) int64
    area : (n_rows,) float64 [m²]
    """

    block: NDArray[np.int64]
    area: NDArray[np.float64]

    @classmethod
    def of(cls, patches: Patches, elements: Elements) -> Smoothing:
        """Blocks of so many rows along both edges of a patch side."""
        squares = row_squares(patches, elements)
        finest = np.maximum(squares.grid, 1)
        place = squares.place * elements.divisions[squares.side // 2].astype(np.int64) // (BLOCK * finest)
        keys = np.column_stack([squares.side, np.where(squares.single[:, None], place, -1)])
        return cls(np.unique(keys, axis=0, return_inverse=True)[1].ravel(), elements.area.astype(np.float64))

    def __call__(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_rows,) mean of the block that each is in."""
        total = np.bincount(self.block, self.area)
        mean = np.divide(np.bincount(self.block, self.area * values), total, out=np.zeros_like(total), where=total > 0)
        of_rows: NDArray[np.float64] = mean[self.block]
        return of_rows


@dataclass(frozen=True)
class RayWorth:
    """What rays between rows do to the mean reading.

    leaving : (n_rows,) float64, brightness
    wanted : (n_rows,) float64, change of the mean reading by irradiance of each row, per area, relative to it [m⁻²]
    sky : float, brightness
    """

    leaving: NDArray[np.float64]
    wanted: NDArray[np.float64]
    sky: float

    def of(self, hits: RowHits) -> NDArray[np.float64]:
        """(n_rows, n_samples) change of the mean reading by the exchange that a ray stands for, per area [m⁻²].

        Light goes both ways; 0 for rays that meet nothing.
        """
        n = len(self.leaving)
        met = np.where(hits.row < UNLIT, hits.row, np.where(hits.row == SKY, n, n + 1)).astype(np.int64)
        leaving, wanted = np.append(self.leaving, [self.sky, 0.0]), np.append(self.wanted, [0.0, 0.0])
        value: NDArray[np.float64] = self.wanted[:, None] * leaving[met] + self.leaving[:, None] * wanted[met]
        return value


@dataclass(frozen=True)
class PlainRays:
    """Rays of a replicate that were not aimed, and what they are worth.

    worth : RayWorth
    value : (n_rows, n_samples) float64, see `RayWorth.of`
    per_area : (n_rows,) float64, rays per area [m⁻²]
    pooled : (n_rows, n_samples) float64, the same of both rows that might have sent each
    rare : (n_rows, n_samples) bool
    """

    worth: RayWorth
    value: NDArray[np.float64]
    per_area: NDArray[np.float64]
    pooled: NDArray[np.float64]
    rare: NDArray[np.bool_]

    @classmethod
    def of(cls, worth: RayWorth, hits: RowHits, area: NDArray[np.float64]) -> PlainRays:
        """Those that met `hits`, from rows with an area (n_rows,) [m²]."""
        n, n_samples = hits.row.shape
        value = worth.of(hits)
        per_area = np.divide(n_samples, area, out=np.full(n, np.inf), where=area > 0.0)
        back = np.append(per_area, 0.0)[np.where(hits.row < UNLIT, hits.row, n).astype(np.int64)]
        pooled = per_area[:, None] + back
        limit = CONTRAST * float((value / pooled).sum()) / max(float((1.0 / pooled).sum()), np.finfo(float).tiny)
        return cls(worth, value, per_area, pooled, value > limit)

    @property
    def variance(self) -> NDArray[np.float64]:
        """(n_rows, n_samples) what each ray adds to the variance of the mean reading, over its square."""
        square: NDArray[np.float64] = (self.value / self.pooled) ** 2
        return square


def find_aims(
    scene: DeviceScene,
    rows: DeviceElements,
    hits: RowHits,
    worth: RayWorth,
    seed: int,
    *,
    tolerance: float,
) -> tuple[Aims | None, int]:
    """Aims that leave less noise; None if there is too little of it, or if it does not come by few ways.

    Parameters
    ----------
    hits : RowHits
        Of plain rays with this seed.
    worth : RayWorth
    tolerance : float
        Standard error of the mean reading, relative to it, up to which nothing is done.

    Returns
    -------
    aims : Aims or None
    n_rays : int
        That it took to find out.
    """
    plain = PlainRays.of(worth, hits, rows.elements.area)
    variance = plain.variance
    total, of_rare = float(variance.sum()), float(variance[plain.rare].sum())
    usual = (total - of_rare) / (1.0 - MOST_AIMED)
    if total <= tolerance**2 or usual > WORTHWHILE * total:
        return None, 0
    number = np.flatnonzero(plain.rare & (hits.row != COVERED))
    number = number[:: -(-len(number) // MOST_LINES)]
    lines = row_rays(scene, rows, number, hits.row.shape[1], seed)
    extent = 2.0 * scene.scale
    lines = replace(lines, length=np.minimum(lines.length, extent))
    noise = variance.ravel()[number]
    weight = np.minimum(np.sqrt(noise), MOST_WEIGHT * np.sqrt(np.median(noise)))
    tried = [some for some in find_spots(lines, weight, extent) if len(some.ball)]
    left = [_variance_left(plain, some, lines, number) / float(noise.sum()) for some in tried]
    if not left or usual + min(left) * of_rare > WORTHWHILE * total:
        return None, 0
    spots = tried[int(np.argmin(left))]
    aims = _shared(scene, rows, hits, plain, spots, seed)
    return (aims if aims.share.any() else None), len(number) + PILOT_RAYS * aims.share.size


def _variance_left(plain: PlainRays, spots: Spots, lines: Lines, number: NDArray[np.int64]) -> float:
    """What rare rays would add to the variance if all rows aimed at the spots."""
    share = MOST_AIMED * spots.caught / spots.caught.sum()
    end = lines.origin + lines.length[:, None] * lines.direction
    ways = (lines.origin, lines.direction), (end, -lines.direction)
    denser = []
    for (origin, direction), cosine in zip(ways, lines.cosine.T):
        met, cone = passes(spots.ball, origin, direction)
        solid = cone * np.maximum(cosine, 1e-6)[:, None]
        more = np.divide(0.5 * share, solid, out=np.zeros_like(cone), where=met & (solid > 0.0))
        denser.append(1.0 - MOST_AIMED + more.sum(axis=1))
    own = plain.per_area[number // plain.value.shape[1]]
    pooled = plain.pooled.ravel()[number]
    after = denser[0] * own + denser[1] * (pooled - own)
    return float((plain.variance.ravel()[number] * pooled / after).sum())


def _shared(scene: DeviceScene, rows: DeviceElements, hits: RowHits, plain: PlainRays, spots: Spots, seed: int) -> Aims:
    """Shares of each row's rays by what a few rays to each spot bring (Neyman 1934: in proportion to the spread)."""
    ball = spots.ball.astype(np.float32)
    n = len(plain.per_area)
    found, open_share = np.zeros((n, len(ball))), np.zeros((n, len(ball)))
    rare = float(plain.value[plain.rare].min())
    for k in range(len(ball)):
        alone = Aims(ball[k : k + 1], np.full((n, 1), 1.0 - 2.0**-20, np.float32)).upload(scene.device)
        pilot = trace_aimed_rows(scene, rows, alone, PILOT_RAYS, (seed ^ 0x1B873593) + k & 0xFFFFFFFF)
        value = plain.worth.of(pilot)
        useful = value >= rare
        found[:, k] = (value * useful * pilot.share).sum(axis=1)
        open_share[:, k] = useful.mean(axis=1)
    found = OWN * found + (1.0 - OWN) * found.mean(axis=1, keepdims=True)
    usual = np.sqrt((np.where(plain.rare, 0.0, plain.value) ** 2).mean(axis=1))
    brought = found.sum(axis=1)
    aimed = np.divide(brought, brought + usual, out=np.zeros(n), where=brought > 0.0)
    aimed = np.where((aimed >= LEAST_AIMED) & ~(hits.row == COVERED).any(axis=1), np.minimum(aimed, MOST_AIMED), 0.0)
    share = np.divide(found, brought[:, None], out=np.zeros_like(found), where=brought[:, None] > 0.0)
    return Aims(ball, (aimed[:, None] * share).astype(np.float32))
