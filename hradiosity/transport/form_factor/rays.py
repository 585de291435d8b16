"""Form factors by rays: cosine-distributed ones from points of the smaller polygon, counted where they arrive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.sampling import Sampling, run_sampler, sampled_exchange


def ray_exchange(pairs: Pairs, sampling: Sampling) -> Estimate:
    """A F of pairs as ``A_i`` times the share of rays that meet the other polygon.

    Each ray counts 1 or 0, so that no variance is infinite, but a small share takes many rays.
    """
    return sampled_exchange(pairs, _trace, sampling)


def _trace(pairs: Pairs, samples: int, sampling: Sampling) -> NDArray[np.float64]:
    return run_sampler(pairs, "trace_exchange", samples, sampling)
