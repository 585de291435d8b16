"""Mesh files: names, units, and damaged files."""

import base64
import json
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hradiosity.errors import SceneError
from hradiosity.io.mesh.gltf import read_gltf
from hradiosity.io.mesh.obj import read_obj
from hradiosity.io.mesh.worker import load
from hradiosity.io.meshes import SUFFIXES, read_mesh
from hradiosity.model.meshing import merge_triangles

QUAD = np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])

ROOM_OBJ = """# two objects, three materials, names with spaces
mtllib room paints.mtl
o north wall
v 100000.001 0 0
v 100004 0 0
v 100004 0 3
v 100000.001 0 3
usemtl white paint
f 1/1/1 2//1 \\
  3 4
o desk top
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
usemtl oak veneer
f -4 -3 -2
usemtl white paint
f 5 7 8
l 1 2
"""
ROOM_MTL = "newmtl white paint\nKd 0.8 0.8 0.8\nnewmtl oak veneer\nmap_Kd grain of oak.png\n"


def write(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def gltf_document(nodes, positions=QUAD, indices=TWO, **extra):
    """glTF of one mesh with one named material, its buffer as bytes, and the JSON without the buffer's place."""
    points, faces = np.asarray(positions, dtype="<f4"), np.asarray(indices, dtype="<u2").ravel()
    data = points.tobytes() + faces.tobytes()
    root = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "materials": [{"name": "blue fabric", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points)},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": len(faces)},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": faces.nbytes},
        ],
        **extra,
    }
    return root, data


def as_gltf(root, data):
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps({**root, "buffers": [{"byteLength": len(data), "uri": uri}]})


def as_glb(root, data):
    text = json.dumps({**root, "buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def as_stl(vertices, triangles):
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    record["corners"] = vertices[triangles]
    return b"made by a test".ljust(80) + struct.pack("<I", len(triangles)) + record.tobytes()


def as_ply(vertices, triangles):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(str, vertex)) for vertex in vertices.tolist()]
    lines += ["3 " + " ".join(map(str, triangle)) for triangle in triangles.tolist()]
    return "\n".join(lines) + "\n"


