"""Pairs of polygons on the device, and what every method returns for them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.device.device import DeviceArray
from hradiosity.errors import DeviceError
from hradiosity.transport.form_factor.polygons import PolygonSet


@dataclass(frozen=True)
class Estimate:
    """Exchange areas A F of pairs, with an estimate of their error.

    exchange, error : (n_pairs,) float64 [m²]
    """

    exchange: NDArray[np.float64]
    error: NDArray[np.float64]

    def times(self, share: NDArray[np.float64], share_error: NDArray[np.float64]) -> Estimate:
        """The product with visible shares and their errors, (n_pairs,)."""
        return Estimate(self.exchange * share, self.error * share + self.exchange * share_error)


@dataclass(frozen=True)
class Pairs:
    """Which polygon with which.

    A method that treats both unlike takes its points on the first, which callers make the smaller one.

    polygons : PolygonSet
    first, second : (n_pairs,) uint32
    device : Device
    polygon_arguments : arguments of ``HR_POLYGON_PARAMS`` by name; made from `polygons` when left out
    """

    polygons: PolygonSet
    first: NDArray[np.uint32]
    second: NDArray[np.uint32]
    device: Device
    polygon_arguments: dict[str, DeviceArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.device.info.has_double:
            name = self.device.info.name
            raise DeviceError(f"form factors of polygons need double precision, which {name} lacks; use another device")
        if not self.polygon_arguments:
            self.polygon_arguments.update(_upload(self.polygons, self.device))

    def __len__(self) -> int:
        return len(self.first)

    def subset(self, chosen: NDArray[Any]) -> Pairs:
        """Some of the pairs, by index or mask; they share the polygons on the device."""
        return self.with_pairs(self.first[chosen], self.second[chosen])

    def with_pairs(self, first: NDArray[np.uint32], second: NDArray[np.uint32]) -> Pairs:
        """Other pairs of the same polygons, which stay on the device."""
        return Pairs(self.polygons, first, second, self.device, self.polygon_arguments)

    @cached_property
    def pair_arguments(self) -> dict[str, DeviceArray]:
        """Arguments ``first`` and ``second``."""
        return {
            "first": self.device.upload(self.first, np.uint32),
            "second": self.device.upload(self.second, np.uint32),
        }

    @property
    def corner_definitions(self) -> dict[str, int]:
        """``HR_CORNERS`` (row length of the corners) for programs that hold polygons in private arrays."""
        return {"HR_CORNERS": self.polygons.corners.shape[1]}

    def results(self, n: int = 2) -> list[DeviceArray]:
        """Device arrays for `n` numbers a pair."""
        return [self.device.empty((len(self),), np.float64) for _ in range(n)]

    def estimate(self, exchange: DeviceArray, error: DeviceArray) -> Estimate:
        """What kernels wrote, on the host, kept between 0 and the smaller area."""
        if len(self) == 0:
            return Estimate(np.zeros(0), np.zeros(0))
        most = np.minimum(self.polygons.area[self.first], self.polygons.area[self.second])
        values = np.clip(self.device.fetch(exchange), 0.0, most)
        return Estimate(values, values if error is exchange else self.device.fetch(error))


def _upload(polygons: PolygonSet, device: Device) -> dict[str, DeviceArray]:
    return {
        "polygon_corner": device.upload(polygons.corners, np.float64),
        "polygon_count": device.upload(polygons.count, np.uint32),
        "polygon_normal": device.upload(polygons.normal, np.float64),
        "polygon_sphere": device.upload(np.column_stack([polygons.centre, polygons.radius]), np.float64),
        "polygon_area": device.upload(polygons.area, np.float64),
    }
