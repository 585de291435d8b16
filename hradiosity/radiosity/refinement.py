"""Row elements split where one value for the whole of them makes readings wrong, as the first replicate shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.plan import Effect, Plan
from hradiosity.planning import REFINEMENT
from hradiosity.readings.importance import seen_rows
from hradiosity.space.hierarchy import Elements
from hradiosity.space.row_squares import cells_after, quarters_of, row_squares, split_rows
from hradiosity.transport.device_scene import DeviceElements, DeviceScene, upload_elements
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import Exchange, RowHits, trace_rows
from hradiosity.transport.unevenness import Transported, importance_of_rows, near_share, uneven_products, worst_first

ROUNDS: Final = 3
"""Times that elements may be split."""
TOLERANCE, FORCED_TOLERANCE = 0.003, 0.0003
"""Error of the mean reading that is left to elements as they are; the second where refinement is asked for."""
NEAR: Final = 0.3
REACH: Final = 1.5
"""Elements are looked at where so many of their own rays end within so many of their edges: only there light and
importance can both change much inside of one. Beside the edge of a room a fifth do."""
LARGEST_PRODUCT: Final = 0.25
"""Of the relative changes of light and importance inside an element, about."""
GLANCE, LOOK = (128, 16), (256, 64)
"""Elements whose quarters send rays, and rays of each quarter, twice: at first, and where that finds too much."""
PROBE_POINTS: Final = 4
"""On each quarter, for direct light."""
MOST_GROWTH: Final = 1.0
"""Elements that are added, as a share of those there were."""
MOST_CELLS: Final = 1 << 18
"""Cells of the grids that split elements are made of."""


@dataclass(frozen=True)
class GreyLight:
    """The light of a replicate as one brightness.

    arriving, reflected, glow : (n_rows,) float64, irradiance of each row, what it reflects, and what it sends out
        itself without being sampled as an emitter
    emission : (n_emitters,) float64, of the emitters that are sampled
    sky : float
    """

    arriving: NDArray[np.float64]
    reflected: NDArray[np.float64]
    glow: NDArray[np.float64]
    emission: NDArray[np.float64]
    sky: float

    @classmethod
    def of(cls, brightness: NDArray[np.float64], *columns: NDArray[np.float32], sky: NDArray[np.float32]) -> GreyLight:
        """Of columns (n, n_columns) in the order of the fields, and the brightness (n_columns,) of each."""
        arriving, reflected, glow, emission = (np.einsum("nc,c->n", some, brightness) for some in columns)
        return cls(arriving, reflected, glow, emission, float(np.einsum("c,c->", sky, brightness)))

    @property
    def leaving(self) -> NDArray[np.float64]:
        """(n_rows,) what rays bring from each row."""
        return self.reflected + self.glow

    @property
    def reflectance(self) -> NDArray[np.float64]:
        """(n_rows,) that of the light of each row."""
        return np.divide(self.reflected, self.arriving, out=np.zeros_like(self.reflected), where=self.arriving > 0.0)


class Refinement:
    """Rounds of splitting, until what is left matters no more.

    Parameters
    ----------
    tolerance : float
        Error of the mean reading up to which nothing is split; infinite for never.
    position, normal : (n, 3) float64
        Of the readings.

    Attributes
    ----------
    splits : list of (n,) int64
        Rows split in each round.
    rays : int
        Sent in the last round to find out.
    importance : (n_rows,) float64, or None before a round
        Change of the mean reading by the exitance of each row, relative to it, per area [m⁻²].
    """

    def __init__(self, tolerance: float, position: NDArray[np.float64], normal: NDArray[np.float64]) -> None:
        self._tolerance, self._position, self._normal = tolerance, position, normal
        self.start()

    @classmethod
    def of(cls, scene: Scene, plan: Plan, options: Options) -> Refinement:
        """As the plan has it."""
        wanted = any(effect.name == REFINEMENT and effect.needed for effect in plan.effects)
        tolerance = FORCED_TOLERANCE if options.refinement else TOLERANCE
        none = np.zeros((0, 3))
        return cls(
            tolerance if wanted else np.inf,
            np.concatenate([none, *(sensor.position for sensor in scene.sensors)]),
            np.concatenate([none, *(sensor.normal for sensor in scene.sensors)]),
        )

    def start(self) -> None:
        """Forget what was found on other elements."""
        self.splits: list[NDArray[np.int64]] = []
        self.importance: NDArray[np.float64] | None = None
        self.rays = 0
        self._errors: list[float] = []
        self._n_first = 0

    def refined(self, patches: Patches, elements: Elements) -> Elements:
        """The elements after all rounds so far."""
        for rows in self.splits:
            elements = split_rows(patches, elements, rows)
        return elements

    def next_round(
        self,
        scene: DeviceScene,
        rows: DeviceElements,
        patches: Patches,
        hits: RowHits,
        exchange: Exchange,
        light: GreyLight,
        seed: int,
    ) -> bool:
        """Whether elements were chosen to be split, by a replicate on those that there are.

        Parameters
        ----------
        scene : DeviceScene
        rows : DeviceElements
        patches : Patches
        hits : RowHits
        exchange : Exchange
        light : GreyLight
        seed : int
        """
        self.rays = 0
        if self._tolerance == np.inf or not len(light.leaving):
            return False
        self._n_first = self._n_first or len(light.leaving)
        room = int((1.0 + MOST_GROWTH) * self._n_first) - len(light.leaving)
        importance = self.importance = self._importance(scene, rows, exchange, light, seed)
        if len(self.splits) == ROUNDS:
            return False
        share, nearest = self._candidates(patches, rows.elements, hits, exchange, light, importance)
        error, chosen = 0.0, nearest[:0]
        if LARGEST_PRODUCT * float(share.sum()) > self._tolerance:
            for most, n_rays in (GLANCE, LOOK):
                probed = np.sort(nearest[:most])
                found = self._probe(scene, rows, patches, probed, n_rays, exchange, light, importance, seed)
                side = row_squares(patches, rows.elements).side[probed]
                best, error = worst_first(*found, side, self._tolerance, room // 3)
                chosen = probed[best]
                if error * float(share.sum()) <= self._tolerance * float(share[probed].sum()):
                    break
        self._errors.append(error)
        if not len(chosen) or cells_after(patches, rows.elements, chosen) > MOST_CELLS:
            return False
        self.splits.append(chosen)
        return True

    def _importance(
        self, scene: DeviceScene, rows: DeviceElements, exchange: Exchange, light: GreyLight, seed: int
    ) -> NDArray[np.float64]:
        """(n_rows,) of exitance for the mean reading, relative to it, per area [m⁻²]."""
        seen = seen_rows(scene, rows, self._position, self._normal, light.leaving, light.emission, seed)
        area = exchange.element_area
        self.rays += seen.n_rays
        per_area = np.divide(seen.change, area, out=np.zeros_like(area), where=area > 0.0)
        return importance_of_rows(exchange, light.reflectance, per_area)

    @staticmethod
    def _candidates(
        patches: Patches,
        elements: Elements,
        hits: RowHits,
        exchange: Exchange,
        light: GreyLight,
        importance: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """What rows with others close by reflect of the mean reading (n_rows,), and these rows, largest first."""
        squares = row_squares(patches, elements)
        near = near_share(hits, squares.middles(patches), REACH * np.sqrt(elements.area))
        share = np.where(squares.single & (near >= NEAR), exchange.element_area * light.leaving * importance, 0.0)
        order = np.argsort(-share * near, kind="stable")
        return share, order[share[order] > 0.0]

    def _probe(
        self,
        scene: DeviceScene,
        rows: DeviceElements,
        patches: Patches,
        probed: NDArray[np.int64],
        n_rays: int,
        exchange: Exchange,
        light: GreyLight,
        importance: NDArray[np.float64],
        seed: int,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Error of the mean reading by each of some rows, by rays from their quarters; and its noise."""
        parts = upload_elements(scene.device, quarters_of(patches, rows.elements, probed)[0])
        seeds = (seed ^ 0x27D4EB2F, seed ^ 0x165667B1)
        one, other = (trace_rows(scene, parts, n_rays, some) for some in seeds)
        factor = [direct_on_rows(scene, parts, some, PROBE_POINTS, its) for some, its in zip((one, other), seeds)]
        direct = [np.einsum("re,e->r", some.astype(np.float64), light.emission) for some in factor]
        self.rays += 2 * (one.row.size + PROBE_POINTS * factor[0].size)
        products = uneven_products(
            (one, other),
            (direct[0], direct[1]),
            Transported(light.leaving, light.sky),
            Transported(light.reflectance * importance),
        )
        weight = 0.5 * exchange.element_area[probed] * light.reflectance[probed]
        return weight * (products[0] + products[1]), weight * np.abs(products[0] - products[1])

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """What `restore` needs."""
        rounds = [np.column_stack([np.full(len(rows), k), rows]) for k, rows in enumerate(self.splits)]
        return {
            "splits": np.concatenate([np.zeros((0, 2), np.int64), *rounds]),
            "split_errors": np.array([self._n_first, *self._errors]),
        }

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> bool:
        """Take the rounds of a checkpoint over; returns whether that changes the elements."""
        before = self.checkpoint()["splits"]
        number, rows = kept["splits"].T
        self.splits = [rows[number == k] for k in range(int(number.max(initial=-1)) + 1)]
        self._n_first, self._errors = int(kept["split_errors"][0]), list(kept["split_errors"][1:])
        return not np.array_equal(before, kept["splits"])

    def told(self, effects: tuple[Effect, ...], n_elements: int) -> tuple[Effect, ...]:
        """The effects of the plan, with what was found."""
        if not self._errors:
            return effects
        because = f"one value for each element makes the mean reading wrong by about {100 * self._errors[0]:.2g} %"
        if self.splits:
            because += f": {self._n_first} of them became {n_elements}"
        return tuple(
            replace(effect, needed=bool(self.splits), because=because) if effect.name == REFINEMENT else effect
            for effect in effects
        )
