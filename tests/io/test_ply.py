"""PLY files of all kinds: the same mesh whatever the format, and a fault that names the place where there is none."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from hradiosity.errors import SceneError
from hradiosity.io.mesh.ply import read_ply

FORMATS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {"u1": "uchar", "u2": "ushort", "u4": "uint", "i1": "int8", "i2": "int16", "i4": "int32", "f4": "float"}
TYPES |= {"f8": "double"}


def encoded(form, value, kind):
    return f"{value!r} ".encode() if form == "ascii" else np.array(value, FORMATS[form] + kind).tobytes()


def ply(form, vertices, faces, *, number="f8", count="u1", index="i4", newline="\n", faces_first=False, more=True):
    """Vertices with a normal and a quality, faces with a colour and a list of flags, and an element of edges."""
    columns = [("nx", number), ("x", number), ("y", number), ("quality", "u2"), ("z", number)]
    vertex = [f"element vertex {len(vertices)}", *(f"property {TYPES[kind]} {name}" for name, kind in columns)]
    face = [f"element face {len(faces)}"]
    face += ["property uchar red"] if more else []
    face += [f"property list {TYPES[count]} {TYPES[index]} vertex_indices"]
    face += ["property list int8 float flags"] if more else []
    edge = ["element edge 2", "property int vertex1", "property int vertex2"]
    blocks = [face, vertex] if faces_first else [vertex, face]
    lines = ["ply", f"format {form} 1.0", "comment made by a test", *edge, *blocks[0], *blocks[1], "end_header", ""]
    points = b"".join(
        encoded(form, value, kind)
        for x, y, z in np.asarray(vertices).tolist()
        for value, (_, kind) in zip((0.0, x, y, 7, z), columns, strict=True)
    )
    corners = b""
    for corner in faces:
        corners += encoded(form, 9, "u1") if more else b""
        corners += encoded(form, len(corner), count) + b"".join(encoded(form, int(c), index) for c in corner)
        flags = [0.5] * (len(corner) % 3)
        corners += (encoded(form, len(flags), "i1") + b"".join(encoded(form, f, "f4") for f in flags)) * more
    edges = b"".join(encoded(form, value, "i4") for value in (0, 1, 1, 2))
    body = [corners, points] if faces_first else [points, corners]
    return newline.join(lines).encode() + edges + body[0] + body[1]


VERTICES = np.array([[0.1 + 1e5, 0, 0], [2 + 1e5, 0, 0], [2 + 1e5, 3, 0], [1e5, 3, 0], [1e5, 1, 0], [1e5, 0, 4]])
FACES = [(0, 1, 5), (0, 1, 2, 3, 4), (1, 2, 5), (5, 2, 3), (0, 1, 2, 3)]


def read(tmp_path, content):
    path = tmp_path / "some thing.ply"
    path.write_bytes(content)
    return read_ply(path)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(
    "layout",
    [
        {},
        {"newline": "\r\n"},
        {"faces_first": True},
        {"count": "i4", "index": "u2"},
        {"count": "u2", "index": "i1", "more": False},
    ],
    ids=["plain", "crlf", "faces first", "wide counts", "narrow indices"],
)
def test_every_format_and_layout_gives_the_same_mesh_in_double_precision(tmp_path, form, layout):
    mesh = read(tmp_path, ply(form, VERTICES, FACES, **layout))
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    assert mesh.labels[0].name == "some thing" and not mesh.labels[0].material and not mesh.notes
    assert len(mesh.triangles) == 3 + 3 + 2
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    flat = (mesh.vertices[mesh.triangles][:, :, 2] == 0.0).all(axis=1)
    pentagon = 2 * 3 - 0.5 * 0.1 * 1.0
    quad = 0.5 * (1.9 + 2.0) * 3.0
    assert area[flat].sum() == pytest.approx(pentagon + quad, rel=1e-9)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_large_meshes_as_another_program_writes_and_reads_them(tmp_path, encoding):
    ball = trimesh.creation.icosphere(subdivisions=5)
    (tmp_path / "ball.ply").write_bytes(ball.export(file_type="ply", encoding=encoding))
    mesh = read_ply(tmp_path / "ball.ply")
    np.testing.assert_allclose(mesh.vertices, ball.vertices, atol=2e-7)
    np.testing.assert_array_equal(mesh.triangles, ball.faces)


def test_many_faces_of_changing_numbers_of_corners(tmp_path):
    """Runs of equal length end anywhere; each face keeps its corners."""
    rng = np.random.default_rng(3)
    count = np.repeat(rng.integers(3, 5, 400), rng.integers(1, 90, 400))
    vertices = np.column_stack([rng.random((500, 2)), np.zeros(500)])
    faces = [tuple(rng.choice(500, n, replace=False)) for n in count]
    content = ply("binary_little_endian", vertices, faces, more=False)
    triangles = read(tmp_path, content).triangles
    assert len(triangles) == (count - 2).sum()
    first = np.cumsum(count - 2) - (count - 2)
    three = np.flatnonzero(count == 3)
    np.testing.assert_array_equal(triangles[first[three]], [faces[k] for k in three])
    four = np.flatnonzero(count == 4)
    assert all(set(triangles[first[k] : first[k] + 2].ravel()) == set(faces[k]) for k in four)


GOOD = ply("ascii", VERTICES, FACES, more=False)


@pytest.mark.parametrize(
    ("old", "new", "place", "found"),
    [
        (b"3 0 1 5", b"3 0 1 6", "face 0", "vertex 6 of 6"),
        (b"3 1 2 5", b"3 1 -2 5", "face 2", "vertex -2 of 6"),
        (b"3 1 2 5", b"2 1 2 3 0 1 5", "face 2", "vertices 1.0, 2.0"),
        (b"3 1 2 5", b"3 1 2.5 5", "face 2", "vertices 1.0, 2.5, 5.0"),
        (b"5 0 1 2 3 4", b"nan 0 1 2 3 4", "face 1", "a list of nan"),
        (b"5 0 1 2 3 4", b"5 0 1 2 3 four", "data", "'four'"),
        (b"property double x", b"property double u", "header", "vertices with nx, u, y, quality, z"),
        (b"property double x", b"property quadruple x", "line 9", "'property quadruple x'"),
        (b"element face 5", b"element face 6", "face 5", "the data end there"),
        (b"element face", b"element surface", "header", "elements edge, vertex, surface"),
        (b"format ascii", b"format EBCDIC", "line 2", "'format EBCDIC 1.0'"),
        (b"property ushort quality", b"property ushort x", "header", "properties of 'vertex' of one name"),
    ],
)
def test_faults_name_the_place(tmp_path, old, new, place, found):
    assert GOOD.count(old) == 1
    with pytest.raises(SceneError) as caught:
        read(tmp_path, GOOD.replace(old, new))
    (fault,) = caught.value.faults
    assert (fault.entry, fault.found) == (place, found)
    assert fault.file.endswith("some thing.ply") and fault.expected


@given(data=st.data(), form=st.sampled_from(sorted(FORMATS)))
@settings(max_examples=150, deadline=None)
def test_damaged_files_give_a_mesh_or_a_fault(tmp_path_factory, data, form):
    content = bytearray(ply(form, VERTICES, FACES))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.integers(0, 2 * len(content)))]
    path = tmp_path_factory.getbasetemp() / "damaged.ply"
    path.write_bytes(content)
    try:
        mesh = read_ply(path)
    except SceneError as error:
        assert error.faults[0].file == str(path)
    else:
        assert mesh.triangles.shape == (len(mesh.part), 3)
