"""Planar convex polygons as form factors take them: checked, in float64, with what every method asks of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

MOST_CORNERS: Final = 32
"""Kernels hold both polygons of a pair in private arrays of this length at most."""
_BENT: Final = 1e-6
"""Distance from the mean plane, or from the inside of an edge, relative to the size, that still counts as 0."""
_NO_AREA: Final = 1e-12
"""Area relative to the squared size that counts as 0."""
_ROUNDING: Final = 8 * float(np.finfo(np.float64).eps)
"""Far from the world's origin corners are rounded by this share of their coordinates."""


@dataclass(frozen=True)
class PolygonSet:
    """Polygons of up to k corners.

    corners : (n, k, 3) float64 [m], relative to `local_origin`, counter-clockwise seen from the front; polygons of
        fewer corners repeat their last one
    count : (n,) uint32, corners of each
    normal : (n, 3) float64, unit
    centre : (n, 3) float64 [m], centroid of the area, relative to `local_origin`
    area : (n,) float64 [m²]
    radius : (n,) float64 [m], of the sphere about the centroid that holds the polygon
    local_origin : (3,) float64 [m]
    """

    corners: NDArray[np.float64]
    count: NDArray[np.uint32]
    normal: NDArray[np.float64]
    centre: NDArray[np.float64]
    area: NDArray[np.float64]
    radius: NDArray[np.float64]
    local_origin: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.corners)

    def subset(self, chosen: NDArray[Any]) -> PolygonSet:
        """Some of the polygons, by index."""
        return PolygonSet(
            self.corners[chosen],
            self.count[chosen],
            self.normal[chosen],
            self.centre[chosen],
            self.area[chosen],
            self.radius[chosen],
            self.local_origin,
        )


def stack_corners(polygons: ArrayLike | Sequence[ArrayLike], name: str) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Corners (n, k, 3) and their number (n,) of one polygon (k, 3), equal ones (n, k, 3), or a list of any.

    Raises
    ------
    ValueError
        Shapes that are no polygons, fewer than three corners, more than `MOST_CORNERS`, or coordinates that are not
        finite; names the polygon as ``name[index]``.
    """
    single = is_single(polygons)
    listed: Sequence[Any] = [polygons] if single else polygons  # type: ignore[assignment]
    if isinstance(listed, np.ndarray) and listed.ndim == 3:
        rows = list(np.asarray(listed, np.float64))
    else:
        rows = [_float_array(row, name if single else f"{name}[{i}]") for i, row in enumerate(listed)]
    for i, row in enumerate(rows):
        if row.ndim != 2 or row.shape[1] != 3 or not 3 <= len(row) <= MOST_CORNERS:
            raise ValueError(f"{name if single else f'{name}[{i}]'}: {_wrong_shape(row)}")
    count = np.array([len(row) for row in rows], np.uint32)
    most = int(count.max(initial=3))
    corners = np.zeros((len(rows), most, 3))
    if len(rows):
        starts = np.cumsum(count) - count
        within = np.minimum(np.arange(most), count[:, None].astype(np.int64) - 1)
        corners[:] = np.concatenate(rows)[starts[:, None].astype(np.int64) + within]
    wild = np.flatnonzero(~np.isfinite(corners).all(axis=(1, 2)))
    if len(wild):
        raise ValueError(f"{name if single else f'{name}[{wild[0]}]'}: coordinates must be finite")
    return corners, count


def _wrong_shape(row: NDArray[np.float64]) -> str:
    if row.ndim != 2 or row.shape[1] != 3:
        return f"corners must have the shape (k, 3), have {row.shape}"
    return f"a polygon needs 3 to {MOST_CORNERS} corners, has {len(row)}"


def is_single(polygons: Any) -> bool:
    """Whether it is one polygon, (k, 3), and no collection of them."""
    if isinstance(polygons, np.ndarray):
        return polygons.ndim == 2
    return len(polygons) > 0 and np.ndim(polygons[0]) == 1


def _float_array(polygon: ArrayLike, label: str) -> NDArray[np.float64]:
    try:
        return np.asarray(polygon, np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{label}: corners must be rows of three numbers") from None


def polygon_set(corners: NDArray[np.float64], count: NDArray[Any], labels: Sequence[str]) -> PolygonSet:
    """Check polygons and derive area, normal and centroid.

    Parameters
    ----------
    corners : (n, k, 3) float64 [m], world frame
    count : (n,) corners that count
    labels : how messages call each polygon

    Raises
    ------
    ValueError
        A polygon without area, not plane, or not convex.
    """
    local_origin = _local_origin(corners)
    local = corners - local_origin
    middle = local.mean(axis=1, keepdims=True)
    about = local - middle
    after = np.roll(about, -1, axis=1)
    area_vector = _area_vector(local)
    area = np.linalg.norm(area_vector, axis=1)
    size = np.linalg.norm(about, axis=2).max(axis=1, initial=0.0)
    flat = ~(area > _NO_AREA * size**2)
    _refuse(flat, labels, "has no area: its corners lie on a line, coincide, or its edges cross")
    normal = area_vector / area[:, None]
    rounding = _ROUNDING * np.abs(corners).max(axis=(1, 2), initial=0.0)
    slack = _BENT * size + rounding
    bent = np.abs(np.einsum("nkd,nd->nk", about, normal)).max(axis=1, initial=0.0) > slack
    _refuse(bent, labels, "is not plane: cut it into triangles")
    _refuse(_dented(about, after, normal, slack), labels, "is not convex: cut it into convex pieces")
    centre = middle[:, 0] + _centroid(about, normal)
    radius = np.linalg.norm(local - centre[:, None], axis=2).max(axis=1, initial=0.0)
    return PolygonSet(local, count.astype(np.uint32), normal, centre, area, radius, local_origin)


def _area_vector(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normal times area [m²], with all digits even for slivers.

    A fan of triangles about the first corner, of each the two shorter sides: the product of two long ones that are
    nearly parallel leaves a normal so crooked that a common edge seems to lie in front of the plane, and is cut off.
    """
    first, second = corners[:, 1:-1], corners[:, 2:]
    apex = np.broadcast_to(corners[:, :1], first.shape)
    side = np.stack([first - apex, second - first, apex - second])
    longest = np.linalg.norm(side, axis=3).argmax(axis=0)[None, ..., None]
    one, other = (np.take_along_axis(side, (longest + k) % 3, axis=0)[0] for k in (1, 2))
    area_vector: NDArray[np.float64] = 0.5 * np.cross(one, other).sum(axis=1)
    return area_vector


