"""What few replicates can not tell of one reading, from readings that are alike."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

COMMON = 4.0
"""Degrees of freedom that the mean variance of a group of readings counts beside a reading's own. Few replicates of a
skewed number that all miss its rare large values come out too low and too sure at once; what is usual for the other
readings then keeps the interval honest. Chosen on the scenes of `hradiosity.suites.coverage`, all but
one of them: none was kept back to judge it."""
ALIKE = 4.0
"""Factor between the illuminances of readings that are taken to be about as bright."""


def alike(
    parts: Sequence[slice], illuminance: NDArray[np.float64], times: NDArray[np.float64] | None = None
) -> NDArray[np.int64]:
    """(n,) number of the group that each reading is in: those of its sensor that are about as bright, within `ALIKE`.

    Dark places are less sure than bright ones; what is usual there says nothing about a desk in the light. Nor do
    readings that had a few samples say much about one that had many: `times` (n,), if given, counts alike.
    """
    sensor = np.repeat(np.arange(len(parts)), [part.stop - part.start for part in parts])
    brightest = np.zeros(len(parts))
    np.maximum.at(brightest, sensor, illuminance)
    share = np.divide(illuminance, brightest[sensor], out=np.zeros_like(illuminance), where=illuminance > 0.0)
    had = np.ones_like(illuminance) if times is None else times
    kinds = np.column_stack([sensor, _step(np.maximum(share, np.finfo(np.float64).tiny)), _step(had)])
    group: NDArray[np.int64] = np.unique(kinds, axis=0, return_inverse=True)[1].ravel()
    return group


def _step(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Number of the interval from a power of `ALIKE` to the next."""
    return np.asarray(np.floor(np.log(values) / np.log(ALIKE)).astype(np.int64))


def usual(values: NDArray[np.float64], group: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, …) mean of the finite values in the group of each; 0 where there are none."""
    known = np.isfinite(values)
    count, total = (np.zeros((int(group.max(initial=-1)) + 1, *values.shape[1:])) for _ in range(2))
    np.add.at(count, group, known)
    np.add.at(total, group, np.where(known, values, 0.0))
    return np.asarray(np.divide(total, count, out=np.zeros_like(total), where=count > 0.0)[group])


def scale_of(value: NDArray[np.float64], *, relative: bool) -> NDArray[np.float64]:
    """(n, …) what errors are compared over: the values, or 1."""
    return np.abs(value) if relative else np.ones_like(value)


def pooled(
    standard_error: NDArray[np.float64],
    value: NDArray[np.float64],
    group: NDArray[np.int64],
    degrees_of_freedom: int,
    *,
    relative: bool,
) -> NDArray[np.float64]:
    """Standard errors (n, …) drawn towards what is usual in the group of each reading, in quadrature.

    Parameters
    ----------
    standard_error, value : (n, …) float64
    group : (n,) int64
        See `alike`.
    degrees_of_freedom : int
        Of the standard errors; below 1 they are left alone.
    relative : bool
        Pool errors over values, and not the errors themselves.
    """
    if degrees_of_freedom < 1:
        return standard_error
    scale = scale_of(value, relative=relative)
    square = np.divide(standard_error, scale, out=np.full_like(value, np.nan), where=scale > 0.0) ** 2
    known = np.isfinite(square)
    own = degrees_of_freedom / (degrees_of_freedom + COMMON)
    mixed = scale * np.sqrt(own * np.where(known, square, 0.0) + (1.0 - own) * usual(square, group))
    return np.where(known, mixed, standard_error)
