"""From triangles and polygons to patches: the parallelograms and triangles that everything else works on."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.welding import connected, weld, weld_distance

PARALLELOGRAM_TOLERANCE: Final = 1e-6
"""How far the fourth corner may be from its place, relative to the longest edge."""
SINGLE_PRECISION_NOISE: Final = 2.5e-7
"""Rounding that a corner read from a single precision file carries, relative to the extent of the mesh."""
LARGEST_MISFIT: Final = 1e-3
"""Bound on the misfit of the fourth corner relative to the height of the triangle, whatever the two above allow."""
COPLANAR_SINE: Final = 1e-4
"""Sine of the angle between normals below which neighbouring triangles are one flat surface."""
_PAIRS_AT_AN_EDGE: Final = 3
"""How far apart in the list of triangles at one edge two may stand to be tried as a pair."""


class Pieces(NamedTuple):
    """Patches without material: see ``Patches`` for what origin and edges mean.

    origin, edge_u, edge_v : (k, 3) float64 [m]
    is_triangle : (k,) bool
    surface : (k,) int32, equal for pieces that form one flat, connected face
    """

    origin: NDArray[np.float64]
    edge_u: NDArray[np.float64]
    edge_v: NDArray[np.float64]
    is_triangle: NDArray[np.bool_]
    surface: NDArray[np.int32]


class _Neighbours(NamedTuple):
    """Pairs of triangles on both sides of an edge, wound alike: ``first`` runs start → end, ``second`` back.

    first, second : (k,) int64 triangles
    apex, far : (k, 3) float64, the corners of first and second that are not on the edge
    start, end : (k, 3) float64, the edge as first runs along it
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    apex: NDArray[np.float64]
    far: NDArray[np.float64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]

    def keep(self, which: NDArray[np.bool_]) -> "_Neighbours":
        """The pairs in a mask."""
        return _Neighbours(
            self.first[which], self.second[which], self.apex[which], self.far[which], self.start[which], self.end[which]
        )


