"""All form-factor methods behind one call, with what each takes by default."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.auto import cheapest_exchange
from hradiosity.transport.form_factor.hemicube_pairs import hemicube_exchange
from hradiosity.transport.form_factor.hemisphere import hemisphere_exchange
from hradiosity.transport.form_factor.monte_carlo import monte_carlo_exchange
from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.point import point_exchange
from hradiosity.transport.form_factor.quasi_hemisphere import quasi_hemisphere_exchange
from hradiosity.transport.form_factor.rays import ray_exchange
from hradiosity.transport.form_factor.sampling import Sampling, Sequence

Method = Literal[
    "auto", "contour", "hemisphere", "quasi-hemisphere", "hemicube", "monte-carlo", "rays", "point", "point-disk"
]
METHODS: Final[tuple[Method, ...]] = get_args(Method)
USED: Final = ("none", "gauss", *(name for name in METHODS if name != "auto"))
"""What may have made a number: `auto` and `contour` take Gauss points far away, and nothing where polygons see nothing
of each other."""
FAR_TOLERANCE: Final = 1e-9
"""`contour` leaves pairs to Gauss points only where they are that good; there it would lose digits by cancellation."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How to compute form factors.

    method : one of `METHODS`
    tolerance : relative error to reach; None for the method's own: auto and hemisphere 1e-4, contour 1e-8,
        monte-carlo and rays 1e-2. The other methods do as they are told by the next two and report what came of it.
    samples : rays or pairs of points (monte-carlo, rays; None to go on until the tolerance is met), or receiver points
        a direction (hemisphere, None as before; quasi-hemisphere and hemicube, None for 4)
    resolution : chords an edge (quasi-hemisphere, None for 16), or pixels along the top face (hemicube, None for 128)
    sequence : of monte-carlo and rays: scrambled Sobol points, or independent ones
    seed : of everything random
    """

    method: Method = "auto"
    tolerance: float | None = None
    samples: int | None = None
    resolution: int | None = None
    sequence: Sequence = "sobol"
    seed: int = 1

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method must be one of {', '.join(METHODS)}, is {self.method!r}")
        if self.sequence not in get_args(Sequence):
            raise ValueError(f"sequence must be sobol or random, is {self.sequence!r}")
        if self.tolerance is not None and not 0.0 < self.tolerance < np.inf:
            raise ValueError(f"tolerance must be positive and finite, is {self.tolerance}")
        for name in ("samples", "resolution"):
            number = getattr(self, name)
            if number is not None and not 1 <= number < 2**24:
                raise ValueError(f"{name} must lie between 1 and 2**24, is {number}")

    def tolerance_or(self, default: float) -> float:
        """The tolerance that was asked for, else `default`."""
        return default if self.tolerance is None else self.tolerance


def pair_exchange(pairs: Pairs, settings: Settings) -> tuple[Estimate, NDArray[np.uint8]]:
    """A F of pairs by the method of the settings, nothing between them; and who made each number (index of `USED`)."""
    if settings.method == "auto":
        return cheapest_exchange(pairs, settings.tolerance_or(1e-4))
    if settings.method == "contour":
        tolerance = settings.tolerance_or(1e-8)
        return cheapest_exchange(pairs, tolerance, far_tolerance=min(tolerance, FAR_TOLERANCE))
    used = np.full(len(pairs), USED.index(settings.method), np.uint8)
    return _PLAIN[settings.method](pairs, settings), used


def _hemisphere(pairs: Pairs, settings: Settings) -> Estimate:
    return hemisphere_exchange(pairs, settings.tolerance_or(1e-4), settings.samples)


def _quasi_hemisphere(pairs: Pairs, settings: Settings) -> Estimate:
    return quasi_hemisphere_exchange(pairs, settings.samples or 4, settings.resolution or 16)


def _hemicube(pairs: Pairs, settings: Settings) -> Estimate:
    return hemicube_exchange(pairs, settings.samples or 4, settings.resolution or 128, settings.seed)


def _sampling(settings: Settings) -> Sampling:
    return Sampling(settings.samples, settings.tolerance_or(1e-2), settings.sequence, settings.seed)


def _monte_carlo(pairs: Pairs, settings: Settings) -> Estimate:
    return monte_carlo_exchange(pairs, _sampling(settings))


def _rays(pairs: Pairs, settings: Settings) -> Estimate:
    return ray_exchange(pairs, _sampling(settings))


def _point(pairs: Pairs, settings: Settings) -> Estimate:
    return point_exchange(pairs, disks=settings.method == "point-disk")


_PLAIN: Final[dict[str, Callable[[Pairs, Settings], Estimate]]] = {
    "hemisphere": _hemisphere,
    "quasi-hemisphere": _quasi_hemisphere,
    "hemicube": _hemicube,
    "monte-carlo": _monte_carlo,
    "rays": _rays,
    "point": _point,
    "point-disk": _point,
}
