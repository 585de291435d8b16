"""Form factors by random points on both polygons: the double area integral as a mean."""

from __future__ import annotations

from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.sampling import Sampling, sampled_exchange


def monte_carlo_exchange(pairs: Pairs, sampling: Sampling) -> Estimate:
    """A F of pairs as ``A_i A_j`` times the mean of cos cos / (π r²) over pairs of points.

    The kernel grows without bound where polygons touch: its variance is then infinite, and the interval, which comes
    from eight replicates, is too short now and then.
    """
    return sampled_exchange(pairs, "sample_exchange", sampling)
