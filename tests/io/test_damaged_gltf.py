"""glTF files that are damaged, or hold what is not read: each is refused by a sentence that names the place."""

import json
import struct

import numpy as np
import pytest
from test_meshes import as_glb, as_gltf, gltf_document

from hradiosity.errors import SceneError
from hradiosity.io.mesh.gltf import read_gltf


def changed(change):
    """A sound glTF of a quad, with its JSON changed."""
    root, data = gltf_document([{"name": "seat", "mesh": 0}])
    root = json.loads(as_gltf(root, data))
    change(root)
    return json.dumps(root)


def nested(root):
    root["nodes"] = [{"mesh": 0, "children": [0]}]
    root["scenes"], root["scene"] = [{"nodes": [0]}], 0


CASES = {
    "no asset": (lambda r: r.pop("asset"), "no 'asset' entry"),
    "circle": (nested, "in a circle"),
    "sparse": (lambda r: r["accessors"][0].update(sparse={}), "sparse accessors are not read"),
    "short": (lambda r: r["accessors"][0].update(count=5000), "reaches to byte"),
    "vertex": (lambda r: r["accessors"][0].update(count=2), "a face of 'seat' uses vertex 3 of 2"),
    "flat points": (lambda r: r["accessors"][0].update(type="VEC2"), "three coordinates"),
    "base64": (lambda r: r["buffers"][0].update(uri="data:;base64,%%%"), "buffer 0 isn't base64"),
    "no file": (lambda r: r["buffers"][0].update(uri="gone%20away.bin"), "'gone%20away.bin' is missing"),
    "no node": (lambda r: r.update(scenes=[{"nodes": [7]}], scene=0), "nodes[7] does not exist"),
    "text for a node": (lambda r: r.update(nodes=["seat"], scenes=[{"nodes": [0]}], scene=0), "is not an object"),
    "no count": (lambda r: r["accessors"][0].pop("count"), "an entry 'count' is missing"),
    "words for a matrix": (lambda r: r["nodes"][0].update(matrix=["a"] * 16), "does not allow"),
}


@pytest.mark.parametrize(("change", "said"), CASES.values(), ids=CASES)
def test_what_is_wrong_is_named(tmp_path, change, said):
    path = tmp_path / "seat.gltf"
    path.write_text(changed(change))
    with pytest.raises(SceneError) as caught:
        read_gltf(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("place", "content", "said"),
    [
        (4, struct.pack("<I", 1), "version 1, only 2 is read"),
        (8, struct.pack("<I", 10**6), "of 1000000 bytes are there"),
        (16, b"BIN\0", "the first chunk isn't JSON"),
    ],
)
def test_headers_of_binary_files(tmp_path, place, content, said):
    whole = as_glb(*gltf_document([{"mesh": 0}]))
    path = tmp_path / "seat.glb"
    path.write_bytes(whole[:place] + content + whole[place + 4 :])
    with pytest.raises(SceneError, match=said):
        read_gltf(path)


def test_a_file_without_scenes_shows_its_root_nodes_once(tmp_path):
    def without_scenes(root):
        root.pop("scenes", None)
        root.pop("scene", None)
        root["nodes"] = [{"children": [1]}, {"mesh": 0, "translation": [1, 0, 0]}, {"mesh": 0}]

    path = tmp_path / "seats.gltf"
    path.write_text(changed(without_scenes))
    mesh = read_gltf(path)
    assert len(mesh.triangles) == 4
    lowest = mesh.vertices[mesh.triangles].reshape(2, -1, 3)[..., 0].min(axis=1)
    np.testing.assert_allclose(sorted(lowest), [0.0, 1.0])


def test_a_buffer_beside_the_file(tmp_path):
    root, data = gltf_document([{"mesh": 0}])
    text = json.loads(as_gltf(root, data))
    text["buffers"][0]["uri"] = "my%20points.bin"
    (tmp_path / "my points.bin").write_bytes(data)
    (tmp_path / "seat.gltf").write_text(json.dumps(text))
    assert len(read_gltf(tmp_path / "seat.gltf").triangles) == 2
