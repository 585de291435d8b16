"""Form factors of polygons for everybody: one call, any method, value and error (``hradiosity.form_factor``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.device import Device
from hradiosity.transport.form_factor.methods import USED, Method, Settings, pair_exchange
from hradiosity.transport.form_factor.occlusion import Occluders
from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.polygons import MOST_CORNERS, PolygonSet, is_single, polygon_set, stack_corners
from hradiosity.transport.form_factor.sampling import Sequence as PointSequence

PAIRS_AT_ONCE: Final = 2**22
Polygons = ArrayLike | Sequence[ArrayLike]


@dataclass(frozen=True)
class FormFactors:
    """Form factors from a to b, the share of what leaves a diffusely and arrives at b [1].

    Each is a number for one pair, else an array: (n,) for pairs, (n, n) for all of them, from row to column.

    value : visibility included
    error : estimate of its absolute error; a 95 % half width where something random is in it
    visibility : visible share that is in the value; exactly 1 where nothing stands between, which is then proved
    method_code : what made the number, an index of `USED`
    """

    value: Any
    error: Any
    visibility: Any
    method_code: Any

    @property
    def method(self) -> Any:
        """Names of what made each number: a method, ``gauss`` or ``none`` (see `USED`)."""
        names = np.asarray(USED)[self.method_code]
        return str(names) if np.ndim(names) == 0 else names


def form_factor(
    polygon_a: Polygons,
    polygon_b: Polygons,
    *,
    occluders: Polygons | None = None,
    method: Method = "auto",
    tolerance: float | None = None,
    samples: int | None = None,
    resolution: int | None = None,
    sequence: PointSequence = "sobol",
    seed: int = 1,
    visibility_tolerance: float = 5e-3,
    device: Device | None = None,
) -> FormFactors:
    """Form factors from polygons a to polygons b.

    Parameters
    ----------
    polygon_a, polygon_b : (k, 3), (n, k, 3), or a list of n arrays (k_i, 3)
        Corners [m] of plane convex polygons of up to 32 corners, counter-clockwise as seen from the front. Pairs are
        formed in order; one polygon goes with all of the other side.
    occluders : like the polygons, optional
        What may stand between; opaque from both sides. Polygons of a or b may be among them.
    method, tolerance, samples, resolution, sequence, seed
        See `hradiosity.transport.form_factor.methods.Settings`.
    visibility_tolerance : float
        Where something may stand between: 95 % half width to reach for the visible share.
    device : Device, optional
        Hand the same one to many calls: it keeps its kernels.

    Returns
    -------
    FormFactors
        Swapping a and b gives the same numbers in the ratio of the areas.

    Raises
    ------
    ValueError
        A polygon that is no plane convex one (named), or numbers of polygons that don't go together.
    DeviceError
        When the device has no double precision.

    Examples
    --------
    >>> floor = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> ceiling = [[0, 1, 1], [1, 1, 1], [1, 0, 1], [0, 0, 1]]
    >>> round(form_factor(floor, ceiling, method="contour").value, 10)
    0.1998248957
    """
    settings = Settings(
        method=method, tolerance=tolerance, samples=samples, resolution=resolution, sequence=sequence, seed=seed
    )
    (polygons, counts), is_single = _together({"polygon_a": polygon_a, "polygon_b": polygon_b, "occluders": occluders})
    n_a, n_b, _ = counts
    if n_a != n_b and 1 not in (n_a, n_b):
        raise ValueError(f"{n_a} polygons a and {n_b} polygons b make no pairs")
    n = 0 if 0 in (n_a, n_b) else max(n_a, n_b)
    a = np.broadcast_to(np.arange(n_a), (n,)) if n else np.zeros(0, int)
    b = np.broadcast_to(n_a + np.arange(n_b), (n,)) if n else np.zeros(0, int)
    rank = _rank(polygons)
    swap = rank[a] > rank[b]
    pairs = Pairs(polygons, _index(np.where(swap, b, a)), _index(np.where(swap, a, b)), device or Device())
    work = _Work(pairs, n_a + n_b, settings, visibility_tolerance)
    estimate, visibility, used = work.do(pairs)
    area = polygons.area[a]
    columns = (estimate.exchange / area, estimate.error / area, visibility, used)
    if is_single:
        value, error, share = (float(column[0]) for column in columns[:3])
        return FormFactors(value, error, share, int(used[0]))
    return FormFactors(*columns)


def form_factor_matrix(
    polygons: Polygons,
    *,
    occluders: Polygons | None = None,
    method: Method = "auto",
    tolerance: float | None = None,
    samples: int | None = None,
    resolution: int | None = None,
    sequence: PointSequence = "sobol",
    seed: int = 1,
    visibility_tolerance: float = 5e-3,
    device: Device | None = None,
) -> FormFactors:
    """Form factors between all polygons, ``value[i, j]`` from i to j.

    Half of the pairs are computed, the other half follows by reciprocity. Nothing hides anything unless `occluders`
    says so; hand over the polygons themselves where they hide each other. Parameters and errors as in `form_factor`.

    Returns
    -------
    FormFactors
        Of (n, n) arrays; 0 on the diagonal.
    """
    settings = Settings(
        method=method, tolerance=tolerance, samples=samples, resolution=resolution, sequence=sequence, seed=seed
    )
    (together, counts), _ = _together({"polygons": polygons, "occluders": occluders})
    n = counts[0]
    nobody = np.zeros(0, np.uint32)
    everything = Pairs(together, nobody, nobody, device or Device())
    work = _Work(everything, n, settings, visibility_tolerance)
    rank = _rank(together)[:n]
    exchange, error = np.zeros((n, n)), np.zeros((n, n))
    used = np.zeros((n, n), np.uint8)
    visibility = np.zeros((n, n)) if work.occluders else np.broadcast_to(1.0, (n, n))
    for rows, above, first, second in _upper_triangle(rank):
        estimate, share, code = work.do(everything.with_pairs(first, second))
        exchange[rows][above] = estimate.exchange
        error[rows][above] = estimate.error
        used[rows][above] = code
        if work.occluders:
            visibility[rows][above] = share
    for table in (exchange, error, used, *([visibility] if work.occluders else [])):
        table += table.T
    if work.occluders:
        np.fill_diagonal(visibility, 1.0)
    area = together.area[:n, None]
    exchange /= area
    error /= area
    return FormFactors(exchange, error, visibility, used)


class _Work:
    """What is the same for all pairs of a call."""

    def __init__(self, pairs: Pairs, n_seeing: int, settings: Settings, visibility_tolerance: float) -> None:
        if not visibility_tolerance > 0.0:
            raise ValueError(f"visibility_tolerance must be positive, is {visibility_tolerance}")
        self.settings, self.visibility_tolerance = settings, visibility_tolerance
        has_occluders = 0 < n_seeing < len(pairs.polygons)
        self.occluders = Occluders(pairs, n_seeing) if has_occluders else None

    def do(self, pairs: Pairs) -> tuple[Estimate, NDArray[np.float64], NDArray[np.uint8]]:
        """A F, visible share and what made the number, of pairs."""
        estimate, used = pair_exchange(pairs, self.settings)
        share = np.ones(len(pairs))
        seen = np.flatnonzero(estimate.exchange > 0.0)
        if self.occluders is None or len(seen) == 0:
            return estimate, share, used
        found = self.occluders.visibility(pairs.subset(seen), self.visibility_tolerance, self.settings.seed)
        share_error = np.zeros(len(pairs))
        share[seen], share_error[seen] = found.share, found.error
        return estimate.times(share, share_error), share, used


def _together(named: dict[str, Polygons | None]) -> tuple[tuple[PolygonSet, list[int]], bool]:
    """One set of all polygons, how many come from each argument, and whether all but occluders are single ones."""
    stacks = [
        stack_corners(given, name) if given is not None else (np.zeros((0, 3, 3)), np.zeros(0, np.uint32))
        for name, given in named.items()
    ]
    single = [given is None or is_single(given) for given in named.values()]
    labels = [
        name if alone else f"{name}[{i}]"
        for name, alone, (rows, _) in zip(named, single, stacks)
        for i in range(len(rows))
    ]
    # Few lengths of rows, since kernels are built for each.
    most = min(k for k in (4, 8, 16, MOST_CORNERS) if k >= max(rows.shape[1] for rows, _ in stacks))
    corners = np.concatenate([np.pad(rows, ((0, 0), (0, most - rows.shape[1]), (0, 0)), "edge") for rows, _ in stacks])
    count = np.concatenate([number for _, number in stacks])
    return (polygon_set(corners, count, labels), [len(rows) for rows, _ in stacks]), all(single[:2])


def _rank(polygons: PolygonSet) -> NDArray[np.intp]:
    """An order of the polygons, smaller ones first, that does not depend on how they are listed."""
    size = np.round(np.log(polygons.area), 9)
    order = np.lexsort((*polygons.centre.T, size))
    rank = np.empty(len(polygons), np.intp)
    rank[order] = np.arange(len(polygons))
    return rank


def _upper_triangle(
    rank: NDArray[np.intp],
) -> Iterator[tuple[slice, NDArray[np.bool_], NDArray[np.uint32], NDArray[np.uint32]]]:
    """Parts of the pairs i < j: rows, places in them, and the pairs themselves, the one of lower rank first."""
    n = len(rank)
    step = max(1, PAIRS_AT_ONCE // max(n, 1))
    for start in range(0, n - 1, step):
        row = np.arange(start, min(start + step, n), dtype=np.uint32)
        above = np.arange(n, dtype=np.uint32) > row[:, None]
        i = np.repeat(row, n - 1 - row)
        j = np.broadcast_to(np.arange(n, dtype=np.uint32), above.shape)[above]
        swap = np.repeat(rank[row], n - 1 - row) > rank[j]
        i[swap], j[swap] = j[swap], i[swap]
        yield slice(start, start + len(row)), above, i, j


def _index(numbers: NDArray[Any]) -> NDArray[np.uint32]:
    return numbers.astype(np.uint32)
