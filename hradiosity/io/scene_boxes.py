"""Boxes: blocks of matter and rooms."""

from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_frame import Frame, rotation
from hradiosity.io.scene_lines import Location
from hradiosity.io.scene_names import Names
from hradiosity.io.scene_pieces import Piece
from hradiosity.io.scene_report import Report
from hradiosity.io.schema_surfaces import BoxFace, BoxFaces, BoxTable
from hradiosity.model.geometry import NONE, Patches

FACES: Final[tuple[BoxFace, ...]] = get_args(BoxFace)
_UPRIGHT: Final = ("left", "right", "front", "back")

# Corner, edge_u and edge_v of each face of the unit cube, in the order of FACES, with edge_u × edge_v outwards.
_UNIT_CUBE: Final = np.array(
    [
        [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
        [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
    ],
    dtype=np.float64,
)


def box_piece(box: BoxTable, name: str, location: Location, frame: Frame, names: Names, report: Report) -> Piece:
    """The faces of a box as patches; faults in its names go to the report."""
    used = np.array([face not in _single_faces(box.omit) for face in FACES])
    if not used.any():
        report.fault((*location, "omit"), "every face is left out", "a box with at least one face")
    luminaires = dict.fromkeys(FACES, box.luminaire) | _by_face(box.luminaires)
    materials = dict.fromkeys(FACES, box.material) | _by_face(box.faces)
    bare = [face for face, is_used in zip(FACES, used, strict=True) if is_used and materials[face] is None]
    if bare:
        report.fault(location, f"no material for {', '.join(bare)}", "`material`, or an entry of `faces`")
    _report_unknown_names(box, location, names, report)
    origin, edge_u, edge_v = _corners_and_edges(box, location, frame, report)
    if box.inside:
        edge_u, edge_v = edge_v, edge_u
    n = len(FACES)
    is_solid = not box.inside and bool(used.all())
    patches = Patches(
        origin,
        edge_u,
        edge_v,
        np.zeros(n, dtype=bool),
        np.array([names.material_index(materials[face]) for face in FACES], dtype=np.int32),
        np.zeros(n, dtype=np.int32),
        np.arange(n, dtype=np.int32),
        np.full(n, 0 if is_solid else NONE, dtype=np.int32),
    )
    luminaire = np.array([names.luminaire_index(luminaires[face]) for face in FACES], dtype=np.int32)
    return Piece(location, (name,), patches, luminaire, np.array(FACES)).keep(used)


def _single_faces(faces: list[BoxFaces]) -> set[str]:
    return {single for face in faces for single in (_UPRIGHT if face == "sides" else (face,))}


def _by_face(entries: dict[BoxFaces, str]) -> dict[BoxFace, str | None]:
    """Entries by single face; one for a single face wins over 'sides'."""
    spread: dict[BoxFace, str | None] = {}
    for face in FACES:
        if face in entries:
            spread[face] = entries[face]
        elif face in _UPRIGHT and "sides" in entries:
            spread[face] = entries["sides"]
    return spread


def _report_unknown_names(box: BoxTable, location: Location, names: Names, report: Report) -> None:
    names.check_material(box.material, (*location, "material"), report)
    names.check_luminaire(box.luminaire, (*location, "luminaire"), report)
    for face, material in box.faces.items():
        names.check_material(material, (*location, "faces", face), report)
    for face, luminaire in box.luminaires.items():
        names.check_luminaire(luminaire, (*location, "luminaires", face), report)


def _corners_and_edges(
    box: BoxTable, location: Location, frame: Frame, report: Report
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(6, 3) corner, edge_u and edge_v of the faces [m], normals outwards."""
    size = np.abs(frame.points(box.size))
    if box.corner is not None:
        pivot = frame.points(box.corner)
        # Turning y up reverses an axis, so the lowest corner of the file need not be the lowest one here.
        lowest = np.minimum(pivot, pivot + frame.points(box.size))
    else:
        pivot = frame.points(box.centre or (0.0, 0.0, 0.0))
        lowest = pivot - 0.5 * size
    axis = np.array([0.0, 0.0, 1.0])
    if box.rotation_axis is not None:
        axis = frame.directions(box.rotation_axis)
        if not axis.any():
            report.fault((*location, "rotation_axis"), "[0, 0, 0] has no direction", "a vector with a length")
            axis = np.array([0.0, 0.0, 1.0])
    turn = np.eye(3) if box.rotation_deg == 0.0 else rotation(axis, box.rotation_deg)
    origin = (lowest + _UNIT_CUBE[:, 0] * size - pivot) @ turn.T + pivot
    return origin, (_UNIT_CUBE[:, 1] * size) @ turn.T, (_UNIT_CUBE[:, 2] * size) @ turn.T
