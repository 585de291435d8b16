"""Triangles of mesh files: what is mended and counted, what is a fault, faces of many corners."""

import numpy as np
import pytest

from hradiosity.errors import SceneError
from hradiosity.io.mesh.clean import clean
from hradiosity.io.mesh.raw import PartLabel, RawMesh, Texture, triangulate_faces
from hradiosity.model.meshing import merge_triangles

QUAD = np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
ONE_PART = (PartLabel("a", "m"),)


def raw(vertices, triangles, part=None, labels=ONE_PART):
    part = np.zeros(len(triangles), dtype=np.int64) if part is None else np.array(part)
    return RawMesh(np.array(vertices, dtype=float), np.array(triangles, dtype=np.int64), part, labels)


def test_mending_is_done_and_counted():
    vertices = [*QUAD, QUAD[2] + 1e-8, [1, 0, 0]]
    triangles = [[0, 1, 2], [0, 4, 3], [1, 2, 0], [2, 1, 0], [0, 5, 1]]
    cleaned = clean(raw(vertices, triangles), "f.obj")
    assert len(cleaned.triangles) == 2 and len(merge_triangles(cleaned.vertices, cleaned.triangles).origin) == 1
    assert [note.message.split(" ")[:2] for note in cleaned.notes] == [
        ["1", "vertices"],
        ["1", "faces"],
        ["2", "faces"],
    ]


def test_materials_survive_mending():
    labels = (PartLabel("a", "red"), PartLabel("a", "blue", Texture("x.png", None)))
    cleaned = clean(raw([*QUAD, *QUAD], [[0, 1, 1], [0, 1, 2], [4, 6, 7]], [1, 0, 1], labels), "f.obj")
    areas = {tuple(sorted(map(tuple, cleaned.vertices[t]))): int(p) for t, p in zip(cleaned.triangles, cleaned.part)}
    assert areas == {((0, 0, 0), (2, 0, 0), (2, 3, 0)): 0, ((0, 0, 0), (0, 3, 0), (2, 3, 0)): 1}


def test_common_face_of_touching_solids_stays():
    """Two tetrahedra on both sides of one triangle, in one part: nothing is left out."""
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1]]
    upper = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    lower = [[0, 1, 2], [1, 0, 4], [2, 1, 4], [0, 2, 4]]
    assert len(clean(raw(vertices, upper + lower), "f").triangles) == 8
    assert len(clean(raw(vertices, [*upper, lower[0], *lower[2:]]), "f").triangles) == 6


def test_faces_on_faces_of_another_part_are_warned_about():
    labels = (PartLabel("a", "red"), PartLabel("a", "blue"))
    cleaned = clean(raw(QUAD, [[0, 1, 2], [2, 1, 0]], [0, 1], labels), "f.obj")
    assert len(cleaned.triangles) == 2 and cleaned.notes[0].kind == "warning"


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (QUAD, np.empty((0, 3)), "no faces"),
        (QUAD, [[0, 1, 4]], "vertex 4 of 4"),
        ([*QUAD[:3], [np.nan, 0, 0]], [[0, 1, 3]], "vertex 4: .nan"),
        ([*QUAD[:3], [1e30, 0, 0]], [[0, 1, 3]], "1e.30"),
        (QUAD, [[0, 1, 1]], "no face has an area"),
        (np.zeros((3, 3)), [[0, 1, 2]], "no face has an area"),
    ],
)
def test_unusable_meshes_are_faults(vertices, triangles, message):
    with pytest.raises(SceneError, match=message):
        clean(raw(vertices, triangles), "f.obj")


def test_faces_of_many_corners_are_cut_inside_their_outline():
    arrow = [[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]]
    house = [[5, 0, 0], [6, 0, 0], [6, 1, 0], [5.5, 2, 0], [5, 1, 0]]
    bow = [[0, 5, 0], [2, 7, 0], [2, 5, 0], [0, 6, 0], [-1, 5.5, 0]]
    vertices = np.array(arrow + house + bow, dtype=float)
    triangles, face, warp, doubtful = triangulate_faces(vertices, [[0, 1, 2, 3], range(4, 9), [0, 1, 2], range(9, 14)])
    np.testing.assert_array_equal(face, [0, 0, 1, 1, 1, 2, 3, 3, 3])
    corners = vertices[triangles[:5]]
    z = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (z > 0).all() and doubtful == 1 and not warp.any()
    np.testing.assert_allclose([z[:2].sum(), z[2:].sum()], [2 * 1.5, 2 * 1.5])
