"""Form factors by hemicube: item buffers with depth on half a cube over each point (Cohen & Greenberg 1985)."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, vstack

from hradiosity.device.device import DeviceArray
from hradiosity.errors import DeviceError
from hradiosity.model.geometry import Patches
from hradiosity.space.hierarchy import NONE, Elements
from hradiosity.transport.device_scene import DeviceScene

OFFSET: Final = 2.0**-20
"""Distance of the eye from its surface over the largest coordinate: surfaces that coincide with it stay behind."""
BUFFER_BYTES: Final = 128 * 2**20
"""Item and depth buffers that are kept on the device at a time."""
LARGEST_BATCH: Final = 64
_OUTCOMES: Final = 4
_FACES: Final = 5
_GROUPS_PER_UNIT: Final = 4


@dataclass(frozen=True)
class Views:
    """What points see, as shares of their hemisphere weighted with the cosine: form factors [1].

    factor : (n_points, n_items) float32 CSR, to each item
    miss, sky : (n_points,) float64, to the outside, below and above the horizontal plane
    covered : (n_points,) float64, to the inside of solids: such a point lies in one
    unlit : (n_points,) float64, to sides that no light was found to reach
    """

    factor: csr_array
    miss: NDArray[np.float64]
    sky: NDArray[np.float64]
    covered: NDArray[np.float64]
    unlit: NDArray[np.float64]


class Hemicube:
    """Draws what points see, at one resolution.

    Parameters
    ----------
    scene : DeviceScene
    patches : Patches
        Those of the scene.
    elements : Elements
        Their cells.
    resolution : int
        Pixels along an edge of the top face, even and at least 8.
    item_of_cell : (n_cells,) uint32, optional
        What the pixels are counted for; the row elements if left out. Items are numbered from 0.

    Attributes
    ----------
    drawn, seconds : hemicubes drawn so far, and the wall seconds that it took

    Raises
    ------
    ValueError
        For an odd or small resolution.
    DeviceError
        When the device has no double precision.
    """

    def __init__(
        self,
        scene: DeviceScene,
        patches: Patches,
        elements: Elements,
        resolution: int,
        item_of_cell: NDArray[np.uint32] | None = None,
    ) -> None:
        if resolution < 8 or resolution % 2:
            raise ValueError(f"the resolution of a hemicube must be even and at least 8, is {resolution}")
        device = scene.device
        if not device.info.has_double:
            raise DeviceError(f"hemicubes need double precision, which {device.info.name} lacks; use another device")
        items = elements.cell_row if item_of_cell is None else item_of_cell
        self.resolution = resolution
        self.drawn, self.seconds = 0, 0.0
        self.n_items = int(items.max(initial=0)) + 1
        self.batch = int(np.clip(BUFFER_BYTES // (24 * resolution**2), 1, LARGEST_BATCH))
        self._device, self._scene = device, scene
        self._n_patches = len(patches)
        self._patches = _drawn(patches, scene)
        self._cells = {
            "cell_divisions": device.upload(elements.divisions),
            "side_first_cell": device.upload(elements.first_cell),
            "cell_item": device.upload(items, np.uint32),
        }
        self._weight = device.upload(delta_factors(resolution))
        pixels = (self.batch, 3 * resolution**2)
        self._depth = device.empty(pixels, np.float32)
        self._item = device.empty(pixels, np.uint32)
        self._factor = device.empty((self.batch, self.n_items + _OUTCOMES), np.float32)

    def views(
        self,
        position: NDArray[np.float64],
        normal: NDArray[np.float64],
        angle: NDArray[np.float64],
        own_patch: ArrayLike = NONE,
    ) -> Views:
        """Form factors of points to all items.

        Parameters
        ----------
        position, normal : (n, 3) float64
            World frame [m], unit normals.
        angle : (n,) float64
            By which each hemicube is turned about its normal [rad]; random ones turn aliasing into noise.
        own_patch : scalar or (n,) int
            Patch on which the point lies, which it does not see; NONE for none.
        """
        start, n = time.perf_counter(), len(position)
        own = np.broadcast_to(np.asarray(own_patch, np.int64) & NONE, (n,)).astype(np.uint32)
        parts = [csr_array((0, self.n_items), dtype=np.float32)]
        outcomes = [np.zeros((0, _OUTCOMES))]
        for first in range(0, n, self.batch):
            part = slice(first, min(first + self.batch, n))
            dense = self._draw(position[part], normal[part], angle[part], own[part])
            parts.append(csr_array(dense[:, : self.n_items]))
            outcomes.append(dense[:, self.n_items :].astype(np.float64))
        rest = np.concatenate(outcomes)
        self.drawn, self.seconds = self.drawn + n, self.seconds + time.perf_counter() - start
        return Views(csr_array(vstack(parts, format="csr")), rest[:, 0], rest[:, 1], rest[:, 2], rest[:, 3])

    def _draw(
        self,
        position: NDArray[np.float64],
        normal: NDArray[np.float64],
        angle: NDArray[np.float64],
        own: NDArray[np.uint32],
    ) -> NDArray[np.float32]:
        """(n, n_items + 4) factors of one batch."""
        device, scene, n = self._device, self._scene, len(position)
        local = position - scene.bvh.local_origin
        reach = OFFSET * np.maximum(np.abs(local).max(axis=1, keepdims=True, initial=0.0), scene.scale)
        wanted = _GROUPS_PER_UNIT * device.info.compute_units * 64
        strips = int(np.clip(wanted // (_FACES * n), 1, 8))
        device.kernel("hemicube", "draw_hemicubes")(
            n * _FACES * strips,
            **self._patches,
            **self._cells,
            patch_kind=scene.geometry["patch_kind"],
            patch_solid=scene.solid,
            eye=device.upload(local + reach * normal, np.float64),
            normal=device.upload(normal, np.float64),
            angle=device.upload(angle, np.float64),
            own_patch=device.upload(own),
            depth=self._depth,
            item=self._item,
            n_patches=self._n_patches,
            n_things=self.n_items,
            resolution=self.resolution,
            n_strips=strips,
        )
        device.kernel("hemicube", "add_pixels")(
            n * 64,
            item=self._item,
            weight=self._weight,
            factor=self._factor,
            resolution=self.resolution,
            n_columns=self.n_items + _OUTCOMES,
        )
        factor: NDArray[np.float32] = device.fetch(self._factor)[:n]
        return factor


def delta_factors(resolution: int) -> NDArray[np.float32]:
    """Form factors of the pixels of the top face, then of the upper half of one side, (1.5 resolution²,).

    At its centre the top face has dF = dA / (π (x² + y² + 1)²), a side z dA / (π (y² + z² + 1)²) (Cohen & Greenberg
    1985); then all are multiplied so that the five faces add up to 1, which the midpoint rule misses by O(1/n²).
    """
    across = (np.arange(resolution) + 0.5) * 2.0 / resolution - 1.0
    up = (np.arange(resolution // 2) + 0.5) * 2.0 / resolution
    pixel = 4.0 / resolution**2
    top = pixel / (np.pi * (across[None, :] ** 2 + across[:, None] ** 2 + 1.0) ** 2)
    side = up[:, None] * pixel / (np.pi * (across[None, :] ** 2 + up[:, None] ** 2 + 1.0) ** 2)
    total = top.sum() + 4.0 * side.sum()
    factors: NDArray[np.float32] = (np.concatenate([top.ravel(), side.ravel()]) / total).astype(np.float32)
    return factors


def _drawn(patches: Patches, scene: DeviceScene) -> dict[str, DeviceArray]:
    """Patches in double precision by the names of the kernel's arguments."""
    device = scene.device
    corners = patches.corners() - scene.bvh.local_origin
    centre = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1, initial=0.0)
    return {
        "drawn_origin": device.upload(patches.origin - scene.bvh.local_origin, np.float64),
        "drawn_edge_u": device.upload(patches.edge_u, np.float64),
        "drawn_edge_v": device.upload(patches.edge_v, np.float64),
        "drawn_sphere": device.upload(np.column_stack([centre, radius]), np.float64),
    }
