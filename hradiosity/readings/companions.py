"""What finer settings would still change, from what coarser companions of some replicates changed."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import EXCHANGE, MESH
from hradiosity.readings.interval import RunningMean, RunningMoments
from hradiosity.readings.pooling import pooled, scale_of, usual

COMPANIONS: Final = MappingProxyType({MESH: 1.0, EXCHANGE: 1.0})
"""By part: share of the change by its companion that stands for what finer settings would still change. Errors fall
with the edge of elements and with the number of rays to the power 1, or faster."""

LEAST_COMPANIONS: Final = 4
"""Before these the noise of a change is not known well enough to take it out."""


def companion_parts(changes: Mapping[str, RunningMean]) -> dict[str, NDArray[np.float64]]:
    """Half widths by part, from what the companions changed; parts without companions are left out."""
    return {part: COMPANIONS[part] * np.abs(found.mean) for part, found in changes.items() if found.count}


def likely_parts(
    changes: Mapping[str, RunningMoments], value: NDArray[np.float64], group: NDArray[np.int64], *, relative: bool
) -> dict[str, NDArray[np.float64]]:
    """As `companion_parts`, without the noise of the changes where there are enough of them.

    Of a change d with the standard error s the share w = τ²/(τ² + s²) is taken to be real, τ² the mean square of the
    group's real changes or of its own, d² − s², whichever is larger; the half width √(w² d² + w s²) is what the true
    change is likely to be (empirical Bayes; Efron & Morris 1973). A change near 0 by chance is no proof of a small
    error, and one that is as large as its noise none of a large one.

    Parameters
    ----------
    changes : mapping
        By part.
    value : (n, …) float64
        The readings.
    group : (n,) int64
        See `hradiosity.readings.pooling.alike`.
    relative : bool
        Compare changes over the values, and not the changes themselves.
    """
    found = companion_parts(changes)
    for part, moments in changes.items():
        if moments.count < LEAST_COMPANIONS:
            continue
        scale = scale_of(value, relative=relative)
        error = pooled(moments.standard_error, value, group, moments.count - 1, relative=relative)
        change, noise = (
            np.divide(some, scale, out=np.full_like(value, np.nan), where=scale > 0.0) ** 2
            for some in (moments.mean, error)
        )
        own = np.maximum(change - noise, 0.0)
        real = np.maximum(np.maximum(usual(change - noise, group), 0.0), own)
        share = np.divide(real, real + noise, out=np.ones_like(value), where=real + noise > 0.0)
        likely = COMPANIONS[part] * scale * np.sqrt(share**2 * change + share * noise)
        found[part] = np.where(np.isfinite(likely), likely, found[part])
    return found
