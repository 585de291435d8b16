"""Where patches stand on others: segments along which an edge of one patch meets the inside of another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.welding import weld

COINCIDENT: Final = 1e-6
"""Edges this near to a plane lie in it, relative to the scene's size."""
_PARALLEL: Final = 1e-3
"""Sine of the angle below which a patch that lies in the plane is no more than a sheet flush with it."""
_SAME_LINE: Final = 3e-5
"""Lines are one when direction and offset, relative to the patch, differ by less."""
_MOST_PAIRS: Final = 1 << 20
"""Pairs of patches that are looked at in one go."""


@dataclass(frozen=True)
class Contacts:
    """Segments inside patches, each as long as several edges that lie behind one another on a line.

    patch : (m,) int64
    start, end : (m, 2) float64, in the patch's plane from its origin, along `plane_axes` [m]
    solid : (m,) bool, only faces of solids stand there
    """

    patch: NDArray[np.int64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    solid: NDArray[np.bool_]

    @property
    def length(self) -> NDArray[np.float64]:
        """(m,) [m]."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    def keep(self, which: NDArray[np.bool_]) -> Contacts:
        """The contacts in a mask."""
        return Contacts(self.patch[which], self.start[which], self.end[which], self.solid[which])


def plane_axes(patches: Patches) -> NDArray[np.float64]:
    """(n, 2, 3) unit vectors in each patch's plane: along edge_u, and square to it on the side of edge_v."""
    length = np.linalg.norm(patches.edge_u, axis=1, keepdims=True)
    along = np.divide(patches.edge_u, length, out=np.zeros_like(patches.edge_u), where=length > 0.0)
    return np.stack([along, np.cross(patches.normal, along)], axis=1)


def find_contacts(patches: Patches, bases: NDArray[np.bool_], shortest: NDArray[np.float64], gap: float) -> Contacts:
    """Segments along which other patches meet the inside of those in `bases`.

    Parameters
    ----------
    patches : Patches
    bases : (n,) bool
        Patches to look at; what meets the others is not looked for.
    shortest : (n,) float64
        Edges of each patch below this length count for nothing, even when they make up a longer line [m].
    gap : float
        An edge that ends as far from the plane still meets it [m].

    Notes
    -----
    Two patches that pass through each other meet where they cross. Sheets that lie flush in the plane of another don't
    count: a solid's faces beside the flush one have the same edges. Segments along the outline of a patch, nearer to it
    than the gap, are left out.
    """
    geometry = _Geometry(patches)
    corners = geometry.corners.reshape(-1, 3)
    rounding = COINCIDENT * float(np.linalg.norm(np.ptp(corners, axis=0))) if len(patches) else 0.0
    parts = [
        _contacts_of_pairs(geometry, base, other, shortest, max(gap, rounding), rounding)
        for base, other in _near_pairs(geometry, bases, shortest, gap)
    ]
    if not parts:
        return Contacts(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, bool))
    columns = zip(*((part.patch, part.start, part.end, part.solid) for part in parts), strict=True)
    return _join_lines(Contacts(*(np.concatenate(column) for column in columns)), 2.0 * geometry.radius)


class _Geometry:
    """What is needed of the patches, computed once.

    corners : (n, 4, 3) [m]
    normal : (n, 3)
    axes : (n, 2, 3), see `plane_axes`
    middle, radius : (n, 3), (n,), a ball that holds the patch [m]
    """

    def __init__(self, patches: Patches) -> None:
        self.patches = patches
        self.corners, self.normal = patches.corners(), patches.normal
        self.axes = plane_axes(patches)
        self.middle = patches.origin + 0.5 * (patches.edge_u + patches.edge_v)
        diagonals = np.stack([patches.edge_u + patches.edge_v, patches.edge_u - patches.edge_v])
        self.radius = np.asarray(0.5 * np.linalg.norm(diagonals, axis=2).max(axis=0), np.float64)


