"""In which directions the paths of readings start: shares of the parts of a hemisphere, some of which are cut finer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import Device, DeviceArray

LEVELS: Final = 5
SIDE: Final = 2**LEVELS
"""Parts along each edge of the square that stands for the hemisphere; as in ``cl/include/hr_guide.h``."""
ACROSS: Final = 4
"""Parts along each edge of a block, into which a part may be cut; as in ``cl/include/hr_guide.h``."""


@dataclass(frozen=True)
class Guides:
    """Shares of the paths that start in each part of the hemisphere, for some readings.

    share : (n, SIDE²) float32, of the parts, by rows, with the sum 1; (n, 0): evenly
    blocks : (n,) int64, blocks of each reading; they follow one another
    key : (n_blocks,) uint32, which part each is, ascending for each reading: its number, or from SIDE² on that of a
        part of the square cut ACROSS times as fine
    block : (n_blocks, ACROSS²) float32, shares of its parts, whose sum is the share of what is cut
    """

    share: NDArray[np.float32]
    blocks: NDArray[np.int64]
    key: NDArray[np.uint32]
    block: NDArray[np.float32]

    @classmethod
    def of_parts(cls, share: NDArray[np.float32]) -> Guides:
        """With nothing cut."""
        n = len(share)
        return cls(share, np.zeros(n, np.int64), np.zeros(0, np.uint32), np.zeros((0, ACROSS**2), np.float32))

    @classmethod
    def even(cls, n: int) -> Guides:
        """All directions alike."""
        return cls.of_parts(np.zeros((n, 0), np.float32))

    @classmethod
    def joined(cls, some: list[Guides]) -> Guides:
        """Of readings that follow one another."""
        names = "share", "blocks", "key", "block"
        return cls(*(np.concatenate([getattr(guides, name) for guides in some]) for name in names))

    def some(self, chosen: NDArray[np.int64]) -> Guides:
        """Those of some of the readings."""
        blocks = self.blocks[chosen]
        ends = np.cumsum(blocks)
        before = np.repeat((np.cumsum(self.blocks) - self.blocks)[chosen] - (ends - blocks), blocks)
        rows = before + np.arange(len(before))
        return Guides(self.share[chosen], blocks, self.key[rows], self.block[rows])

    def upload(self, device: Device) -> DeviceGuides | None:
        """On the device; None if all directions are alike."""
        if not self.share.shape[1]:
            return None
        arguments = {"guide": device.upload(guide_tables(self.share, SIDE))}
        if len(self.key):
            first = np.concatenate([[0], np.cumsum(self.blocks)])
            arguments["guide_first"] = device.upload(first, np.uint32)
            arguments["guide_key"] = device.upload(self.key)
            arguments["guide_block"] = device.upload(guide_tables(self.block, ACROSS))
        return DeviceGuides(arguments)


@dataclass(frozen=True)
class DeviceGuides:
    """Guides on the device, by the names of the kernel's arguments; those of blocks only if something is cut."""

    arguments: Mapping[str, DeviceArray]

    @property
    def kind(self) -> int:
        """What ``HR_GUIDED`` is for them."""
        return 2 if "guide_block" in self.arguments else 1


def guide_tables(share: NDArray[np.float32], side: int) -> NDArray[np.float32]:
    """(n, 4 + 16 + … + side²) shares (n, side²) of all levels, coarse ones first."""
    n = len(share)
    levels = [np.ascontiguousarray(share, np.float32).reshape(n, side, side)]
    while levels[0].shape[1] > 2:
        rows = levels[0][:, ::2] + levels[0][:, 1::2]
        levels.insert(0, rows[:, :, ::2] + rows[:, :, 1::2])
    return np.concatenate([level.reshape(n, level.shape[1] ** 2) for level in levels], axis=1)
