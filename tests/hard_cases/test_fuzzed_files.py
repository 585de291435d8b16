"""Whatever was done to a file, reading it gives a scene or faults of that file: no traceback, no hang, no dead program.

Each file is damaged at random places by `mutated_files`, with the same random numbers in each run. STL and pictures go
through native code that damage may crash; so everything is read in a process of its own, as the program does, and a
crash is counted. It must not be frequent, and reading must go on after it.
"""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutated_files import ReadingProcess, mutated
from PIL import Image

from hradiosity.io.meshes import read_mesh

SCENES = Path(__file__).resolve().parents[2] / "scenes"
QUICK, LONG = 40, 3000
CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [0, 0, 1], [2, 0, 1]])
FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 1, 5], [0, 5, 4]])


def obj():
    lines = ["mtllib paints.mtl", "o sheet one", *(f"v {x} {y} {z}" for x, y, z in CORNERS)]
    return "\n".join(
        [*lines, "usemtl wood", "f 1/1/1 2//1 3 4", "g wall", "usemtl paint", "f -6 -5 6 \\", "5", "l 1 2"]
    )


def mtl():
    return "newmtl wood\nKd 0.8 0.8 0.5\nmap_Kd -s 1 1 1 wood.png\nnewmtl paint\nKd 0.5\nmap_Kd wood.png\n"


def gltf(binary):
    """Two nodes, one of them turned and scaled, with a texture inside the file."""
    import base64
    import json
    import struct

    blocks = [CORNERS.astype("<f4").tobytes(), FACES.astype("<u2").tobytes(), picture("PNG")]
    blocks = [block + bytes(-len(block) % 4) for block in blocks]
    starts = [sum(map(len, blocks[:k])) for k in range(3)]
    data = b"".join(blocks)
    views = [{"buffer": 0, "byteOffset": a, "byteLength": len(b)} for a, b in zip(starts, blocks, strict=True)]
    root = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "seat", "mesh": 0, "children": [1]},
            {"mesh": 0, "scale": [1, 2, 1], "translation": [0, 0, 2]},
        ],
        "materials": [{"name": "cloth", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 2, "mimeType": "image/png"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(CORNERS)},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": FACES.size},
        ],
        "bufferViews": views,
    }
    if not binary:
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        return json.dumps({**root, "buffers": [{"byteLength": len(data), "uri": uri}]}).encode()
    text = json.dumps({**root, "buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def ply(binary):
    header = f"ply\nformat {'binary_little_endian' if binary else 'ascii'} 1.0\nelement vertex {len(CORNERS)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n"
    if not binary:
        lines = [" ".join(map(str, row)) for row in CORNERS.tolist()]
        return header + "\n".join([*lines, *("3 " + " ".join(map(str, row)) for row in FACES.tolist())]) + "\n"
    rows = np.zeros(len(FACES), [("n", "u1"), ("corner", "<i4", 3)])
    rows["n"], rows["corner"] = 3, FACES
    return header.encode() + CORNERS.astype("<f4").tobytes() + rows.tobytes()


def stl(binary):
    triangles = CORNERS[FACES]
    if binary:
        rows = np.zeros(len(FACES), [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
        rows["corner"] = triangles
        return b"a header".ljust(80) + len(FACES).to_bytes(4, "little") + rows.tobytes()
    facets = [
        "facet normal 0 0 1\nouter loop\n" + "".join("vertex {} {} {}\n".format(*c) for c in t) + "endloop\nendfacet\n"
        for t in triangles.tolist()
    ]
    return "solid x\n" + "".join(facets) + "endsolid x\n"


def picture(form):
    pixels = np.arange(6 * 5 * 3, dtype=np.uint8).reshape(6, 5, 3) * 2
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, form)
    return stream.getvalue()


def shipped(name):
    return (SCENES / name / "scene.toml").read_bytes()


CSV = "wavelength;a\n# remark\n380;0.1\n400;0.2\nline;436;1.5\n500;0.5\n780;0.7\n"
FILES = {
    "plain.obj": obj(),
    "paints.mtl": mtl(),
    "text.gltf": gltf(False),
    "binary.glb": gltf(True),
    "ascii.ply": ply(False),
    "binary.ply": ply(True),
    "ascii.stl": stl(False),
    "binary.stl": stl(True),
    "columns.csv": CSV,
    "two_rooms.toml": shipped("two_rooms"),
    "mesh_room.toml": shipped("mesh_room"),
    "picture.png": picture("PNG"),
    "picture.jpg": picture("JPEG"),
    "picture.tif": picture("TIFF"),
    "picture.webp": picture("WEBP"),
}
FILES = {name: content.encode() if isinstance(content, str) else content for name, content in FILES.items()}
NATIVE = (".stl", ".png", ".jpg", ".tif", ".webp")
"""Formats that native code reads."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the files that others refer to."""
    place = tmp_path_factory.mktemp("damaged")
    (place / "paints.obj").write_bytes(FILES["plain.obj"])
    (place / "wood.png").write_bytes(FILES["picture.png"])
    return place


@pytest.fixture(scope="module")
def reader():
    process = ReadingProcess()
    yield process
    process.close()


@pytest.mark.parametrize("name", [name for name in FILES if name != "mesh_room.toml"])
def test_the_files_are_sound_before_they_are_damaged(folder, reader, name):
    path = folder / name
    path.write_bytes(FILES[name])
    assert reader.read(path) == []


def damage_and_read(folder, reader, name, examples):
    """Read so many damaged files; returns how many were refused, read and fatal to the reader."""
    path = folder / f"damaged_{name}" if not name.endswith(".mtl") else folder / name
    before, found = reader.ends, {"refused": 0, "read": 0, "fatal": 0}

    @settings(max_examples=examples, deadline=None, derandomize=True, database=None, suppress_health_check=HealthCheck)
    @given(content=mutated(FILES[name]))
    def one(content):
        path.write_bytes(content)
        faults = reader.read(path)
        found["fatal" if faults is None else "refused" if faults else "read"] += 1
        for fault in faults or ():
            assert path.name in fault or ".mtl" in name, fault
            assert "Traceback" not in fault and len(fault) < 2000

    one()
    assert (reader.ends > before) <= name.endswith(NATIVE)
    assert found["fatal"] <= 0.05 * sum(found.values()) + 4
    return found


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_give_a_scene_or_faults(folder, reader, name):
    found = damage_and_read(folder, reader, name, QUICK)
    assert found["refused"] > 0 or name.endswith((".mtl", ".tif"))


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_thousands_of_damaged_files_give_a_scene_or_faults(folder, reader, name, record_property):
    found = damage_and_read(folder, reader, name, LONG)
    record_property("found", found)
    print(name, found)


@settings(max_examples=5, deadline=None, derandomize=True, database=None, suppress_health_check=HealthCheck)
@given(data=st.data(), name=st.sampled_from(["binary.ply", "binary.stl"]))
def test_the_program_itself_survives_what_crashes_a_reader(folder, data, name):
    """By the same call as a scene file's: a crash of native code is a fault of the file."""
    from hradiosity.errors import SceneError

    path = folder / name
    path.write_bytes(data.draw(mutated(FILES[name])))
    try:
        assert read_mesh(path, "m", "z").parts
    except SceneError as error:
        assert str(error).startswith(str(path))
        assert "Traceback" not in str(error)
