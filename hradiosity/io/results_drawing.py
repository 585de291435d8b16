"""What a window draws of a solution beside the mesh: where cells lie, what shines, cameras.

It stands in the group ``hradiosity/drawing`` of ``solution.vtkhdf``, and in the files of a run that is being watched.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.model.lamps import lamp_exitances, lamp_flux, side_luminaires
from hradiosity.model.scene import Scene
from hradiosity.space.cell_lookup import CELL_CORNERS, cell_frames
from hradiosity.space.hierarchy import Elements
from hradiosity.space.row_squares import row_squares

if TYPE_CHECKING:
    import h5py

DRAWING: Final = "drawing"
"""Name of the group."""
VIEW_NUMBERS: Final = 12
"""Of a camera: position, direction and up, horizontal field of view [degrees], width and height [pixels]."""


def write_drawing(group: h5py.Group, scene: Scene, elements: Elements) -> None:
    """Put it into the group ``drawing`` of `group`.

    For each cell: patch, corners on the grid of its side, size of that grid, cells along an edge of its element, and
    the luminaire that it shines as. Then all luminaires, point sources, views, sky, and the flux of all lamps.
    """
    own = group.create_group(DRAWING)
    frames = cell_frames(elements, scene.patches.is_triangle)
    offset = CELL_CORNERS[frames.is_triangle.astype(np.int64)]
    place = frames.corner[:, None, :] + frames.extent[:, None, None] * offset
    arrays = {
        "cell_patch": (elements.cell_side // 2).astype(np.int32),
        "cell_place": seen_places(place, frames.side, frames.is_triangle).astype(np.int32),
        "cell_grid": elements.divisions[frames.side // 2].astype(np.int32),
        "cell_width": _element_widths(scene, elements),
        "cell_luminaire": side_luminaires(scene)[elements.cell_side],
    }
    for name, array in arrays.items():
        own.create_dataset(name, data=array, **compression(array))
    n_bands, at_points = len(scene.bands), scene.emitters.patch == NONE
    own["luminaire_exitance"] = lamp_exitances(scene)
    own["point_position"] = scene.emitters.position[at_points]
    own["point_luminaire"] = scene.emitters.luminaire[at_points]
    own["lamp_flux"] = lamp_flux(scene)
    own["sky_radiance"] = np.zeros(n_bands) if scene.sky is None else scene.sky.radiance
    numbers = [
        [*view.position, *view.direction, *view.up, view.field_of_view, view.width, view.height] for view in scene.views
    ]
    own["views"] = np.array(numbers, np.float64).reshape(len(numbers), VIEW_NUMBERS)
    own["luminaire_names"] = np.array([lamp.name.encode() for lamp in scene.luminaires] or [b""])
    own["view_names"] = np.array([view.name.encode() for view in scene.views] or [b""])


def seen_places(place: NDArray[np.int64], side: NDArray[np.int64], is_triangle: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(n, 4, 2) places of corners in the order of `place_corners`: turned round on backs."""
    turned = np.where(is_triangle[:, None, None], place[:, [2, 1, 0, 0]], place[:, ::-1])
    seen: NDArray[np.int64] = np.where((side % 2 == 1)[:, None, None], turned, place)
    return seen


def compression(array: NDArray[Any]) -> dict[str, Any]:
    """Filters that every HDF5 reader has, for what is large."""
    return {"compression": "gzip", "compression_opts": 1, "shuffle": True} if array.nbytes > 1 << 16 else {}


def _element_widths(scene: Scene, elements: Elements) -> NDArray[np.int32]:
    """(n_cells,) cells along an edge of the element that each cell is part of; 1 in a group of faces."""
    if not len(elements):
        return np.zeros(0, np.int32)
    squares = row_squares(scene.patches, elements)
    width = np.maximum(elements.divisions[squares.side // 2, 0].astype(np.int64) // squares.grid[:, 0], 1)
    return np.where(squares.single, width, 1).astype(np.int32)[elements.cell_row]
