"""Area lamps of the classic mode: cells that shoot their exitance before anything else does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Scene
from hradiosity.radiosity.shooting import ShootingPoints, ShootingRows, over_area
from hradiosity.space.hierarchy import Elements
from hradiosity.space.substructure import SPLITS, Substructure
from hradiosity.transport.form_factor.hemicube import Hemicube

LAMP_POINTS: Final = 512
"""Lamps are cut into the smaller cells of their patches as long as there are no more than this many."""


@dataclass(frozen=True)
class AreaLamps:
    """Cells of one grid that shine.

    grid : the grid's elements
    cell : (n,) int64, cells of that grid
    finest : (n,) int64, a finest cell of each
    exitance : (n, n_columns) float64
    """

    grid: Elements
    cell: NDArray[np.int64]
    finest: NDArray[np.int64]
    exitance: NDArray[np.float64]

    def light(
        self, hemicube: Hemicube, points: ShootingPoints, exposed: NDArray[np.float64], area: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(n_items, n_columns) irradiance of the items that a hemicube counts.

        Parameters
        ----------
        hemicube : Hemicube
        points : ShootingPoints
            One on each cell.
        exposed : (n,) float64
            Share of each cell that no solid covers.
        area : (n_items,) float64
            Exposed area of the items [m²].
        """
        shining = self.grid.area[self.cell] * exposed * points.exposed
        rows = ShootingRows(hemicube, points, shining, np.arange(len(area)))
        return over_area(rows.arriving(self.exitance), area)


def cut_lamps(structure: Substructure, exitance: NDArray[np.float64]) -> AreaLamps:
    """The cells of the finest grid on which the lamps have at most `LAMP_POINTS` cells, or of the coarsest.

    Parameters
    ----------
    structure : Substructure
    exitance : (2 n_patches, n_columns) float64
        Of every side.
    """
    shines = np.asarray(exitance.any(axis=1), bool)
    for level in range(SPLITS, -1, -1):
        grid = structure.levels[level]
        cell = np.flatnonzero(shines[grid.cell_side])
        if len(cell) <= LAMP_POINTS or level == 0:
            break
    finest = np.zeros(len(grid), np.int64)
    finest[structure.ancestor[level]] = np.arange(len(structure.finest))
    return AreaLamps(grid, cell, finest[cell], exitance[grid.cell_side[cell]])


def side_exitance(scene: Scene, emission: NDArray[np.float32]) -> NDArray[np.float64]:
    """(2 n_patches, n_columns) exitance of every side, from that of the emitters (n_emitters, n_columns)."""
    lamps = scene.emitters
    table = np.zeros((2 * len(scene.patches), emission.shape[1]))
    flat = np.flatnonzero(lamps.patch != NONE)
    exitance = emission[flat].astype(np.float64)
    np.add.at(table, 2 * lamps.patch[flat], exitance)
    both = np.array([lamp.two_sided for lamp in scene.luminaires], bool)[lamps.luminaire[flat]]
    np.add.at(table, 2 * lamps.patch[flat[both]] + 1, exitance[both])
    return table
