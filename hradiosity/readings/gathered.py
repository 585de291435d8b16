"""What one replicate read, gathered in several goes: points that are not sure enough are read again and averaged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.sensors import ReadingSamples


@dataclass(frozen=True)
class Gathered:
    """Readings of one replicate so far.

    samples : ReadingSamples
        Means of all goes.
    times : (n_points,) float64, samples of each point in all goes, over those that were planned for one
    unseen : (n_points, n_columns) float64, see `hradiosity.readings.unseen`; None where no point is dark
    """

    samples: ReadingSamples
    times: NDArray[np.float64]
    unseen: NDArray[np.float64] | None

    @property
    def nbytes(self) -> int:
        """Bytes that it takes, about."""
        arrays = self.samples.irradiance, self.samples.change, self.unseen
        return sum(array.nbytes for array in arrays if array is not None)

    def with_more(
        self, chosen: NDArray[np.int64], more: ReadingSamples, times: NDArray[np.float64], anew: NDArray[np.bool_]
    ) -> Gathered:
        """The same after one more go at some points, each go weighing as many times as it has samples.

        Parameters
        ----------
        chosen : (m,) int64
        more : ReadingSamples
            Of these points, by the same light on the elements unless they are taken anew.
        times : (m,) float64
            Samples of this go, over those that were planned for one.
        anew : (m,) bool
            Whether the goes before are given up.
        """
        before = np.where(anew, 0.0, self.times[chosen])
        share = times / (before + times)
        old = self.samples
        change = None
        if old.change is not None and more.change is not None:
            change = _mixed(old.change, more.change, chosen, share)
        samples = ReadingSamples(
            _mixed(old.irradiance, more.irradiance, chosen, share),
            _mixed(old.enclosed, more.enclosed, chosen, share),
            change,
            old.changed_by,
            _mixed_rows(old.some_row, more.some_row, chosen, anew),
        )
        total = self.times.copy()
        total[chosen] = before + times
        return replace(self, samples=samples, times=total)

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restored` needs; the arrays do not change."""
        samples = self.samples
        kept: dict[str, NDArray[Any]] = {
            "irradiance": samples.irradiance,
            "enclosed": samples.enclosed,
            "some_row": samples.some_row,
            "changed_by": np.frombuffer(samples.changed_by.encode(), np.uint8),
            "times": self.times,
        }
        optional = {"change": samples.change, "unseen": self.unseen}
        return kept | {name: array for name, array in optional.items() if array is not None}

    @classmethod
    def restored(cls, kept: Mapping[str, NDArray[Any]]) -> Gathered:
        """From a checkpoint, bit for bit."""
        changed_by = kept["changed_by"].tobytes().decode()
        samples = ReadingSamples(
            kept["irradiance"], kept["enclosed"], kept.get("change"), changed_by, kept["some_row"].astype(np.int64)
        )
        return cls(samples, kept["times"], kept.get("unseen"))


def _mixed(
    old: NDArray[np.float64], new: NDArray[np.float64], chosen: NDArray[np.int64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Means of which the new ones (m, …) are a share (m,) at the chosen points."""
    weight = share if old.ndim == 1 else share[:, None]
    mixed = old.copy()
    mixed[chosen] = (1.0 - weight) * old[chosen] + weight * new
    return mixed


def _mixed_rows(
    old: NDArray[np.int64], new: NDArray[np.int64], chosen: NDArray[np.int64], anew: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """A row element that paths of each point ended on, of any go that counts."""
    rows = old.copy()
    rows[chosen] = np.where(anew | (new >= 0), new, old[chosen])
    return rows