def area(part):
    a, b, c = part.vertices[part.triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_obj_keeps_names_with_spaces_and_double_precision(tmp_path):
    write(tmp_path, "room paints.mtl", ROOM_MTL)
    parts, notes = read_mesh(write(tmp_path, "my room.obj", ROOM_OBJ), "mm", "z")
    assert [(part.name, part.material, part.texture and part.texture.name, len(part.triangles)) for part in parts] == [
        ("north wall", "white paint", None, 2),
        ("desk top", "oak veneer", "grain of oak.png", 1),
        ("desk top", "white paint", None, 1),
    ]
    assert parts[0].vertices[:, 0].min() == 100000.001 * 1e-3
    np.testing.assert_allclose(area(parts[0]), 3.999 * 3 * 1e-6, rtol=1e-9)
    assert parts[0].triangles.dtype == np.int32
    assert [(note.kind, note.message) for note in notes] == [("info", "1 lines left out: only faces are read")]


def test_y_up_becomes_z_up(tmp_path):
    """A y-up floor (normal +y) is a z-up floor (normal +z), at the height it had."""
    floor = "v 0 1 0\nv 0 1 3\nv 2 1 3\nv 2 1 0\nf 1 2 3 4\n"
    (part,) = read_mesh(write(tmp_path, "floor.obj", floor), "ft", "y").parts
    assert part.name == "floor" and part.material == ""
    np.testing.assert_allclose(part.vertices[:, 2], 0.3048)
    a, b, c = part.vertices[part.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_gives_the_same_rectangle(tmp_path, suffix):
    root, data = gltf_document([{"name": "seat", "mesh": 0}])
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in QUAD)
    content = {
        ".obj": corners + "f 1 2 3 4\n",
        ".gltf": as_gltf(root, data),
        ".glb": as_glb(root, data),
        ".ply": as_ply(QUAD, TWO),
        ".stl": as_stl(QUAD, TWO),
    }[suffix]
    (part,) = read_mesh(write(tmp_path, "plate" + suffix, content), "cm", "z").parts
    pieces = merge_triangles(part.vertices, part.triangles)
    assert len(pieces.origin) == 1
    np.testing.assert_allclose(np.cross(pieces.edge_u, pieces.edge_v), [[0, 0, 6e-4]], rtol=1e-6)
    named = suffix in (".gltf", ".glb")
    assert (part.name, part.material, part.texture is not None) == (
        ("seat", "blue fabric", True) if named else ("plate", "", False)
    )


def test_gltf_nodes_move_turn_and_mirror(tmp_path):
    half = np.sqrt(0.5)
    nodes = [
        {"name": "group", "children": [1, 2], "translation": [10, 0, 0]},
        {"name": "turned", "mesh": 0, "rotation": [0, 0, half, half], "scale": [1, 2, 1]},
        {"name": "mirrored", "mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
    ]
    mesh = read_gltf(write(tmp_path, "a.gltf", as_gltf(*gltf_document(nodes))))
    assert [label.name for label in mesh.labels] == ["turned", "mirrored"]
    turned, mirrored = (mesh.vertices[mesh.triangles[mesh.part == k]] for k in (0, 1))
    np.testing.assert_allclose(turned[0], [[10, 0, 0], [10, 2, 0], [4, 2, 0]], atol=1e-12)
    np.testing.assert_allclose(sorted(mirrored[0].tolist()), [[8, 0, 5], [8, 3, 5], [10, 0, 5]])
    for corners in (turned, mirrored):
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (normal[:, 2] > 0).all()


@pytest.mark.parametrize(("mode", "indices"), [(5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])])
def test_gltf_strips_and_fans_keep_their_front(tmp_path, mode, indices):
    root, data = gltf_document([{"mesh": 0}], indices=indices)
    root["meshes"][0]["primitives"][0]["mode"] = mode
    root["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "mode": 1})
    mesh = read_gltf(write(tmp_path, "strip.gltf", as_gltf(root, data)))
    corners = mesh.vertices[mesh.triangles]
    normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(normal, [[0, 0, 3], [0, 0, 3]])
    assert mesh.labels[0].name == "strip" and "lines or points" in mesh.notes[0].message


@pytest.mark.parametrize("compression", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_compressed_gltf_is_refused_by_name(tmp_path, compression):
    root, data = gltf_document([{"mesh": 0}], extensionsRequired=["KHR_materials_unlit", compression])
    with pytest.raises(SceneError, match=f"{compression}; an export without compression"):
        read_gltf(write(tmp_path, "small.gltf", as_gltf(root, data)))


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gone.obj", None, "not found"),
        ("chair.blend", "x", "unknown mesh format '.blend'; one of .obj, .gltf"),
        ("empty.ply", "", "empty"),
        ("noise.obj", bytes(range(256)) * 4, "begins with the bytes 00 01 02 03 04 05 06 07; an OBJ file: text with"),
        ("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "no faces"),
        ("noise.glb", b"glTF" + bytes(range(200)), "damaged glTF"),
        ("noise.stl", bytes(range(256)) * 4, "noise.stl"),
        ("letters.obj", "v 0 0 0\nv 1 zero 0\nf 1 2 9\n", "line 2: .*\n.*line 3: "),
        ("half.ply", as_ply(QUAD, TWO)[:150], "half.ply"),
    ],
)
def test_unreadable_files_are_faults_of_the_file(tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        write(tmp_path, name, content)
    with pytest.raises(SceneError, match=message):
        read_mesh(path, "m", "z")


HTML = b"\n<!DOCTYPE html>\n<html><head><title>404</title></head></html>\n"
ASCII_STL = (
    "solid x\n"
    + "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in QUAD[triangle])
        + "endloop\nendfacet\n"
        for triangle in TWO
    )
    + "endsolid x\n"
).encode()
BINARY_PLY = (
    as_ply(QUAD, TWO).partition("end_header\n")[0].replace("ascii", "binary_little_endian").encode()
    + b"end_header\n"
    + QUAD.astype("<f4").tobytes()
    + b"".join(struct.pack("<B3i", 3, *triangle) for triangle in TWO.tolist())
)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    ("content", "found"),
    [
        (HTML, "the content is an HTML page"),
        (b"\x89PNG\r\n\x1a\n" + bytes(900), "the content is a PNG picture"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "git lfs pull"),
        (b"hello world\n", "the content begins with 'hello world'"),
        (np.random.default_rng(1).bytes(3000), "the content begins with the bytes"),
    ],
    ids=["html", "png", "lfs", "text", "garbage"],
)
def test_content_of_another_kind_is_named(tmp_path, suffix, content, found):
    with pytest.raises(SceneError) as caught:
        load(write(tmp_path, "mesh" + suffix, content))
    (fault,) = caught.value.faults
    assert found in fault.found
    assert {".obj": "OBJ", ".ply": "'ply'", ".stl": "STL"}.get(suffix, "'glTF'") in fault.expected


@pytest.mark.parametrize("share", [0.99, 0.9, 0.7, 0.5, 0.2, 0.05])
@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        (".ply", as_ply(QUAD, TWO).encode().rstrip()),
        (".ply", BINARY_PLY),
        (".stl", as_stl(QUAD, TWO)),
        (".stl", ASCII_STL),
        (".glb", as_glb(*gltf_document([{"mesh": 0}]))),
        (".gltf", as_gltf(*gltf_document([{"mesh": 0}])).encode()),
    ],
    ids=["ascii.ply", "binary.ply", "binary.stl", "ascii.stl", "glb", "gltf"],
)
def test_no_cut_file_passes_for_a_whole_one(tmp_path, suffix, content, share):
    """Half a mesh is a fault that says so, in our words, and never fewer faces or a crash."""
    assert len(load(write(tmp_path, "whole" + suffix, content)).triangles) == 2
    length = min(int(share * len(content)), len(content) - 1)
    if suffix == ".stl" and content is ASCII_STL:
        length = min(length, content.index(b"endsolid"))
    with pytest.raises(SceneError) as caught:
        load(write(tmp_path, "cut" + suffix, content[:length]))
    text = str(caught.value)
    assert any(word in text for word in ("are there", "breaks off", "does not end", "is missing", "begins with")), text
    assert "Error" not in text


