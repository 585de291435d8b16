"""Surfaces of a scene file: rectangles, polygons, boxes and meshes become patches."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_boxes import box_piece
from hradiosity.io.scene_frame import Frame
from hradiosity.io.scene_lines import Location
from hradiosity.io.scene_meshes import mesh_piece
from hradiosity.io.scene_names import Names
from hradiosity.io.scene_pieces import Piece, Surfaces, is_degenerate, join
from hradiosity.io.scene_report import Report
from hradiosity.io.scene_schema import SceneFile
from hradiosity.io.schema_surfaces import PolygonTable, RectangleTable
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.meshing import Pieces
from hradiosity.model.polygons import newell_normal, planarity_defect, polygon_to_patches
from hradiosity.model.solids import find_solids

WARP_WORTH_A_WARNING: Final = 1e-3
"""Largest distance of a corner from the mean plane, over the polygon's size, that goes without a word."""

_REPEATED_CORNER: Final = 1e-9
_NO_AREA: Final = 1e-9


def read_surfaces(tables: SceneFile, frame: Frame, names: Names, report: Report) -> Surfaces:
    """All surfaces of a scene file in metres, z up; faults and warnings go to the report."""
    pieces = list(_pieces(tables, frame, names, report))
    _report_repeated_objects(pieces, report)
    return join([_without_degenerate(piece, report) for piece in pieces])


def _pieces(tables: SceneFile, frame: Frame, names: Names, report: Report) -> Iterator[Piece]:
    for i, rectangle in enumerate(tables.rectangle):
        location: Location = ("rectangle", i)
        yield _rectangle_piece(rectangle, rectangle.name or f"rectangle-{i + 1}", location, frame, names, report)
    for i, polygon in enumerate(tables.polygon):
        location = ("polygon", i)
        yield _polygon_piece(polygon, polygon.name or f"polygon-{i + 1}", location, frame, names, report)
    for i, box in enumerate(tables.box):
        yield box_piece(box, box.name or f"box-{i + 1}", ("box", i), frame, names, report)
    for i, mesh in enumerate(tables.mesh):
        piece = mesh_piece(mesh, ("mesh", i), frame, names, report)
        if piece is not None:
            yield piece


def _rectangle_piece(
    rectangle: RectangleTable, name: str, location: Location, frame: Frame, names: Names, report: Report
) -> Piece:
    edges = frame.points([rectangle.corner, rectangle.edge_u, rectangle.edge_v])
    parts = Pieces(edges[0:1], edges[1:2], edges[2:3], np.array([False]), np.zeros(1, dtype=np.int32))
    return _single_object(rectangle, name, location, parts, names, report)


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
    piece = _single_object(polygon, name, location, _join_faces(parts), names, report)
    solid = piece.patches.solid
    if polygon.solid is None:
        corners = piece.patches.corners()
        solid[:] = find_solids(corners, piece.patches.is_triangle, piece.patches.object).solid
    elif polygon.solid:
        solid[:] = 0
    return piece


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


def _single_object(
    table: RectangleTable | PolygonTable, name: str, location: Location, parts: Pieces, names: Names, report: Report
) -> Piece:
    """A piece of one object, one material and one luminaire, and no solid."""
    names.check_material(table.material, (*location, "material"), report)
    names.check_luminaire(table.luminaire, (*location, "luminaire"), report)
    n = len(parts.origin)
    patches = Patches(
        parts.origin,
        parts.edge_u,
        parts.edge_v,
        parts.is_triangle,
        np.full(n, names.material_index(table.material), dtype=np.int32),
        np.zeros(n, dtype=np.int32),
        parts.surface,
        np.full(n, NONE, dtype=np.int32),
    )
    luminaire = np.full(n, names.luminaire_index(table.luminaire), dtype=np.int32)
    return Piece(location, (name,), patches, luminaire, np.full(n, ""))


def _without_degenerate(piece: Piece, report: Report) -> Piece:
    """The piece less the patches without area, which are reported."""
    degenerate = is_degenerate(piece.patches)
    count = int(degenerate.sum())
    if count > 0 and count == len(piece.patches):
        report.fault(piece.location, f"{_faces(count)} without area", "edges that are neither zero nor parallel")
    elif count > 0:
        report.warn(piece.location, f"{_faces(count)} without area dropped")
    return piece.keep(~degenerate)


def _faces(count: int) -> str:
    return "1 face" if count == 1 else f"{count} faces"


def _report_repeated_objects(pieces: Sequence[Piece], report: Report) -> None:
    seen: set[str] = set()
    for piece in pieces:
        for name in piece.objects:
            if name in seen:
                report.fault(piece.location, f"a second object named {name!r}", "a name of its own")
            seen.add(name)
