"""Mending of imported triangles: what exporters leave behind and light transport can't use."""

from dataclasses import replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import RawMesh
from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Note
from hradiosity.model.solids import find_solids
from hradiosity.model.welding import weld_distance

LARGEST_COORDINATE: Final = 1e9
"""Beyond this a coordinate is taken for damage, whatever the unit."""


def clean(mesh: RawMesh, file: str) -> RawMesh:
    """Merge vertices that are one point, then drop faces without area and faces that are there twice.

    "One point" means within ``WELD_TOLERANCE`` of the bounding box diagonal, "without area" that the height of the
    triangle is below that distance. Of faces of one part on the same three vertices the first one stays; two that
    face opposite ways both stay if they belong to solids that touch. Each kind of mending is counted in a note.

    Raises
    ------
    SceneError
        No faces, vertex numbers out of range, or coordinates that aren't finite.
    """
    _check(mesh, file)
    distance = weld_distance(mesh.vertices[np.unique(mesh.triangles)])
    vertices, triangles, face, merged = _weld_with_meshlab(mesh, distance)
    flat = _heights(vertices[triangles]) <= distance
    no_area = len(mesh.triangles) - len(triangles) + int(flat.sum())
    triangles, face = triangles[~flat], face[~flat]
    if not len(triangles):
        raise SceneError([Fault(file, "", "no face has an area", "a mesh of faces")])
    part = mesh.part[face]
    twice = _repeated(vertices, triangles, part, mesh)
    elsewhere = _on_other_parts(triangles[~twice], part[~twice])
    counts: list[tuple[int, Literal["warning", "info"], str]] = [
        (merged, "info", "vertices merged with one within 1e-7 of the size"),
        (no_area, "info", "faces without area left out"),
        (int(twice.sum()), "info", "faces that were there twice left out"),
        (elsewhere, "warning", "faces lie exactly on a face of another part: light meets only one of the two"),
    ]
    notes = tuple(Note(kind, file, f"{count} {what}") for count, kind, what in counts if count)
    kept = replace(mesh, vertices=vertices, triangles=triangles[~twice], part=part[~twice])
    return replace(kept, notes=mesh.notes + notes)


def _check(mesh: RawMesh, file: str) -> None:
    if not len(mesh.triangles):
        raise SceneError([Fault(file, "", "no faces", "a mesh of triangles or polygons")])
    if mesh.triangles.min() < 0 or mesh.triangles.max() >= len(mesh.vertices):
        found = f"a face with vertex {mesh.triangles.max()} of {len(mesh.vertices)}"
        raise SceneError([Fault(file, "", found, "vertex numbers that exist")])
    used = np.unique(mesh.triangles)
    broken = used[~np.isfinite(mesh.vertices[used]).all(axis=1)]
    if len(broken):
        place = ", ".join(f"{value:g}" for value in mesh.vertices[broken[0]])
        first = f"the first is vertex {broken[0] + 1}: ({place})"
        found = f"{len(broken)} vertices that aren't finite, {first}"
        raise SceneError([Fault(file, "vertices", found, "finite coordinates")])
    largest = float(np.abs(mesh.vertices[used]).max())
    if largest > LARGEST_COORDINATE:
        expected = f"coordinates up to {LARGEST_COORDINATE:.0e} in the unit of the file"
        raise SceneError([Fault(file, "vertices", f"a coordinate of {largest:.3g}", expected)])


def _weld_with_meshlab(
    mesh: RawMesh, distance: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64], int]:
    """Vertices, triangles, which triangle of ``mesh`` each was (a scalar on the faces), number of merged vertices."""
    import pymeshlab

    number = np.arange(len(mesh.triangles), dtype=np.float64)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.triangles.astype(np.int32), f_scalar_array=number))
    meshes.meshing_remove_unreferenced_vertices()
    before = meshes.current_mesh().vertex_number()
    if distance > 0.0:
        meshes.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(distance))
    merged = before - meshes.current_mesh().vertex_number()
    meshes.meshing_remove_null_faces()
    meshes.meshing_remove_unreferenced_vertices()
    result = meshes.current_mesh()
    vertices = np.array(result.vertex_matrix(), dtype=np.float64).reshape(-1, 3)
    triangles = np.array(result.face_matrix(), dtype=np.int64).reshape(-1, 3)
    return vertices, triangles, np.array(result.face_scalar_array(), dtype=np.int64), merged


def _heights(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) smallest height of triangles (m, 3, 3), 0 if all corners are one point."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    height: NDArray[np.float64] = np.divide(twice_area, longest, out=np.zeros_like(longest), where=longest > 0.0)
    return height


def _repeated(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], part: NDArray[np.int64], mesh: RawMesh
) -> NDArray[np.bool_]:
    """(m,) faces to leave out because an earlier one of the part has the same vertices."""
    turned = _smallest_first(triangles)
    mirrored = turned[:, 1] > turned[:, 2]
    same_way = _later_ones(np.column_stack([part, turned]))
    any_way = _later_ones(np.column_stack([part, np.sort(turned, axis=1)]))
    if not (any_way & ~same_way).any():
        return same_way
    names = {name: number for number, name in enumerate(dict.fromkeys(label.name for label in mesh.labels))}
    owner = np.array([names[label.name] for label in mesh.labels])[part]
    left = np.flatnonzero(~same_way)
    corners = vertices[triangles[left]][:, [0, 1, 2, 2]]
    solid = np.zeros(len(triangles), dtype=np.bool_)
    solid[left] = find_solids(corners, np.ones(len(left), dtype=np.bool_), owner[left]).solid != NONE
    touching = np.column_stack([part, np.sort(turned, axis=1), np.where(solid, mirrored, 2)])
    return np.where(solid, same_way | _later_ones(touching), any_way)


def _smallest_first(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles turned so that the smallest vertex number comes first; the winding stays."""
    shift = triangles.argmin(axis=1)[:, None]
    return np.take_along_axis(triangles, (np.arange(3) + shift) % 3, axis=1)


def _later_ones(rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(m,) True where an earlier row is equal."""
    _, first = np.unique(rows, axis=0, return_index=True)
    later = np.ones(len(rows), dtype=np.bool_)
    later[first] = False
    return later


def _on_other_parts(triangles: NDArray[np.int64], part: NDArray[np.int64]) -> int:
    """Number of faces that share all vertices with a face of another part."""
    places, place = np.unique(np.sort(triangles, axis=1), axis=0, return_inverse=True)
    lowest = np.full(len(places), len(part) + 1, dtype=np.int64)
    np.minimum.at(lowest, place.ravel(), part)
    return int((part != lowest[place.ravel()]).sum())
