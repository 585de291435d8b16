"""Light at the points of a view, and lines between its elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.camera import PicturePoints, ViewHits
from hradiosity.show.channels import CHANNELS
from hradiosity.show.light import PictureScene, RowLight, leaf_means
from hradiosity.space.cell_lookup import locate_cells
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaves import CENTRE
from hradiosity.transport.refine import RefinementGoal, ShadowLight

BATCH = 1 << 18
"""Points shaded at a time."""
_EVERY = 9
"""Of so many samples one takes part in the median illuminance of a view."""
_LEAST_REFERENCE = 1e-6
"""Least reference illuminance over that of the brightest element."""


@dataclass(frozen=True)
class Located:
    """Where the points of a view lie in cells and leaves.

    cell : (n,) int64, negative where no light comes
    s, t : (n,) float32, in the cell
    node : (n,) int32, the leaf, negative where there is none
    leaf_s, leaf_t : (n,) float32, in the leaf
    """

    cell: NDArray[np.int64]
    s: NDArray[np.float32]
    t: NDArray[np.float32]
    node: NDArray[np.int32]
    leaf_s: NDArray[np.float32]
    leaf_t: NDArray[np.float32]


def refinement_goal(
    picture: PictureScene, hits: list[ViewHits], samples: float, of_row: NDArray[np.float64]
) -> RefinementGoal:
    """Leaves for all that is in view.

    Parameters
    ----------
    picture : PictureScene
    hits : list of ViewHits
    samples : float
        Leaves need not be smaller than so many samples where their cell is nearest.
    of_row : (n_rows,) float64
        Illuminance [lx]. A cell's reference is the median over the picture that it is seen in, the darkest one of
        several.
    """
    size = np.full(len(picture.frames.side), np.inf)
    reference = np.full(len(size), np.inf)
    for view in hits:
        parts = [slice(start, start + BATCH) for start in range(0, len(view.side), BATCH)]
        cell = np.concatenate([_cells(picture, view, part)[0] for part in parts])
        lit = cell >= 0
        np.minimum.at(size, cell[lit], samples * view.sample_angle * view.depth[lit])
        in_view = np.unique(cell[lit])
        lux = of_row[picture.elements.cell_row[cell[lit][::_EVERY]]]
        reference[in_view] = np.minimum(reference[in_view], np.median(lux) if len(lux) else np.inf)
    floor = max(float(of_row.max(initial=0.0)) * _LEAST_REFERENCE, 1e-300)
    return RefinementGoal(picture.frames, picture.rims, picture.grid, size, np.clip(reference, floor, None))


def _cells(
    picture: PictureScene, points: PicturePoints | ViewHits, part: slice
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    triangles = picture.scene.patches.is_triangle
    return locate_cells(picture.elements, triangles, points.side[part], points.u[part], points.v[part])


def locate(picture: PictureScene, shadow: ShadowLight, points: PicturePoints | ViewHits) -> Located:
    """Cells and leaves of points."""
    parts = []
    for start in range(0, len(points.side), BATCH):
        cell, s, t = _cells(picture, points, slice(start, start + BATCH))
        parts.append((cell, s, t, *shadow.leaves.locate(cell, s, t)))
    return Located(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def smooth_light(
    picture: PictureScene, rows: RowLight, shadow: ShadowLight, at_vertex: NDArray[np.float32], located: Located
) -> NDArray[np.float32]:
    """(n, 4) channels at points: direct light interpolated in leaves, indirect light in cells."""
    out = np.zeros((len(located.cell), CHANNELS), np.float32)
    for start in range(0, len(out), BATCH):
        part = np.arange(start, min(start + BATCH, len(out)))
        part = part[located.cell[part] >= 0]
        out[part] = indirect_at(picture, rows, located.cell[part], located.s[part], located.t[part])
        out[part] += _direct(picture, rows, shadow, at_vertex, located, part)
    return out


def _direct(
    picture: PictureScene,
    rows: RowLight,
    shadow: ShadowLight,
    at_vertex: NDArray[np.float32],
    located: Located,
    part: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Direct light at some points; of the row where all vertices around are covered by solids."""
    cell, node = located.cell[part], np.maximum(located.node[part], 0)
    triangle = picture.frames.is_triangle[cell]
    vertices, weights = fan_weights(shadow.vertex, node, located.leaf_s[part], located.leaf_t[part], triangle)
    weights = np.where(shadow.covered[vertices], np.float32(0.0), weights)
    total = weights.sum(axis=1)
    good = (total > 1e-6) & (located.node[part] >= 0)
    weights /= np.where(good, total, 1.0)[:, None]
    light: NDArray[np.float32] = np.einsum("nk,nkc->nc", weights, at_vertex[vertices])
    light[~good] = rows.direct[picture.elements.cell_row[cell[~good]]]
    return light


def indirect_at(
    picture: PictureScene, rows: RowLight, cell: NDArray[np.int64], s: NDArray[np.float32], t: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(n, 4) channels of the indirect light in cells: bilinear, or barycentric in triangles."""
    triangle = picture.frames.is_triangle[cell]
    a, b = np.float32(1.0) - s, np.float32(1.0) - t
    one = np.float32(1.0)
    weights = (
        np.where(triangle, one - s - t, a * b),
        np.where(triangle, s, s * b),
        np.where(triangle, t, s * t),
        np.where(triangle, np.float32(0.0), a * t),
    )
    out = np.zeros((len(cell), CHANNELS), np.float32)
    for corner, weight in enumerate(weights):
        out += weight[:, None] * rows.at_vertex[rows.vertex[cell, corner]]
    return out


def flat_light(
    picture: PictureScene, rows: RowLight, shadow: ShadowLight, at_vertex: NDArray[np.float32], located: Located
) -> NDArray[np.float32]:
    """(n, 4) channels at points: the mean of each leaf's direct light, the indirect light of its row."""
    means = leaf_means(shadow, at_vertex)
    row = picture.elements.cell_row[np.maximum(located.cell, 0)]
    vertex = shadow.vertex[:, : CENTRE + 1]
    uncovered = np.any(~shadow.covered[vertex] & (vertex >= 0), axis=1)
    known = np.flatnonzero(located.node >= 0)
    known = known[uncovered[located.node[known]]]
    direct = rows.direct[row]
    direct[known] = means[located.node[known]]
    light = rows.indirect[row] + direct
    light[located.cell < 0] = 0.0
    return light


def line_mask(number: NDArray[np.integer], width: int, thickness: int) -> NDArray[np.bool_]:
    """(n,) samples on boundaries between regions of equal numbers.

    Parameters
    ----------
    number : (n,) int
        Region of each sample, row by row.
    width : int
        Samples in a row.
    thickness : int
        Width of the lines in samples.
    """
    image = number.reshape(-1, width)
    lines = np.zeros(image.shape, np.bool_)
    across, down = image[:, 1:] != image[:, :-1], image[1:] != image[:-1]
    for shift in range(thickness):
        offset = shift - (thickness - 1) // 2
        for mask, axis in ((across, 1), (down, 0)):
            index = np.nonzero(mask)
            moved = index[axis] + offset
            inside = (moved >= 0) & (moved < image.shape[axis])
            place = list(index)
            place[axis] = moved
            lines[place[0][inside], place[1][inside]] = True
    return lines.ravel()
