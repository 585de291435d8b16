"""Random numbers of the replicates: different ones, or their spread means nothing."""

from __future__ import annotations

import numpy as np

from hradiosity.errors import HradiosityError


def replicate_seed(run_seed: int, replicate: int) -> int:
    """Seed of a replicate, 0 to 2³² − 1.

    Parameters
    ----------
    run_seed : int
        Of the whole run.
    replicate : int
        Its number, from 0.

    Raises
    ------
    HradiosityError
        When an earlier replicate has the same: both would be one estimate, and intervals from their spread too narrow.
    """
    seeds = [_draw(run_seed, k) for k in range(replicate + 1)]
    if seeds[-1] in seeds[:-1]:
        first = seeds.index(seeds[-1])
        raise HradiosityError(
            f"replicates {first + 1} and {replicate + 1} would have the same random numbers (seed {seeds[-1]}): "
            "intervals from their spread would mean nothing; start with another --seed"
        )
    return seeds[-1]


def _draw(run_seed: int, replicate: int) -> int:
    return int(np.random.SeedSequence((run_seed, replicate)).generate_state(1)[0])
