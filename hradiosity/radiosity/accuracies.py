"""How accurate all readings are, part by part."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.estimate import EXCHANGE, MESH, SAMPLING, UNSEEN, student_quantile
from hradiosity.solution import Readings

LEAST_OWN: Final = 0.1
"""Of a reading's variance, what is its own at least: that of the elements is itself an estimate."""


@dataclass(frozen=True)
class Accuracies:
    """Half widths of all readings over what accuracy refers to (see `Readings.accuracy`), part by part.

    sampling : (n,) float64, that more samples and replicates narrow; light that no sample found yet is part of it
    mesh : (n,) float64, that smaller elements narrow
    exchange : (n,) float64, that more rays from each element narrow
    other : (n,) float64, all others in quadrature
    common : (n,) float64, of the sampling, what comes from the noise of the elements for certain: samples of the
        readings leave that as it is
    """

    sampling: NDArray[np.float64]
    mesh: NDArray[np.float64]
    exchange: NDArray[np.float64]
    other: NDArray[np.float64]
    common: NDArray[np.float64]

    @classmethod
    def of(cls, readings: dict[str, Readings], noise: NDArray[np.float64], replicates: int) -> Accuracies:
        """Of all readings, in the order of the sensors, after some replicates.

        Parameters
        ----------
        noise : (n,) float64
            Variance of one replicate that comes from the elements, over the square of the mean.
        """
        parts = [_relative_parts(found) for found in readings.values()]
        joined = [np.concatenate([np.zeros(0), *(part[k] for part in parts)]) for k in range(4)]
        sampling, mesh, exchange, other = joined
        common = student_quantile(0.95, replicates - 1) * np.sqrt(noise / replicates)
        return cls(sampling, mesh, exchange, other, np.minimum(common, sampling))

    def foreseen(self, done: int, replicates: int) -> Accuracies:
        """As expected after `replicates` instead of the `done` ≥ 2 that they are from."""
        quantiles = student_quantile(0.95, replicates - 1) / student_quantile(0.95, done - 1)
        shrunk = quantiles * (done / replicates) ** 0.5
        return replace(self, sampling=shrunk * self.sampling, common=shrunk * self.common)

    def without_fixed(self) -> Accuracies:
        """With the noise alone."""
        none = np.zeros_like(self.sampling)
        return replace(self, mesh=none, exchange=none, other=none)

    @property
    def own(self) -> NDArray[np.float64]:
        """(n,) of the sampling, what samples of the readings narrow."""
        return np.asarray(np.sqrt(np.maximum(self.sampling**2 - self.common**2, LEAST_OWN * self.sampling**2)))

    @property
    def fixed(self) -> NDArray[np.float64]:
        """(n,) all but sampling, in quadrature."""
        return np.asarray(np.sqrt(self.mesh**2 + self.exchange**2 + self.other**2))

    @property
    def total(self) -> NDArray[np.float64]:
        """(n,) all in quadrature."""
        return np.asarray(np.hypot(self.sampling, self.fixed))


def _relative_parts(found: Readings) -> tuple[NDArray[np.float64], ...]:
    estimate = found.numbers["illuminance"]
    base = found.accuracy_base
    share = np.divide(estimate.factor, base, out=np.zeros_like(base), where=base > 0.0)
    parts, none = estimate.parts, np.zeros_like(base)
    named = ((SAMPLING, UNSEEN), (MESH,), (EXCHANGE,))
    rest = tuple(name for name in parts if not any(name in some for some in named))
    return tuple(share * _quadrature([parts[name] for name in some if name in parts], none) for some in (*named, rest))


def _quadrature(parts: list[NDArray[np.float64]], none: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(np.sum([part**2 for part in parts] or [none], axis=0)))
