"""Form factors by random points on both polygons: the double area integral as a mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.sampling import Sampling, run_sampler, sampled_exchange


def monte_carlo_exchange(pairs: Pairs, sampling: Sampling) -> Estimate:
    """A F of pairs as ``A_i A_j`` times the mean of cos cos / (π r²) over pairs of points.

    The kernel grows without bound where polygons touch, and the variance of evenly drawn points is then infinite. Near
    ones therefore get points along random directions as well, and both are weighed with the balance heuristic.
    """
    return sampled_exchange(pairs, _sample, sampling)


def _sample(pairs: Pairs, samples: int, sampling: Sampling) -> NDArray[np.float64]:
    return run_sampler(pairs, "sample_exchange", samples, sampling)
