"""Rays that row elements aim at spots: balls that much of the light passes, such as parts of a door or a slot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import Device, DeviceArray
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.exchange import RowHits


@dataclass(frozen=True)
class Aims:
    """Shares of the rays of each row that go to spots; the others follow the cosine law.

    spot : (n_spots, 4) float32, centre in the ray structure's frame and radius [m]; one at least
    share : (n_rows, n_spots) float32, sums below 1
    """

    spot: NDArray[np.float32]
    share: NDArray[np.float32]

    def upload(self, device: Device) -> DeviceAims:
        """On the device."""
        sums = np.cumsum(self.share, axis=1, dtype=np.float64).astype(np.float32)
        return DeviceAims(self, {"aim_spot": device.upload(self.spot), "aim_sums": device.upload(sums)})


@dataclass(frozen=True)
class DeviceAims:
    """Aims on the device, by the names of the kernel's arguments."""

    aims: Aims
    arguments: dict[str, DeviceArray]


def trace_aimed_rows(
    scene: DeviceScene, elements: DeviceElements, aims: DeviceAims, n_samples: int, seed: int
) -> RowHits:
    """`n_samples` rays from each row element, spread evenly over it, some of them aimed.

    What they meet has no bias once each ray counts by its density (balance heuristic, Veach & Guibas 1995, over the
    lines that the rows at both ends may draw).
    """
    device, n_rows = scene.device, len(elements.elements)
    row, side = (device.empty((n_rows, n_samples), np.uint32) for _ in range(2))
    density = device.empty((n_rows, n_samples, 2), np.float32)
    device.kernel("exchange", "trace_aimed_rows")(
        n_rows * n_samples,
        **scene.geometry,
        **elements.cells,
        **aims.arguments,
        patch_solid=scene.solid,
        flush_reach=scene.flush_reach,
        hit_row=row,
        hit_side=side,
        hit_density=density,
        n_spots=len(aims.aims.spot),
        n_samples=n_samples,
        seed=seed,
        scale=scene.scale,
    )
    return RowHits(device.fetch(row), device.fetch(side), row, device.fetch(density))


@dataclass(frozen=True)
class Lines:
    """Some rays of rows, in the ray structure's frame [m].

    origin, direction : (n, 3) float64, directions of unit length
    length : (n,) float64, infinite for those that leave the scene
    cosine : (n, 2) float64, with the normals at both ends; 0 where there is no end
    """

    origin: NDArray[np.float64]
    direction: NDArray[np.float64]
    length: NDArray[np.float64]
    cosine: NDArray[np.float64]


def row_rays(
    scene: DeviceScene, elements: DeviceElements, number: NDArray[np.int64], n_samples: int, seed: int
) -> Lines:
    """Rays of `hradiosity.transport.exchange.trace_rows` by their numbers, n_samples · row + sample."""
    ray = scene.device.empty((len(number), 9), np.float32)
    scene.device.kernel("exchange", "row_rays")(
        len(number),
        **scene.geometry,
        **elements.cells,
        number=scene.device.upload(number, np.uint32),
        ray=ray,
        n_samples=n_samples,
        seed=seed,
        scale=scene.scale,
    )
    found = scene.device.fetch(ray).astype(np.float64)
    return Lines(found[:, :3], found[:, 3:6], found[:, 6], found[:, 7:9])