def _near_pairs(
    geometry: _Geometry, bases: NDArray[np.bool_], shortest: NDArray[np.float64], gap: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Bases, and other patches whose balls overlap with theirs and reach their planes, in parts of bounded size."""
    from scipy.spatial import cKDTree

    middle, radius = geometry.middle, geometry.radius
    level = np.ceil(np.log2(np.maximum(radius, np.finfo(float).tiny))).astype(np.int64)
    others = radius >= 0.5 * shortest
    found: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    for other_level in np.unique(level[others]):
        numbers = np.flatnonzero(others & (level == other_level))
        tree = cKDTree(middle[numbers])
        for base_level in np.unique(level[bases]):
            members = np.flatnonzero(bases & (level == base_level))
            reach = 2.0 ** float(base_level) + 2.0 ** float(other_level) + gap
            step = max(1, _MOST_PAIRS // len(numbers))
            for first in range(0, len(members), step):
                some = members[first : first + step]
                near = cKDTree(middle[some]).sparse_distance_matrix(tree, reach, output_type="ndarray")
                base, other = some[near["i"]], numbers[near["j"]]
                close = (near["v"] <= radius[base] + radius[other] + gap) & (base != other)
                base, other = base[close], other[close]
                height = np.einsum("ij,ij->i", middle[other] - middle[base], geometry.normal[base])
                close = np.abs(height) <= radius[other] + gap
                found.append((base[close], other[close]))
                if sum(len(part) for part, _ in found) > _MOST_PAIRS:
                    yield _together(found)
                    found = []
    if found:
        yield _together(found)


def _together(
    found: list[tuple[NDArray[np.int64], NDArray[np.int64]]],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.concatenate([base for base, _ in found]), np.concatenate([other for _, other in found])


def _contacts_of_pairs(
    geometry: _Geometry,
    base: NDArray[np.int64],
    other: NDArray[np.int64],
    shortest: NDArray[np.float64],
    gap: float,
    rounding: float,
) -> Contacts:
    """Contacts of pairs of patches, clipped to the base."""
    patches, normal = geometry.patches, geometry.normal
    corners = geometry.corners[other] - patches.origin[base, None]
    height = np.einsum("mcd,md->mc", corners, normal[base])
    meets = np.flatnonzero((height.min(axis=1) <= gap) & (height.max(axis=1) >= -gap))
    base, other, height, corners = base[meets], other[meets], height[meets], corners[meets]
    flush = np.abs(height).max(axis=1) <= rounding
    flush &= np.linalg.norm(np.cross(normal[base], normal[other]), axis=1) <= _PARALLEL
    kept = ~flush
    base, other, height, corners = base[kept], other[kept], height[kept], corners[kept]
    flat = np.einsum("mcd,mad->mca", corners, geometry.axes[base])
    row, start, end = _edges_in_plane(flat, height, gap)
    crossing, low, high = _crossings(flat, height, gap)
    row, start, end = np.concatenate([row, crossing]), np.concatenate([start, low]), np.concatenate([end, high])
    long = np.linalg.norm(end - start, axis=1) >= shortest[other[row]]
    row, start, end = row[long], start[long], end[long]
    start, end, inside = _clipped(start, end, outlines(patches, geometry.axes, base[row]), gap)
    inside &= np.linalg.norm(end - start, axis=1) >= shortest[other[row]]
    row = row[inside]
    return Contacts(base[row], start[inside], end[inside], patches.solid[other[row]] != NONE)


def _edges_in_plane(
    flat: NDArray[np.float64], height: NDArray[np.float64], gap: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Row, start and end of the edges that lie within the gap from the plane."""
    near = np.abs(height) <= gap
    row, corner = np.nonzero(near & np.roll(near, -1, axis=1))
    return row, flat[row, corner], flat[row, (corner + 1) % 4]


def _crossings(
    flat: NDArray[np.float64], height: NDArray[np.float64], gap: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Row, start and end of the chords along which patches pass through the plane."""
    through = np.flatnonzero((height.min(axis=1) < -gap) & (height.max(axis=1) > gap))
    flat, height = flat[through], height[through]
    above = height > 0.0
    row, corner = np.nonzero(above != np.roll(above, -1, axis=1))
    following = (corner + 1) % 4
    share = height[row, corner] / (height[row, corner] - height[row, following])
    point = flat[row, corner] + share[:, None] * (flat[row, following] - flat[row, corner])
    return through[row[::2]], point[::2], point[1::2]


def outlines(patches: Patches, axes: NDArray[np.float64], which: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m, 4, 2) corners of patches in their planes, counter-clockwise; a triangle repeats its last corner."""
    u = np.einsum("md,mad->ma", patches.edge_u[which], axes[which])
    v = np.einsum("md,mad->ma", patches.edge_v[which], axes[which])
    opposite = np.where(patches.is_triangle[which, None], v, u + v)
    return np.stack([np.zeros_like(u), u, opposite, v], axis=1)


def _clipped(
    start: NDArray[np.float64], end: NDArray[np.float64], outline: NDArray[np.float64], margin: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Segments clipped to convex outlines (Cyrus & Beck 1978), and which are inside and not along a border."""
    side = np.roll(outline, -1, axis=1) - outline
    length = np.linalg.norm(side, axis=2)
    real = length > 0.0
    inward = np.stack([-side[..., 1], side[..., 0]], axis=2) / np.where(real, length, 1.0)[..., None]
    first = np.einsum("mkd,mkd->mk", start[:, None] - outline, inward)
    last = np.einsum("mkd,mkd->mk", end[:, None] - outline, inward)
    along_border = (real & (first < margin) & (last < margin)).any(axis=1)
    change = last - first
    cut = np.divide(-first, change, out=np.zeros_like(first), where=change != 0.0)
    entry = np.where(change > 0.0, cut, 0.0).max(axis=1)
    leave = np.where(change < 0.0, cut, 1.0).min(axis=1)
    entry, leave = np.maximum(entry, 0.0)[:, None], np.minimum(leave, 1.0)[:, None]
    step = end - start
    return start + entry * step, start + leave * step, (entry < leave)[:, 0] & ~along_border


def _join_lines(contacts: Contacts, size: NDArray[np.float64]) -> Contacts:
    """Segments of one line in one patch that touch or overlap, joined; size: (n,) of patches [m]."""
    if len(contacts.patch) == 0:
        return contacts
    length, scale = contacts.length, size[contacts.patch]
    along = (contacts.end - contacts.start) / length[:, None]
    turned = (along[:, 0] < -0.5 * _SAME_LINE) | ((np.abs(along[:, 0]) <= 0.5 * _SAME_LINE) & (along[:, 1] < 0.0))
    along[turned] *= -1.0
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset = np.einsum("ij,ij->i", contacts.start, across) / scale
    number = np.unique(contacts.patch, return_inverse=True)[1]
    line = weld(np.column_stack([along[:, 0] + 4.0 * number, along[:, 1], offset]), _SAME_LINE)
    longest = np.lexsort((-length, line))
    leader = longest[np.unique(line[longest], return_index=True)[1]][np.unique(line, return_inverse=True)[1]]
    ends = np.stack([contacts.start, contacts.end], axis=1)
    place = np.einsum("med,md->me", ends - contacts.start[leader, None], along[leader])
    low, high = place.min(axis=1), place.max(axis=1)
    apart = 4.0 * float(size.max()) * np.unique(line, return_inverse=True)[1]
    order = np.argsort(low + apart, kind="stable")
    reached = np.maximum.accumulate((high + apart)[order])
    begins = np.concatenate([[True], (low + apart)[order][1:] > reached[:-1] + _SAME_LINE * scale[order][1:]])
    begin = np.flatnonzero(begins)
    lead = leader[order[begin]]
    low_end, high_end = low[order[begin]], np.maximum.reduceat(high[order], begin)
    return Contacts(
        contacts.patch[lead],
        contacts.start[lead] + low_end[:, None] * along[lead],
        contacts.start[lead] + high_end[:, None] * along[lead],
        np.logical_and.reduceat(contacts.solid[order], begin),
    )