def _local_origin(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """A point near the polygons where they are far from the world's origin, so round that no difference is rounded."""
    low, high = corners.min(axis=(0, 1), initial=np.inf), corners.max(axis=(0, 1), initial=-np.inf)
    if len(corners) == 0:
        return np.zeros(3)
    middle, half = 0.5 * (low + high), float(0.5 * (high - low).max())
    step = 2.0 ** np.ceil(np.log2(half))
    origin: NDArray[np.float64] = np.where(np.abs(middle) > 4.0 * half, np.round(middle / step) * step, 0.0)
    return origin


def _refuse(bad: NDArray[np.bool_], labels: Sequence[str], why: str) -> None:
    if bad.any():
        raise ValueError(f"{labels[int(np.flatnonzero(bad)[0])]} {why}")


def _dented(
    about: NDArray[np.float64], after: NDArray[np.float64], normal: NDArray[np.float64], slack: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether some corner lies outside of some edge."""
    side = after - about
    length = np.linalg.norm(side, axis=2, keepdims=True)
    inward = np.cross(normal[:, None], np.divide(side, length, out=np.zeros_like(side), where=length > 0.0))
    depth = np.einsum("ned,nkd->nek", inward, about) - np.einsum("ned,ned->ne", inward, about)[..., None]
    outside: NDArray[np.bool_] = depth.min(axis=(1, 2), initial=0.0) < -slack
    return outside


def _centroid(about: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centroids of the area, from a fan of triangles about the first corner."""
    first = about[:, :1]
    one, other = about[:, 1:-1] - first, about[:, 2:] - first
    weight = np.einsum("nkd,nd->nk", np.cross(one, other), normal)
    weight /= weight.sum(axis=1, keepdims=True)
    centroid: NDArray[np.float64] = first[:, 0] + np.einsum("nk,nkd->nd", weight, one + other) / 3.0
    return centroid