def merge_triangles(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> Pieces:
    """Join pairs of triangles that form a parallelogram; the others stay triangles.

    Pairs are taken greedily, those nearest to a rectangle first, each triangle at most once. Which pair wins depends
    on shapes, then on the order of the triangles, so that the result is the same each time. Triangles without area
    are left out. Connected coplanar triangles that face the same way share a surface.

    Parameters
    ----------
    vertices : (n, 3) float64 [m]
        Vertices at the same place need not be shared: they are welded first.
    triangles : (m, 3) int
        Vertex numbers, counter-clockwise as seen from the front.

    Returns
    -------
    Pieces
        Parallelograms and triangles, in the order of their first triangle; ``edge_u × edge_v`` points to the front.

    Raises
    ------
    ValueError
        When the shapes are wrong or a vertex number is out of range.
    """
    return merge_and_trace(vertices, triangles)[0]


def merge_and_trace(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> tuple[Pieces, NDArray[np.int64]]:
    """As `merge_triangles`, and (m,) the piece that each triangle became part of; -1 for one without area."""
    triangles = np.asarray(triangles, dtype=np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"expected (n, 3) vertices and (m, 3) triangles, got {vertices.shape} and {triangles.shape}")
    if triangles.size and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise ValueError(f"triangles count vertices 0 … {len(vertices) - 1}, found up to {triangles.max()}")
    corners = np.asarray(vertices, dtype=np.float64)[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(cross, axis=1)
    kept = twice_area > 0.0
    corners, normal = corners[kept], cross[kept] / twice_area[kept, None]
    pairs = _neighbours(corners)
    extent = float(np.ptp(corners.reshape(-1, 3), axis=0).max()) if len(corners) else 0.0
    fits, score = _parallelograms(pairs, extent)
    joined = pairs.keep(fits)
    joined = joined.keep(_greedy_matching(joined.first, joined.second, score[fits], len(corners)))
    sine = np.linalg.norm(np.cross(normal[pairs.first], normal[pairs.second]), axis=1)
    flat = (sine <= COPLANAR_SINE) & (np.einsum("ij,ij->i", normal[pairs.first], normal[pairs.second]) > 0.0)
    one = np.concatenate([pairs.first[flat], joined.first])
    other = np.concatenate([pairs.second[flat], joined.second])
    surface = connected(one, other, len(corners))
    pieces, piece = _assemble(corners, joined, surface)
    piece_of = np.full(len(kept), -1, dtype=np.int64)
    piece_of[kept] = piece
    return pieces, piece_of


def _assemble(
    corners: NDArray[np.float64], joined: _Neighbours, surface: NDArray[np.int64]
) -> tuple[Pieces, NDArray[np.int64]]:
    """Pieces of the joined pairs and of the triangles left over, ordered by first triangle; the piece of each."""
    origin = corners[:, 0].copy()
    edge_u, edge_v = corners[:, 1] - origin, corners[:, 2] - origin
    is_triangle = np.ones(len(corners), dtype=np.bool_)
    place = np.minimum(joined.first, joined.second)
    origin[place], is_triangle[place] = joined.apex, False
    edge_u[place], edge_v[place] = joined.start - joined.apex, joined.end - joined.apex
    left = np.ones(len(corners), dtype=np.bool_)
    left[np.maximum(joined.first, joined.second)] = False
    numbers = np.unique(surface[left], return_inverse=True)[1].astype(np.int32)
    lowest = np.arange(len(corners))
    lowest[np.maximum(joined.first, joined.second)] = place
    pieces = Pieces(origin[left], edge_u[left], edge_v[left], is_triangle[left], numbers)
    return pieces, (np.cumsum(left) - 1)[lowest]


def _neighbours(corners: NDArray[np.float64]) -> _Neighbours:
    """All pairs of consistently wound triangles with a common edge; corners: (m, 3, 3)."""
    points = corners.reshape(-1, 3)
    number = weld(points, weld_distance(points)).reshape(-1, 3)
    start, end = number.ravel(), np.roll(number, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * (int(number.max(initial=0)) + 1) + high
    order = np.argsort(key, kind="stable")
    here, there = [], []
    for step in range(1, _PAIRS_AT_AN_EDGE + 1):
        a, b = order[:-step], order[step:]
        opposite = (key[a] == key[b]) & (start[a] == end[b]) & (start[a] != end[a])
        here.append(a[opposite])
        there.append(b[opposite])
    a, b = np.concatenate(here), np.concatenate(there)
    following = np.roll(np.arange(len(points)).reshape(-1, 3), -1, axis=1).ravel()
    return _Neighbours(
        a // 3,
        b // 3,
        points[following[following[a]]],
        points[following[following[b]]],
        points[a],
        points[following[a]],
    )


def _parallelograms(pairs: _Neighbours, extent: float) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which pairs form a parallelogram, and how far its angle is from a right one (in steps of the cosine)."""
    edge_u, edge_v = pairs.start - pairs.apex, pairs.end - pairs.apex
    diagonal = pairs.end - pairs.start
    misfit = np.linalg.norm(pairs.apex + pairs.far - pairs.start - pairs.end, axis=1)
    length_u, length_v = np.linalg.norm(edge_u, axis=1), np.linalg.norm(edge_v, axis=1)
    longest = np.maximum(np.maximum(length_u, length_v), np.linalg.norm(diagonal, axis=1))
    height = np.linalg.norm(np.cross(edge_u, edge_v), axis=1) / longest
    allowed = np.maximum(PARALLELOGRAM_TOLERANCE * longest, SINGLE_PRECISION_NOISE * extent)
    fits = misfit <= np.minimum(allowed, LARGEST_MISFIT * height)
    cosine = np.abs(np.einsum("ij,ij->i", edge_u, edge_v)) / (length_u * length_v)
    return fits, np.round(cosine * 1e4).astype(np.int64)


def _greedy_matching(
    first: NDArray[np.int64], second: NDArray[np.int64], score: NDArray[np.int64], n: int
) -> NDArray[np.bool_]:
    """Take pairs in the order of score; of pairs that share a triangle only the earlier one is taken.

    Equal scores are ordered by a fixed shuffle: in list order a strip of n alike triangles would need n rounds, and
    needs log n of them so. In each round, pairs that come first for both of their triangles are taken (locally
    dominant edges give the greedy matching: Preis, STACS 1999).
    """
    shuffle = np.random.default_rng(len(first)).permutation(len(first))
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.lexsort((shuffle, score))] = np.arange(len(first))
    taken = np.zeros(len(first), dtype=np.bool_)
    alive = np.arange(len(first))
    used = np.zeros(n, dtype=np.bool_)
    while len(alive):
        best = np.full(n, len(first), dtype=np.int64)
        np.minimum.at(best, first[alive], rank[alive])
        np.minimum.at(best, second[alive], rank[alive])
        wins = alive[(best[first[alive]] == rank[alive]) & (best[second[alive]] == rank[alive])]
        taken[wins] = True
        used[first[wins]] = used[second[wins]] = True
        alive = alive[~(used[first[alive]] | used[second[alive]])]
    return taken
