"""``solution.vtkhdf``: the elements as a mesh that ParaView and pyvista open, and what this program needs beside it.

Written with h5py after the VTKHDF file format, version 2.0, type PolyData (VTK documentation, "VTK File Formats").
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.results_drawing import compression, write_drawing
from hradiosity.metrics.photometric import illuminance, luminance, luminous_exitance
from hradiosity.model.lamps import lamp_exitances, side_luminaires
from hradiosity.model.scene import Scene
from hradiosity.solution import Solution
from hradiosity.space.cells import cell_corners
from hradiosity.space.hierarchy import Elements

if TYPE_CHECKING:
    import h5py

FORMAT = 1
"""Of the group ``hradiosity``; counts up when a reader of the earlier one would go wrong."""
CHECKPOINT = "hradiosity/checkpoint"
UNITS = {
    "exitance": "W m-2 nm-1",
    "irradiance": "W m-2 nm-1",
    "radiance": "W m-2 sr-1 nm-1",
    "radiant_exitance": "W m-2",
    "luminous_exitance": "lm m-2",
    "illuminance": "lx",
    "luminance": "cd m-2",
    "wavelength": "nm",
    "length": "m",
}


def mesh_file(solution: Solution, checkpoint: Mapping[str, NDArray[Any]], digest: str) -> bytes:
    """Content of ``solution.vtkhdf``.

    Parameters
    ----------
    solution : Solution
    checkpoint : mapping of arrays
        From `RadiositySolver.checkpoint`, for another run to go on from.
    digest : str
        Of what the checkpoint belongs to.
    """
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        write_mesh(file.create_group("VTKHDF"), solution.scene, solution.elements, cell_arrays(solution))
        own = file.create_group("hradiosity")
        _write_own(own, solution)
        write_drawing(own, solution.scene, solution.elements)
        write_checkpoint(file, checkpoint, digest)
    return memory.getvalue()


def write_checkpoint(file: h5py.File, checkpoint: Mapping[str, NDArray[Any]], digest: str) -> None:
    """Put a checkpoint into the group ``hradiosity/checkpoint``."""
    group = file.create_group(CHECKPOINT)
    group.attrs["digest"] = digest
    for name, array in checkpoint.items():
        group.create_dataset(name, data=array)


def write_mesh(group: h5py.Group, scene: Scene, elements: Elements, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Points, polygons and what each cell carries."""
    corners, is_triangle = cell_corners(scene.patches, elements)
    keep = np.ones(corners.shape[:2], bool)
    keep[is_triangle, 3] = False
    points = corners[keep]
    offsets = np.concatenate([[0], np.cumsum(keep.sum(axis=1))])
    group.attrs["Version"] = np.array([2, 0])
    group.attrs["Type"] = np.bytes_("PolyData")
    group["NumberOfPoints"] = [len(points)]
    group["Points"] = points
    for kind in ("Vertices", "Lines", "Polygons", "Strips"):
        own = kind == "Polygons"
        part = group.create_group(kind)
        part["NumberOfCells"] = [len(corners) if own else 0]
        part["NumberOfConnectivityIds"] = [len(points) if own else 0]
        part["Offsets"] = offsets if own else np.zeros(1, np.int64)
        part["Connectivity"] = np.arange(len(points) if own else 0)
    data = group.create_group("CellData")
    for name, array in arrays.items():
        data.create_dataset(name, data=array, **compression(array))
    group.create_group("FieldData")["wavelength_nm"] = scene.bands.centre


def cell_arrays(solution: Solution) -> dict[str, NDArray[Any]]:
    """What each cell of the mesh carries, by name; spectra are (n_cells, n_bands) float32 per nanometre."""
    scene, elements, bands = solution.scene, solution.elements, solution.scene.bands
    row = elements.cell_row
    irradiance = solution.surfaces.irradiance[row]
    exitance = solution.exitance[row] + _emitted(solution)
    return {
        "exitance": (exitance / bands.width).astype(np.float32),
        "irradiance": (irradiance / bands.width).astype(np.float32),
        "radiance": (exitance / bands.width / np.pi).astype(np.float32),
        "radiant_exitance": exitance.sum(axis=1).astype(np.float32),
        "luminous_exitance": luminous_exitance(exitance, bands).astype(np.float32),
        "luminance": luminance(exitance / np.pi, bands).astype(np.float32),
        "illuminance": illuminance(irradiance, bands).astype(np.float32),
        **cell_numbers(scene, elements),
    }


def cell_numbers(scene: Scene, elements: Elements) -> dict[str, NDArray[Any]]:
    """Element, material, object and side of each cell."""
    return {
        "element": elements.cell_row.astype(np.int32),
        "material": elements.row_material[elements.cell_row].astype(np.int32),
        "object": scene.patches.object[elements.cell_side // 2].astype(np.int32),
        "side": (elements.cell_side % 2).astype(np.int32),
    }


def _emitted(solution: Solution) -> NDArray[np.float64]:
    """(n_cells, n_bands) exitance that the cells emit themselves [W m⁻² per band]."""
    scene = solution.scene
    exitance = np.concatenate([lamp_exitances(scene), np.zeros((1, len(scene.bands)))])
    return exitance[side_luminaires(scene)[solution.elements.cell_side]]


def _write_own(group: h5py.Group, solution: Solution) -> None:
    """Names, bands, paints and the light of the elements in full."""
    write_names(group, solution.scene)
    group.attrs["replicates"] = solution.replicates
    group["element_area_m2"] = solution.elements.area
    group["element_exposed"] = solution.surfaces.exposed
    group["element_space"] = solution.surfaces.space


def write_names(group: h5py.Group, scene: Scene) -> None:
    """Names, bands and paints."""
    group.attrs["format"] = FORMAT
    group.attrs["scene"] = scene.name
    group.attrs["scene_file"] = str(scene.path or "")
    for name, unit in UNITS.items():
        group.attrs[f"unit_{name}"] = unit
    group["band_lower_nm"] = scene.bands.lower
    group["band_upper_nm"] = scene.bands.upper
    group["wavelength_nm"] = scene.bands.centre
    group["material_reflectance"] = scene.reflectance
    for name, words in (("material_names", [m.name for m in scene.materials]), ("object_names", scene.objects)):
        group[name] = np.array([word.encode() for word in words] or [b""])
