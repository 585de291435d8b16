"""Rays and points of elements where they serve the readings most, as the first replicate shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.transport.aim_shares import RayWorth, find_aims
from hradiosity.transport.aims import Aims, DeviceAims
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.exchange import RowHits
from hradiosity.transport.lamp_worth import points_by_worth

TOLERANCE: Final = 0.002
"""Standard error of the mean reading over it, by all replicates, that is left to rays and points as they are."""


class Aiming:
    """What a run knows about where its rays should go.

    Attributes
    ----------
    done : bool, whether a replicate was looked at
    aims : of exchange rays; None if there are none
    points : (n_rows, n_emitters) uint32 on the device, of direct light; None for those of the plan
    rays : sent to find out
    """

    def __init__(self) -> None:
        self.done, self.rays = False, 0
        self.aims: DeviceAims | None = None
        self.points: DeviceArray | None = None

    def look(
        self,
        scene: DeviceScene,
        rows: DeviceElements,
        hits: RowHits,
        worth: RayWorth,
        emission: NDArray[np.float64],
        clear: NDArray[np.float32] | None,
        sight: NDArray[np.uint8] | None,
        *,
        n_points: int,
        replicates: int,
        seed: int,
    ) -> bool:
        """Whether rays or points were moved, so that the replicate had better start again.

        Parameters
        ----------
        hits : RowHits
            Of the replicate with this seed.
        worth : RayWorth
        emission : (n_emitters,) float64
            Brightness.
        clear : (n_rows, n_emitters) float32, optional
            What emitters would send without obstacles; points stay as they are where elements try some lamps only.
        sight : (n_rows, n_emitters) uint8, optional
        n_points : int
            Of direct light, in the plan.
        """
        self.done = True
        tolerance = TOLERANCE * replicates**0.5
        aims, self.rays = find_aims(scene, rows, hits, worth, seed, tolerance=tolerance)
        self.aims = None if aims is None else aims.upload(scene.device)
        if clear is not None:
            its_worth = worth.wanted * rows.elements.area
            error = its_worth[:, None] * clear * emission
            points = points_by_worth(scene, rows, clear, error, sight, n_points, seed ^ 0x85EBCA6B, tolerance=tolerance)
            self.points = None if points is None else scene.device.upload(points)
        return self.aims is not None or self.points is not None

    @property
    def spots(self) -> NDArray[np.float64]:
        """(n, 3) middles of the spots that rays are aimed at, in the ray structure's frame [m]."""
        return np.zeros((0, 3)) if self.aims is None else self.aims.aims.spot[:, :3].astype(np.float64)

    def checkpoint(self, device: Device) -> dict[str, NDArray[Any]]:
        """What `restore` needs."""
        kept: dict[str, NDArray[Any]] = {"aimed": np.array(self.done)}
        if self.aims is not None:
            kept |= {"aim_spot": self.aims.aims.spot, "aim_share": self.aims.aims.share}
        if self.points is not None:
            kept["aim_points"] = device.fetch(self.points)
        return kept

    def restore(self, device: Device, kept: Mapping[str, NDArray[Any]]) -> None:
        """Take what a checkpoint knows over."""
        self.done = bool(kept["aimed"])
        self.aims = Aims(kept["aim_spot"], kept["aim_share"]).upload(device) if "aim_spot" in kept else None
        self.points = device.upload(kept["aim_points"]) if "aim_points" in kept else None