def test_hanging_reader_is_given_up(tmp_path):
    path = write(tmp_path, "floor.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(SceneError, match=r"more than 0\.01 s"):
        read_mesh(path, "m", "z", timeout=0.01)


def test_wrong_arguments_are_the_callers():
    with pytest.raises(ValueError, match="unit must be"):
        read_mesh(Path("a.obj"), "yd", "z")


_ROOT, _DATA = gltf_document([{"name": "seat", "mesh": 0, "children": []}])
SAMPLES = {".obj": ROOM_OBJ.encode(), ".gltf": as_gltf(_ROOT, _DATA).encode(), ".glb": as_glb(_ROOT, _DATA)}


@given(data=st.data(), suffix=st.sampled_from(sorted(SAMPLES)))
@settings(max_examples=150, deadline=None)
def test_mutated_text_and_binary_give_a_mesh_or_a_fault(tmp_path_factory, data, suffix):
    """Our own readers raise nothing but SceneError, whatever is cut off or overwritten."""
    content = bytearray(SAMPLES[suffix])
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    content = content[: data.draw(st.integers(0, 2 * len(content)))]
    path = write(tmp_path_factory.getbasetemp(), "mutated" + suffix, bytes(content))
    try:
        mesh = (read_obj if suffix == ".obj" else read_gltf)(path)
    except SceneError as error:
        assert error.faults[0].file == str(path)
    else:
        assert mesh.triangles.shape == (len(mesh.part), 3)


@pytest.mark.slow
@pytest.mark.parametrize("content", [as_ply(QUAD, TWO).encode(), as_stl(QUAD, TWO)], ids=[".ply", ".stl"])
def test_mutated_files_for_assimp_end_neither_us_nor_the_machine(tmp_path, content, request):
    suffix = request.node.callspec.id
    rng = np.random.default_rng(5)
    for _ in range(25):
        changed = bytearray(content)
        for place in rng.integers(0, len(changed), 3):
            changed[place] = rng.choice([rng.integers(256), ord("9"), 255])
        changed = changed[: rng.integers(1, 2 * len(changed))]
        try:
            assert read_mesh(write(tmp_path, "mutated" + suffix, bytes(changed)), "m", "z").parts
        except SceneError as error:
            assert error.faults[0].file.endswith("mutated" + suffix)
            assert "Traceback" not in str(error) and "TypeError" not in str(error)


def test_absurd_count_in_a_header_is_a_fault(tmp_path):
    content = as_ply(QUAD, TWO).replace("element vertex 4", "element vertex 4000000000")
    with pytest.raises(SceneError, match=r"absurd\.ply"):
        read_mesh(write(tmp_path, "absurd.ply", content), "m", "z")


def test_crash_of_the_reader_is_a_fault(tmp_path, monkeypatch):
    """A worker that dies by a signal, as assimp has been seen to do on damaged files."""
    crash = [sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"]
    run = subprocess.run
    monkeypatch.setattr(subprocess, "run", lambda command, **options: run(crash, **options))
    with pytest.raises(SceneError, match=r"crashes the reader \(Segmentation fault\)"):
        read_mesh(write(tmp_path, "a.stl", as_stl(QUAD, TWO)), "m", "z")
