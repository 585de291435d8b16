"""The ray structure: an 8-wide bounding volume hierarchy over the patches, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray

WIDTH: Final = 8
"""Children of a node and triangles of a leaf."""
NODE_WORDS: Final = 64
LEAF_WORDS: Final = 80
LEAF_FLAG: Final = 0x80000000
STACK_SIZE: Final = 160
"""Entries of the traversal's private stack (``HR_BVH_STACK``); `WIDTH` - 1 are used up a level, and one node more."""


@dataclass(frozen=True)
class PatchGeometry:
    """The patches as kernels see them: float32, relative to the structure's local origin.

    origin, edge_u, edge_v : (n, 3) float32 [m], on the device
    normal : (n, 3) float32 [1], unit, on the device; 0 for a degenerate patch
    kind : (n,) uint32, on the device; 1 for a triangle, 0 for a parallelogram
    """

    origin: DeviceArray
    edge_u: DeviceArray
    edge_v: DeviceArray
    normal: DeviceArray
    kind: DeviceArray


@dataclass(frozen=True)
class Bvh:
    """What rays are traced through; `hradiosity.space.bvh_build.build_bvh` makes it.

    device : where the arrays live
    nodes : (n_nodes, 64) float32 [m], on the device: 6 bounds of 8 boxes each, 8 references (bits), 8 unused
    leaves : (n_leaves, 80) float32 [m], on the device: 9 corner coordinates of 8 triangles each, 8 names (bits)
    patches : geometry of the patches
    n_patches : patches, degenerate ones included
    depth : levels of nodes
    local_origin : (3,) float64 [m], centre of the bounding box; device coordinates are relative to it
    scale : largest half extent [m]; 1 when there is none
    """

    device: Device
    nodes: DeviceArray
    leaves: DeviceArray
    patches: PatchGeometry
    n_patches: int
    depth: int
    local_origin: NDArray[np.float64]
    scale: float

    def __post_init__(self) -> None:
        if self.local_origin.shape != (3,):
            raise ValueError(f"local_origin must have shape (3,), has {self.local_origin.shape}")
        if (WIDTH - 1) * self.depth + WIDTH > STACK_SIZE:
            raise ValueError(f"{self.depth} levels do not fit in a traversal stack of {STACK_SIZE}")

    def kernel_arguments(self) -> dict[str, DeviceArray]:
        """Arguments of ``HR_BVH_PARAMS`` by name."""
        return {"bvh_nodes": self.nodes, "bvh_leaves": self.leaves}

    def patch_arguments(self) -> dict[str, DeviceArray]:
        """Geometry of the patches for other kernels: ``patch_origin``, ``patch_edge_u``, … by name."""
        patches = self.patches
        return {
            "patch_origin": patches.origin,
            "patch_edge_u": patches.edge_u,
            "patch_edge_v": patches.edge_v,
            "patch_normal": patches.normal,
            "patch_kind": patches.kind,
        }

    def to_local(self, points: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """World coordinates (…, 3) [m] as kernels want them: relative to `local_origin`, float32."""
        return (np.asarray(points, np.float64) - self.local_origin).astype(np.float32)
