"""What other polygons leave of an exchange: all where a proof says so, else a sampled share with its own error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.transport.form_factor.pairs import Pairs
from hradiosity.transport.form_factor.sampling import REPLICATES, SEEN_NOTHING, half_width

MOST_SAMPLES: Final = 2**20
_FIRST_SAMPLES: Final = 2**10


@dataclass(frozen=True)
class Visibility:
    """Visible share of the exchange of pairs.

    share : (n_pairs,) float64, exactly 1 where it is proved
    error : (n_pairs,) float64, half width of the 95 % interval; 0 where it is proved
    """

    share: NDArray[np.float64]
    error: NDArray[np.float64]


class Occluders:
    """Polygons that may hide others; both sides of them are opaque.

    Parameters
    ----------
    pairs : Pairs
        Any pairs of the polygon set, whose device copy is used.
    first : int
        Where the occluders start in the set; they reach to its end, and no pair may name them.
    """

    def __init__(self, pairs: Pairs, first: int) -> None:
        device = pairs.device
        self.first, self.count = first, len(pairs.polygons) - first
        self.n_words = -(-self.count // 32)
        names = ("side_front", "side_above", "side_below")
        self._sides: dict[str, Any] = {name: device.empty((first, self.n_words), np.uint32) for name in names}
        device.kernel("pair_visibility", "occluder_sides", **pairs.corner_definitions)(
            first * self.n_words,
            **pairs.polygon_arguments,
            **self._sides,
            first_occluder=first,
            n_occluders=self.count,
            n_words=self.n_words,
        )
        self._sides["n_words"] = self.n_words

    def visibility(self, pairs: Pairs, tolerance: float, seed: int) -> Visibility:
        """Visible shares, sampled until their 95 % half width is below `tolerance` (of the unhidden exchange).

        The share is Σ K v / Σ K over random pairs of points, K = cos cos / r⁴: what is common to both sums falls out
        of the ratio's error.
        """
        share, error = np.ones(len(pairs)), np.zeros(len(pairs))
        doubtful = np.flatnonzero(self._find_doubtful(pairs))
        error[doubtful] = np.inf
        samples = _FIRST_SAMPLES
        while samples <= MOST_SAMPLES:
            open_ = doubtful[error[doubtful] > tolerance]
            if len(open_) == 0:
                break
            share[open_], error[open_] = self._sample(pairs.subset(open_), samples, seed)
            samples *= 4
        return Visibility(share, error)

    def _find_doubtful(self, pairs: Pairs) -> NDArray[Any]:
        device = pairs.device
        is_doubtful = device.empty((len(pairs),), np.uint8)
        device.kernel("pair_visibility", "find_doubtful", **pairs.corner_definitions)(
            len(pairs),
            **pairs.polygon_arguments,
            **self._sides,
            **pairs.pair_arguments,
            first_occluder=self.first,
            is_doubtful=is_doubtful,
        )
        return device.fetch(is_doubtful)[: len(pairs)]

    def _sample(self, pairs: Pairs, samples: int, seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        device = pairs.device
        sums: list[DeviceArray] = [device.empty((len(pairs), REPLICATES), np.float64) for _ in range(2)]
        device.kernel("pair_visibility", "sample_visibility", **pairs.corner_definitions)(
            len(pairs) * REPLICATES,
            **pairs.polygon_arguments,
            **self._sides,
            **pairs.pair_arguments,
            first_occluder=self.first,
            n_occluders=self.count,
            n_replicates=REPLICATES,
            n_samples=samples // REPLICATES,
            seed=seed,
            total=sums[0],
            visible=sums[1],
        )
        return _ratio(device.fetch(sums[0]), device.fetch(sums[1]), samples)


def _ratio(
    every: NDArray[np.float64], visible: NDArray[np.float64], samples: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ratio of the sums of replicates and its half width; agreement of all samples is no proof (rule of three)."""
    total = every.sum(axis=1)
    share = np.divide(visible.sum(axis=1), total, out=np.ones(len(total)), where=total > 0.0)
    rest = visible - share[:, None] * every
    mean = np.where(total > 0.0, every.mean(axis=1), 1.0)
    unanimous = (share == 0.0) | (share == 1.0)
    return share, half_width(rest) / mean + np.where(unanimous, SEEN_NOTHING / samples, 0.0)
