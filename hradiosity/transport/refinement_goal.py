"""What leaves are cut for, and the light that is known on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.cell_lookup import CellFrames
from hradiosity.space.leaf_vertices import SideRims
from hradiosity.space.leaves import Leaves


@dataclass(frozen=True, kw_only=True)
class RefinementOptions:
    """How finely shadows are resolved.

    tolerance : difference between the centre of a leaf and the mean of its corners, over the reference illuminance,
        above which the leaf is split
    contrast : part of the light that obstacles take from one corner and not from another, over the reference
        illuminance, above which the leaf is split
    base_level : level that all leaves have at least, so that small shadows are found
    max_level : highest level; each halves the edges
    light_samples : shadow rays to each emitter; None lets their number decide
    seed : of the shadow rays
    error : root mean square error of the direct light, over the reference illuminance, that the map as a whole may
        have: leaves are split in the order of the error that they are expected to leave, and tolerance and contrast
        do not count; None for these
    """

    tolerance: float = 0.04
    contrast: float = 0.25
    base_level: int = 1
    max_level: int = 5
    light_samples: int | None = None
    seed: int = 0
    error: float | None = None

    def __post_init__(self) -> None:
        if self.error is not None and not self.error > 0.0:
            raise ValueError(f"error must be > 0, is {self.error}")
        if not (self.tolerance > 0.0 and self.contrast > 0.0):
            raise ValueError(f"tolerance and contrast must be > 0, are {self.tolerance} and {self.contrast}")
        if not 0 <= self.base_level <= self.max_level <= 12:
            raise ValueError(f"0 <= base_level <= max_level <= 12 is wanted, got {self.base_level}, {self.max_level}")
        if self.light_samples is not None and self.light_samples < 1:
            raise ValueError(f"light_samples must be at least 1, is {self.light_samples}")


@dataclass(frozen=True)
class RefinementGoal:
    """Which cells get leaves, and how fine.

    frames : CellFrames
    rims : SideRims
    grid : (n_patches, 2) int64, cells along edge_u and edge_v of each patch
    size : (n_cells,) float64, edge [m] below which a leaf is not split; infinite for cells that nobody looks at,
        which get no leaves
    reference : (n_cells,) float64, illuminance [lx] that tolerances refer to, above 0
    """

    frames: CellFrames
    rims: SideRims
    grid: NDArray[np.int64]
    size: NDArray[np.float64]
    reference: NDArray[np.float64]


@dataclass(frozen=True)
class ShadowLight:
    """Direct light at the vertices of leaves, without wavelengths.

    leaves : Leaves
    vertex : (n_nodes, 9) int32, vertices of each leaf in the order of ``leaves.PLACES``; NONE for the middle of an
        edge that no finer leaf lies beside, and for all vertices of nodes that are no leaves
    vertex_side : (n_vertices,) int64, a side that the vertex lies on
    position : (n_vertices, 3) float64 [m], a little inside of the outline of that side
    per_luminaire : (n_vertices, n_luminaires) float32, irradiance over the exitance (or intensity) of each luminaire
    covered : (n_vertices,) bool, the vertex lies inside a solid and has no light of its own
    """

    leaves: Leaves
    vertex: NDArray[np.int32]
    vertex_side: NDArray[np.int64]
    position: NDArray[np.float64]
    per_luminaire: NDArray[np.float32]
    covered: NDArray[np.bool_]
