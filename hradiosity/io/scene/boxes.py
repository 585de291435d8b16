"""Boxes: blocks of matter and rooms."""

from collections.abc import Sequence
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.frame import Frame, rotations
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.pieces import Piece, select
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_surfaces import BoxFace, BoxFaces, BoxTable
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


def boxes_piece(boxes: Sequence[BoxTable], frame: Frame, names: Names, report: Report) -> Piece:
    """The faces of all boxes as patches, box by box in the order of FACES; faults in names go to the report."""
    n = len(boxes)
    material, luminaire = np.zeros((n, 6), dtype=np.int32), np.full((n, 6), NONE, dtype=np.int32)
    used = np.ones((n, 6), dtype=bool)
    for i, box in enumerate(boxes):
        location: Location = ("box", i)
        _check(box, location, names, report)
        omitted = _single_faces(box.omit)
        used[i] = [face not in omitted for face in FACES]
        materials = dict.fromkeys(FACES, box.material) | _by_face(box.faces)
        luminaires = dict.fromkeys(FACES, box.luminaire) | _by_face(box.luminaires)
        material[i] = [names.material_index(materials[face]) for face in FACES]
        luminaire[i] = [names.luminaire_index(luminaires[face]) for face in FACES]
    origin, edge_u, edge_v = _corners_and_edges(boxes, frame, report)
    is_room = np.array([box.inside for box in boxes], dtype=bool)
    flip = is_room[:, None, None]
    edge_u, edge_v = np.where(flip, edge_v, edge_u), np.where(flip, edge_u, edge_v)
    is_solid = used.all(axis=1) & ~is_room
    patches = Patches(
        origin.reshape(-1, 3),
        edge_u.reshape(-1, 3),
        edge_v.reshape(-1, 3),
        np.zeros(6 * n, dtype=bool),
        material.ravel(),
        np.repeat(np.arange(n, dtype=np.int32), 6),
        np.arange(6 * n, dtype=np.int32),
        np.repeat(np.where(is_solid, np.arange(n), NONE).astype(np.int32), 6),
    )
    kept = used.ravel()
    return Piece(
        tuple(box.name or f"box-{i + 1}" for i, box in enumerate(boxes)),
        tuple(("box", i) for i in range(n)),
        select(patches, kept),
        luminaire.ravel()[kept],
        np.tile(np.array(FACES), n)[kept],
    )


def _check(box: BoxTable, location: Location, names: Names, report: Report) -> None:
    """Report unknown names, faces without material and boxes without faces."""
    omitted = _single_faces(box.omit)
    if len(omitted) == len(FACES):
        report.fault((*location, "omit"), "every face is left out", "a box with at least one face")
    own = _by_face(box.faces)
    bare = [face for face in FACES if face not in omitted and face not in own and box.material is None]
    if bare:
        report.fault(location, f"no material for {', '.join(bare)}", "`material`, or an entry of `faces`")
    names.check_material(box.material, (*location, "material"), report)
    names.check_luminaire(box.luminaire, (*location, "luminaire"), report)
    for face, material in box.faces.items():
        names.check_material(material, (*location, "faces", face), report)
    for face, luminaire in box.luminaires.items():
        names.check_luminaire(luminaire, (*location, "luminaires", face), report)


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


def _corners_and_edges(
    boxes: Sequence[BoxTable], frame: Frame, report: Report
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(n, 6, 3) corner, edge_u and edge_v of the faces [m], normals outwards."""
    extent = frame.points(np.array([box.size for box in boxes]).reshape(-1, 3))
    pivot = frame.points(np.array([box.corner or box.centre for box in boxes]).reshape(-1, 3))
    is_corner = np.array([box.corner is not None for box in boxes], dtype=bool)[:, None]
    size = np.abs(extent)
    # Turning y up reverses an axis, so the lowest corner of the file need not be the lowest one here.
    lowest = np.where(is_corner, np.minimum(pivot, pivot + extent), pivot - 0.5 * size)
    turn = _turns(boxes, frame, report)
    corner = _turned(turn, (lowest - pivot)[:, None] + _UNIT_CUBE[:, 0] * size[:, None]) + pivot[:, None]
    return corner, _turned(turn, _UNIT_CUBE[:, 1] * size[:, None]), _turned(turn, _UNIT_CUBE[:, 2] * size[:, None])


def _turned(turn: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 6, 3) vectors turned by (n, 3, 3) rotations."""
    return np.asarray(np.einsum("nij,nfj->nfi", turn, vectors))


def _turns(boxes: Sequence[BoxTable], frame: Frame, report: Report) -> NDArray[np.float64]:
    """(n, 3, 3) rotations of boxes."""
    upright = (0.0, 0.0, 1.0)
    given = np.array([box.rotation_axis or upright for box in boxes], np.float64).reshape(-1, 3)
    own = np.array([box.rotation_axis is not None for box in boxes], np.bool_)
    axis = np.where(own[:, None], frame.directions(given), upright)
    angle = np.array([box.rotation_deg for box in boxes], np.float64)
    pointless = ~axis.any(axis=1)
    for i in np.flatnonzero(pointless):
        report.fault(("box", int(i), "rotation_axis"), "[0, 0, 0] has no direction", "a vector with a length")
    still = pointless | (angle == 0.0)
    turn = np.tile(np.eye(3), (len(boxes), 1, 1))
    turn[~still] = rotations(axis[~still], angle[~still])
    return turn
