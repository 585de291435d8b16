"""What the random methods share: replicates, and doubling of the samples until the error is met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs

Sequence = Literal["sobol", "random"]
REPLICATES: Final = 8
STUDENT: Final = 2.365
"""Two-sided 95 % of Student's t with 7 degrees of freedom."""
MOST_SAMPLES: Final = 2**20
_FIRST_SAMPLES: Final = 2**10
SEEN_NOTHING: Final = 3.0
"""What n samples never met has a share below 3 / n, with 95 % confidence."""


@dataclass(frozen=True)
class Sampling:
    """How to draw samples.

    samples : of each pair, in all replicates; None to double them until the tolerance is met
    tolerance : relative half width of the 95 % interval to reach
    sequence : scrambled Sobol points, or independent ones
    seed : changes all points
    """

    samples: int | None
    tolerance: float
    sequence: Sequence = "sobol"
    seed: int = 1

    def counts(self) -> tuple[int, ...]:
        """Sample numbers to try one after the other."""
        if self.samples is not None:
            return (max(self.samples, REPLICATES),)
        return tuple(_FIRST_SAMPLES * 4**k for k in range(int(np.log2(MOST_SAMPLES // _FIRST_SAMPLES)) // 2 + 1))


def sampled_exchange(pairs: Pairs, kernel: str, sampling: Sampling) -> Estimate:
    """A F of pairs by one of the kernels of ``pair_sampling.cl``; the error is a 95 % half width."""
    n = len(pairs)
    value, error = np.zeros(n), np.full(n, np.inf)
    for samples in sampling.counts():
        open_ = np.flatnonzero(error > sampling.tolerance * value)
        if len(open_) == 0:
            break
        part = pairs.subset(open_)
        rows = _replicates(part, kernel, samples // REPLICATES, sampling)
        value[open_] = rows.mean(axis=1)
        smaller = np.minimum(part.polygons.area[part.first], part.polygons.area[part.second])
        unseen = np.where(rows.any(axis=1), 0.0, SEEN_NOTHING / samples * smaller)
        error[open_] = half_width(rows) + unseen
    return pairs_clipped(pairs, value, error)


def _replicates(pairs: Pairs, kernel: str, samples: int, sampling: Sampling) -> NDArray[np.float64]:
    device = pairs.device
    exchange = device.empty((len(pairs), REPLICATES), np.float64)
    device.kernel("pair_sampling", kernel, **pairs.corner_definitions)(
        len(pairs) * REPLICATES,
        **pairs.polygon_arguments,
        **pairs.pair_arguments,
        n_replicates=REPLICATES,
        n_samples=samples,
        sequence=int(sampling.sequence == "sobol"),
        seed=sampling.seed,
        exchange=exchange,
    )
    rows: NDArray[np.float64] = device.fetch(exchange)
    return rows


def half_width(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """95 % half width of the mean of each row of replicates."""
    width: NDArray[np.float64] = STUDENT * rows.std(axis=1, ddof=1) / np.sqrt(rows.shape[1])
    return width


def pairs_clipped(pairs: Pairs, value: NDArray[np.float64], error: NDArray[np.float64]) -> Estimate:
    """Values no larger than the smaller area."""
    most = np.minimum(pairs.polygons.area[pairs.first], pairs.polygons.area[pairs.second])
    return Estimate(np.minimum(value, most), error)
