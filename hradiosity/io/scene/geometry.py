"""Surfaces of a scene file: rectangles, polygons, boxes and meshes become patches."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.boxes import boxes_piece
from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.meshes import mesh_piece
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.pieces import Piece, Surfaces, is_degenerate, join
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema import SceneFile
from hradiosity.io.scene.schema_surfaces import PolygonTable, RectangleTable
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.meshing import Pieces
from hradiosity.model.polygons import WARP_WORTH_A_WARNING, newell_normal, planarity_defect, polygon_to_patches
from hradiosity.model.solids import find_solids

_REPEATED_CORNER: Final = 1e-9
_NO_AREA: Final = 1e-9


def read_surfaces(tables: SceneFile, frame: Frame, names: Names, report: Report) -> Surfaces:
    """All surfaces of a scene file in metres, z up; faults and warnings go to the report."""
    surfaces = join(list(_pieces(tables, frame, names, report)))
    _report_repeated_objects(surfaces, report)
    return _without_degenerate(surfaces, report)


def _pieces(tables: SceneFile, frame: Frame, names: Names, report: Report) -> Iterator[Piece]:
    yield _rectangles_piece(tables.rectangle, frame, names, report)
    for i, polygon in enumerate(tables.polygon):
        yield _polygon_piece(polygon, polygon.name or f"polygon-{i + 1}", ("polygon", i), frame, names, report)
    yield boxes_piece(tables.box, frame, names, report)
    for i, mesh in enumerate(tables.mesh):
        piece = mesh_piece(mesh, ("mesh", i), frame, names, report)
        if piece is not None:
            yield piece


def _rectangles_piece(rectangles: Sequence[RectangleTable], frame: Frame, names: Names, report: Report) -> Piece:
    """All rectangles, one patch and one object each."""
    n = len(rectangles)
    vectors = [(rectangle.corner, rectangle.edge_u, rectangle.edge_v) for rectangle in rectangles]
    origin, edge_u, edge_v = np.moveaxis(frame.points(np.array(vectors).reshape(-1, 3, 3)), 1, 0)
    for i, rectangle in enumerate(rectangles):
        names.check_material(rectangle.material, ("rectangle", i, "material"), report)
        names.check_luminaire(rectangle.luminaire, ("rectangle", i, "luminaire"), report)
    number = np.arange(n, dtype=np.int32)
    material = np.array([names.material_index(rectangle.material) for rectangle in rectangles], dtype=np.int32)
    patches = Patches(
        origin, edge_u, edge_v, np.zeros(n, dtype=bool), material, number, number, np.full(n, NONE, dtype=np.int32)
    )
    return Piece(
        tuple(rectangle.name or f"rectangle-{i + 1}" for i, rectangle in enumerate(rectangles)),
        tuple(("rectangle", i) for i in range(n)),
        patches,
        np.array([names.luminaire_index(rectangle.luminaire) for rectangle in rectangles], dtype=np.int32),
        np.full(n, ""),
    )


def _polygon_piece(
    polygon: PolygonTable, name: str, location: Location, frame: Frame, names: Names, report: Report
) -> Piece:
    vertices = frame.points(polygon.vertices)
    faces = polygon.faces if polygon.faces is not None else [list(range(len(vertices)))]
    before = len(report.faults)
    cuts = [_cut_face(vertices, face, number, location, report) for number, face in enumerate(faces)]
    parts = [cut for cut in cuts if cut is not None]
    dropped = len(cuts) - len(parts)
    if len(report.faults) == before and dropped > 0:
        if not parts:
            report.fault(location, f"{_faces(dropped)} without area", "corners that are not on one line")
        else:
            report.warn(location, f"{_faces(dropped)} without area dropped")
    names.check_material(polygon.material, (*location, "material"), report)
    names.check_luminaire(polygon.luminaire, (*location, "luminaire"), report)
    cut = _join_faces(parts)
    n = len(cut.origin)
    number = np.zeros(n, dtype=np.int32)
    material = np.full(n, names.material_index(polygon.material), dtype=np.int32)
    solid = np.full(n, 0 if polygon.solid else NONE, dtype=np.int32)
    patches = Patches(cut.origin, cut.edge_u, cut.edge_v, cut.is_triangle, material, number, cut.surface, solid)
    if polygon.solid is None:
        patches.solid[:] = find_solids(patches.corners(), patches.is_triangle, patches.object).solid
    luminaire = np.full(n, names.luminaire_index(polygon.luminaire), dtype=np.int32)
    return Piece((name,), (location,), patches, luminaire, np.full(n, ""))


def _cut_face(
    vertices: NDArray[np.float64], face: Sequence[int], number: int, location: Location, report: Report
) -> Pieces | None:
    """One face of a polygon table in pieces; None if it has no area, or a fault."""
    if max(face, default=0) >= len(vertices):
        report.fault(location, f"face {number} names vertex {max(face)}", f"numbers from 0 to {len(vertices) - 1}")
        return None
    corners = vertices[list(face)]
    step = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    corners = corners[step > _REPEATED_CORNER * step.max(initial=0.0)]
    if len(corners) < 3 or np.linalg.norm(newell_normal(corners)) <= _NO_AREA * step.max() ** 2:
        return None
    try:
        warp = planarity_defect(corners)
        pieces = polygon_to_patches(corners)
    except ValueError as error:
        report.fault(location, f"face {number}: {error}", "corners in order around the face")
        return None
    if warp > WARP_WORTH_A_WARNING:
        report.warn(
            location, f"face {number} is not flat: a corner is {100 * warp:.2g} % of its size off; cut into triangles"
        )
    return pieces


def _join_faces(parts: Sequence[Pieces]) -> Pieces:
    """Pieces of several faces, each face a surface of its own."""
    empty = Pieces(
        np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=bool), np.zeros(0, dtype=np.int32)
    )
    counted = [part._replace(surface=np.full(len(part.surface), i, dtype=np.int32)) for i, part in enumerate(parts)]
    columns = [np.concatenate(column) for column in zip(empty, *counted, strict=True)]
    return Pieces(*columns)


def _without_degenerate(surfaces: Surfaces, report: Report) -> Surfaces:
    """The surfaces less the patches without area, which are reported."""
    degenerate = is_degenerate(surfaces.patches)
    owner = surfaces.patches.object
    for number in np.unique(owner[degenerate]):
        count, location = int(degenerate[owner == number].sum()), surfaces.locations[number]
        if count == int((owner == number).sum()):
            report.fault(location, f"{_faces(count)} without area", "edges that are neither zero nor parallel")
        else:
            report.warn(location, f"{_faces(count)} without area dropped")
    return surfaces.keep(~degenerate)


def _faces(count: int) -> str:
    return "1 face" if count == 1 else f"{count} faces"


def _report_repeated_objects(surfaces: Surfaces, report: Report) -> None:
    seen: set[str] = set()
    for name, location in zip(surfaces.objects, surfaces.locations, strict=True):
        if name in seen:
            report.fault(location, f"a second object named {name!r}", "a name of its own")
        seen.add(name)
