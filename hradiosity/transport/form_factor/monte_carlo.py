"""Form factors by random points on both polygons: the double area integral as a mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.sampling import REPLICATES, Sampling, run_sampler, sampled_exchange


def monte_carlo_exchange(pairs: Pairs, sampling: Sampling) -> Estimate:
    """A F of pairs as ``A_i A_j`` times the mean of cos cos / (π r²) over pairs of points.

    The kernel grows without bound where polygons touch, and its variance is then infinite. Samples alone would not
    know: the area of the places that are nearer to the other polygon than its samples are to each other is added to
    the error.
    """
    return sampled_exchange(pairs, _sample, sampling)


def _sample(pairs: Pairs, samples: int, sampling: Sampling) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    unseen = pairs.device.empty((len(pairs), REPLICATES), np.float64)
    rows = run_sampler(pairs, "sample_exchange", samples, sampling, unseen=unseen)
    return rows, pairs.device.fetch(unseen).mean(axis=1)
