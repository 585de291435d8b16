"""The light of a solution as pictures need it: tristimulus values at vertices of cells and leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.lamps import lamp_emissions
from hradiosity.model.scene import Scene
from hradiosity.show.channels import CHANNELS, emitted_xyz, reflected_channels
from hradiosity.solution import Solution
from hradiosity.space.cell_lookup import CELL_CORNERS, CellFrames, cell_frames
from hradiosity.space.hierarchy import Elements
from hradiosity.space.leaf_vertices import SideRims, find_rims, vertex_keys
from hradiosity.transport.refine import ShadowLight


@dataclass(frozen=True)
class RowLight:
    """Light on the row elements and between them.

    Values have four channels: X, Y, Z of the reflected exitance ρE [lm m⁻²], and the illuminance [lx].

    direct, indirect : (n_rows, 4) float32
    vertex : (n_cells, 4) int32, vertices at the corners of each cell; a triangle repeats its last one
    at_vertex : (n_vertices, 4) float32, indirect light
    """

    direct: NDArray[np.float32]
    indirect: NDArray[np.float32]
    vertex: NDArray[np.int32]
    at_vertex: NDArray[np.float32]


@dataclass(frozen=True)
class PictureScene:
    """What all pictures of a scene share.

    frames : CellFrames
    rims : SideRims
    label : (n_patches, 2) int64, equal where object, material and space of sides are
    grid : (n_patches, 2) int64, cells along the edges
    emitted : (n_sides, 3) float32, X, Y, Z of the emitted exitance [lm m⁻²]
    """

    scene: Scene
    elements: Elements
    frames: CellFrames
    rims: SideRims
    label: NDArray[np.int64]
    grid: NDArray[np.int64]
    emitted: NDArray[np.float32]


def picture_scene(solution: Solution) -> PictureScene:
    """Frames of the cells, joined sides and emission of a solution's scene."""
    scene, elements = solution.scene, solution.elements
    first = elements.first_cell.astype(np.int64)
    lit = first < len(elements.cell_row)
    row = elements.cell_row[np.where(lit, first, 0)]
    space = np.where(lit, solution.surfaces.space[row], -1)
    keys = np.stack([np.repeat(scene.patches.object, 2), elements.side_material.ravel(), space.ravel()], axis=1)
    label = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1, 2)
    return PictureScene(
        scene=scene,
        elements=elements,
        frames=cell_frames(elements, scene.patches.is_triangle),
        rims=find_rims(scene.patches, label),
        label=label,
        grid=elements.divisions.astype(np.int64),
        emitted=emitted_xyz(scene),
    )


def shadow_channels(picture: PictureScene, shadow: ShadowLight) -> NDArray[np.float32]:
    """(n_vertices, 4) channels of the direct light at the vertices of leaves."""
    scene = picture.scene
    n_materials, n_lamps = len(scene.materials) + 1, len(scene.luminaires)
    material = np.repeat(np.arange(n_materials), n_lamps)
    spectra = np.tile(lamp_emissions(scene), (n_materials, 1))
    table = reflected_channels(scene, material, spectra).reshape(n_materials, n_lamps, CHANNELS)
    of_vertex = picture.elements.side_material.ravel()[shadow.vertex_side]
    channels: NDArray[np.float32] = np.einsum("vl,vlc->vc", shadow.per_luminaire, table[of_vertex])
    return channels


def row_light(
    picture: PictureScene,
    solution: Solution,
    shadow: ShadowLight | None,
    gathered: NDArray[np.float64] | None = None,
) -> RowLight:
    """Light of the row elements; the indirect part also at the corners of cells.

    There it comes from `gathered` (n_rows, n_bands), see `hradiosity.show.row_gather`, if that is given.

    With a sky, direct light of the sky goes with the indirect light, as the rows' direct light less that of the
    leaves, since leaves know the emitters' light only.
    """
    scene, elements, surfaces = solution.scene, solution.elements, solution.surfaces
    material = elements.row_material
    direct = reflected_channels(scene, material, surfaces.direct)
    indirect = reflected_channels(scene, material, surfaces.irradiance - surfaces.direct)
    smooth = indirect if gathered is None else reflected_channels(scene, material, gathered)
    if scene.sky is not None and shadow is not None:
        of_sky = np.maximum(direct - _row_means(picture, shadow, direct), 0.0)
        indirect, smooth = indirect + of_sky, smooth + of_sky
    vertex, at_vertex = _corner_means(picture, solution, smooth)
    return RowLight(direct, indirect, vertex, at_vertex)


def _corner_means(
    picture: PictureScene, solution: Solution, of_row: NDArray[np.float32]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Vertices of cells, and area-weighted means over the exposed cells of one surface that meet at each."""
    frames, elements = picture.frames, picture.elements
    patches = picture.scene.patches
    offset = CELL_CORNERS[frames.is_triangle.astype(np.int64)]
    place = frames.corner[:, None, :] + frames.extent[:, None, None] * offset
    side = np.repeat(frames.side, 4)
    keys = vertex_keys(picture.rims, patches.is_triangle, side, place.reshape(-1, 2), picture.grid[side // 2])
    unique, vertex = np.unique(keys, return_inverse=True)
    patch = frames.side // 2
    cell_area = patches.area[patch] / np.prod(picture.grid[patch], axis=1)
    weight = np.repeat(cell_area * (1e-6 + solution.surfaces.exposed[elements.cell_row]), 4)
    weight[3::4][frames.is_triangle] = 0.0
    values = np.repeat(of_row[elements.cell_row], 4, axis=0)
    total = np.bincount(vertex, weight, len(unique))
    sums = [np.bincount(vertex, weight * values[:, c], len(unique)) for c in range(CHANNELS)]
    return vertex.reshape(-1, 4).astype(np.int32), (np.stack(sums, axis=1) / total[:, None]).astype(np.float32)


def _row_means(picture: PictureScene, shadow: ShadowLight, otherwise: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n_rows, 4) mean direct light over the leaves of each row; `otherwise` for rows without leaves."""
    node = np.flatnonzero(shadow.leaves.is_leaf)
    row = picture.elements.cell_row[shadow.leaves.cell[node]]
    weight = 0.25 ** shadow.leaves.level[node].astype(float)
    total = np.bincount(row, weight, len(otherwise))
    mean = leaf_means(shadow, shadow_channels(picture, shadow))[node]
    sums = np.stack([np.bincount(row, weight * mean[:, c], len(otherwise)) for c in range(CHANNELS)], axis=1)
    known = total > 0.0
    return np.where(known[:, None], sums / np.where(known, total, 1.0)[:, None], otherwise).astype(np.float32)


def leaf_means(shadow: ShadowLight, at_vertex: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n_nodes, 4) mean of the direct light over each leaf's fan of triangles; 0 for nodes that are no leaves."""
    triangle = shadow.leaves.is_triangle[:, None]
    weight = np.where(triangle, np.array([2, 2, 2, 0, 3]) / 9.0, np.array([1, 1, 1, 1, 2]) / 6.0)
    vertex = shadow.vertex[:, :5]
    weight = np.where((vertex >= 0) & ~shadow.covered[vertex], weight, 0.0)
    total = weight.sum(axis=1)
    weight /= np.where(total > 0.0, total, 1.0)[:, None]
    means: NDArray[np.float32] = np.einsum("np,npc->nc", weight.astype(np.float32), at_vertex[vertex])
    return means
