"""What the random methods share: replicates, and doubling of the samples until the error is met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs

Sequence = Literal["sobol", "random"]
REPLICATES: Final = 8
STUDENT: Final = 2.365
"""Two-sided 95 % of Student's t with 7 degrees of freedom."""
STUDENT_STOPPED: Final = 3.499
"""The same for 99 %: where samples are added until the width is small, widths that are short by chance are the ones to
stop, and with this 95 % of the intervals hold."""
MOST_SAMPLES: Final = 2**20
_FIRST_SAMPLES: Final = 2**10
SEEN_NOTHING: Final = 3.0
"""What n samples never met, or never missed, has a share below 3 / n or above 1 - 3 / n, with 95 % confidence."""


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


Sampler = Callable[[Pairs, int, Sampling], NDArray[np.float64]]
"""From pairs, samples a replicate and the rest: A F (n_pairs, replicates) [m²]."""


def sampled_exchange(pairs: Pairs, sample: Sampler, sampling: Sampling) -> Estimate:
    """A F of pairs, with as many samples as it takes; the error is a 95 % half width.

    Where samples are added until it is small, the last step counts as error too if it was larger.
    """
    n = len(pairs)
    value, error = np.zeros(n), np.full(n, np.inf)
    before = np.full(n, np.nan)
    quantile = STUDENT if sampling.samples is not None else STUDENT_STOPPED
    for samples in sampling.counts():
        open_ = np.flatnonzero(error > sampling.tolerance * value)
        if len(open_) == 0:
            break
        part = pairs.subset(open_)
        rows = sample(part, samples // REPLICATES, sampling)
        value[open_] = rows.mean(axis=1)
        smaller = np.minimum(part.polygons.area[part.first], part.polygons.area[part.second])
        never = np.where(np.ptp(rows, axis=1) > 0.0, 0.0, SEEN_NOTHING / samples * smaller)
        step = np.nan_to_num(np.abs(value[open_] - before[open_]))
        error[open_] = np.minimum(np.maximum(half_width(rows, quantile), step) + never, smaller)
        before[open_] = value[open_]
    most = np.minimum(pairs.polygons.area[pairs.first], pairs.polygons.area[pairs.second])
    return Estimate(np.minimum(value, most), error)


def run_sampler(pairs: Pairs, kernel: str, samples: int, sampling: Sampling) -> NDArray[np.float64]:
    """(n_pairs, replicates) A F [m²] by one of the kernels of ``pair_sampling.cl``."""
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


def half_width(rows: NDArray[np.float64], quantile: float = STUDENT) -> NDArray[np.float64]:
    """95 % half width of the mean of each row of replicates."""
    width: NDArray[np.float64] = quantile * rows.std(axis=1, ddof=1) / np.sqrt(rows.shape[1])
    return width
