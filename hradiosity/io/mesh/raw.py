"""What a mesh file holds before units and axes are applied; shared by the readers of the formats."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.polygons import WARP_WORTH_A_WARNING, planarity_defect, triangulate
from hradiosity.model.scene import Note


@dataclass(frozen=True)
class Texture:
    """A picture that gives a material its colour.

    name : as the mesh file has it
    source : the file, the bytes of a picture inside the mesh file, or None where there is none that could be read
    factor : linear sRGB that the picture is multiplied by
    """

    name: str
    source: Path | bytes | None
    factor: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class PartLabel:
    """Names as they stand in the file; ``material`` is empty where the file names none."""

    name: str
    material: str
    texture: Texture | None = None


@dataclass(frozen=True)
class RawMesh:
    """Triangles in the unit and axes of the file.

    vertices : (n, 3) float64, unit of the file
    triangles : (m, 3) int64, counter-clockwise as seen from the front
    part : (m,) int64, index into ``labels``
    labels : parts in the order of the file
    notes : what was left out or mended
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    part: NDArray[np.int64]
    labels: tuple[PartLabel, ...]
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        if self.triangles.shape != (len(self.part), 3) or self.vertices.shape != (len(self.vertices), 3):
            raise ValueError(
                f"triangles {self.triangles.shape}, part {self.part.shape}, vertices {self.vertices.shape}"
            )


class CutFaces(NamedTuple):
    """Faces of any number of corners, cut into triangles.

    triangles : (m, 3) int64
    face : (m,) int64, the face each triangle comes from, ascending
    warp : (n_faces,) float64, largest distance of a corner from the face's mean plane, relative to the face's size
    doubtful : number of faces with more than four corners whose edges cross or that have no area; they are cut as
        fans from their first corner
    """

    triangles: NDArray[np.int64]
    face: NDArray[np.int64]
    warp: NDArray[np.float64]
    doubtful: int


def triangulate_faces(vertices: NDArray[np.float64], faces: Sequence[Sequence[int]]) -> CutFaces:
    """Cut faces of any number of corners, given as vertex numbers, into triangles."""
    count = np.fromiter((len(face) for face in faces), dtype=np.int64, count=len(faces))
    triangles, owners = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    warp = np.zeros(len(faces))
    doubtful = 0
    three = np.flatnonzero(count == 3)
    if len(three):
        triangles.append(np.array([faces[i] for i in three.tolist()], dtype=np.int64))
        owners.append(three)
    four = np.flatnonzero(count == 4)
    if len(four):
        quads = np.array([faces[i] for i in four.tolist()], dtype=np.int64)
        triangles.append(_split_quads(vertices, quads))
        owners.append(np.repeat(four, 2))
        warp[four] = _quad_warp(vertices[quads])
    for index in np.flatnonzero(count > 4).tolist():
        corners = np.array(faces[index], dtype=np.int64)
        try:
            local = triangulate(vertices[corners])
            warp[index] = planarity_defect(vertices[corners])
        except ValueError:
            doubtful += 1
            around = np.arange(1, len(corners) - 1)
            local = np.stack([np.zeros_like(around), around, around + 1], axis=1)
        triangles.append(corners[local])
        owners.append(np.full(len(local), index))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return CutFaces(np.concatenate(triangles)[order], owner[order], warp, doubtful)


def notes_on_faces(cut: CutFaces, place: str) -> tuple[Note, ...]:
    """What is worth knowing about faces that were cut."""
    notes = []
    if cut.doubtful:
        notes.append(Note("warning", place, f"{cut.doubtful} faces have crossing edges or no area; cut as fans"))
    bent = int((cut.warp > WARP_WORTH_A_WARNING).sum())
    if bent:
        worst = f"in the worst one a corner is {100 * cut.warp.max():.2g} % of its size off"
        notes.append(Note("warning", place, f"{bent} faces are not flat: {worst}; cut into triangles"))
    return tuple(notes)


def _quad_warp(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) as `planarity_defect`, of quads (n, 4, 3); 0 for those without area."""
    about = corner - corner.mean(axis=1, keepdims=True)
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    height = np.abs(np.einsum("nkd,nd->nk", about, normal)).max(axis=1, initial=0.0)
    scale = np.linalg.norm(normal, axis=1) * np.linalg.norm(about, axis=2).max(axis=1, initial=0.0)
    warp: NDArray[np.float64] = np.divide(height, scale, out=np.zeros_like(height), where=scale > 0.0)
    return warp


def _split_quads(vertices: NDArray[np.float64], quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """(2 k, 3) triangles: cut along the diagonal that stays inside a concave quad, else along the shorter one."""
    corner = vertices[quads]
    first, second = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    normal = np.cross(first, second)

    def smaller_half(shift: int) -> NDArray[np.float64]:
        a, b, c, d = (corner[:, (k + shift) % 4] for k in range(4))
        one = np.einsum("ij,ij->i", np.cross(b - a, c - a), normal)
        other = np.einsum("ij,ij->i", np.cross(c - a, d - a), normal)
        return np.asarray(np.minimum(one, other), dtype=np.float64)

    shorter = np.linalg.norm(second, axis=1) < np.linalg.norm(first, axis=1) * (1.0 - 1e-9)
    along_first, along_second = smaller_half(0) > 0.0, smaller_half(1) > 0.0
    turn = np.where(along_first & along_second, shorter, along_second & ~along_first)
    quads = np.where(turn[:, None], np.roll(quads, -1, axis=1), quads)
    return np.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
