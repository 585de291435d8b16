"""glTF 2.0, text (.gltf) and binary (.glb): nodes, names, indexed and plain triangles, strips and fans.

Khronos Group, glTF 2.0 Specification (2021): §3.5 scenes and transforms, §3.6 accessors, §3.7 meshes, §4 GLB.
"""

import base64
import binascii
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import PartLabel, RawMesh, Texture
from hradiosity.model.scene import Note

_COMPONENT: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTH: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_HARMLESS: Final = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_mesh_quantization", "KHR_xmp")
_DEEPEST: Final = 200


class _Damaged(Exception):
    """Something in the file contradicts the specification."""


_DAMAGE: Final = (
    _Damaged,
    LookupError,
    TypeError,
    ValueError,
    ArithmeticError,
    AttributeError,
    RecursionError,
    struct.error,
)
"""What reading raises when JSON entries have other types or values than the specification allows."""


@dataclass
class _Document:
    """The JSON part, the buffers, and what has been collected so far."""

    path: Path
    root: dict[str, Any]
    binary: bytes
    buffers: dict[int, bytes] = field(default_factory=dict)
    vertices: list[NDArray[np.float64]] = field(default_factory=list)
    triangles: list[NDArray[np.int64]] = field(default_factory=list)
    parts: list[int] = field(default_factory=list)
    labels: dict[PartLabel, int] = field(default_factory=dict)
    left_out: int = 0

    def item(self, kind: str, index: Any) -> dict[str, Any]:
        """``root[kind][index]``, checked."""
        entries = self.root.get(kind, [])
        if not isinstance(index, int) or not isinstance(entries, list) or not 0 <= index < len(entries):
            raise _Damaged(f"{kind}[{index}] does not exist")
        entry = entries[index]
        if not isinstance(entry, dict):
            raise _Damaged(f"{kind}[{index}] is not an object")
        return entry


def read_gltf(path: Path) -> RawMesh:
    """Read the default scene (all root nodes if none is named); objects are named after nodes, else meshes.

    Positions are stored in single precision by the format; transforms are applied in double precision. Mirrored
    nodes have their winding turned. Lines and points are left out with a note.

    Raises
    ------
    SceneError
        When the file is damaged or needs an extension, such as compressed geometry, that isn't read.
    """
    try:
        document = _open(path)
        required = [name for name in document.root.get("extensionsRequired", []) if not str(name).startswith(_HARMLESS)]
        if required:
            raise SceneError(
                [Fault(str(path), "extensionsRequired", ", ".join(map(str, required)), "an export without compression")]
            )
        for node in _root_nodes(document):
            _walk(document, node, np.eye(4), 0)
    except _DAMAGE as error:
        raise SceneError([Fault(str(path), "", f"damaged glTF ({_cause(error)})", "export it again")]) from error
    return _assemble(document)


def _cause(error: Exception) -> str:
    """What is wrong with the file, in words that need no knowledge of the program."""
    if isinstance(error, _Damaged):
        return str(error)
    if isinstance(error, json.JSONDecodeError):
        return f"the JSON breaks off or is wrong at line {error.lineno}, column {error.colno}"
    if isinstance(error, UnicodeDecodeError):
        return f"the JSON is not UTF-8 text at byte {error.start}"
    if isinstance(error, KeyError):
        return f"an entry {error.args[0]!r} is missing or its value is unknown"
    if isinstance(error, struct.error):
        return "it ends early"
    return "an entry has a type or value that glTF does not allow"


def _open(path: Path) -> _Document:
    data = path.read_bytes()
    binary = b""
    if data[:4] == b"glTF":
        _, version, length = struct.unpack_from("<4sII", data)
        if version != 2:
            raise _Damaged(f"version {version}, only 2 is read")
        if length > len(data):
            raise _Damaged(f"{len(data)} of {length} bytes are there")
        size, kind = struct.unpack_from("<I4s", data, 12)
        if kind != b"JSON":
            raise _Damaged("the first chunk isn't JSON")
        text, rest = data[20 : 20 + size], 20 + size
        if rest + 8 <= len(data):
            size, kind = struct.unpack_from("<I4s", data, rest)
            binary = data[rest + 8 : rest + 8 + size] if kind == b"BIN\0" else b""
    else:
        text = data
    root = json.loads(text.decode("utf-8-sig"))
    if not isinstance(root, dict) or "asset" not in root:
        raise _Damaged("no 'asset' entry")
    return _Document(path, root, binary)


def _root_nodes(document: _Document) -> list[Any]:
    if document.root.get("scenes"):
        return list(document.item("scenes", document.root.get("scene", 0)).get("nodes", []))
    children = {child for node in document.root.get("nodes", []) for child in node.get("children", [])}
    return [index for index in range(len(document.root.get("nodes", []))) if index not in children]


def _walk(document: _Document, index: Any, parent: NDArray[np.float64], depth: int) -> None:
    """Collect the triangles of a node and of those below it."""
    if depth > _DEEPEST:
        raise _Damaged(f"nodes are nested more than {_DEEPEST} deep, or in a circle")
    node = document.item("nodes", index)
    world = parent @ _transform(node)
    if "mesh" in node:
        mesh = document.item("meshes", node["mesh"])
        name = str(node.get("name") or mesh.get("name") or document.path.stem)
        for primitive in mesh["primitives"]:
            _collect(document, primitive, name, world)
    for child in node.get("children", []):
        _walk(document, child, world, depth + 1)


def _transform(node: dict[str, Any]) -> NDArray[np.float64]:
    """(4, 4) parent from node; §3.5.3: a column-major matrix, or translation · rotation · scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = (float(value) for value in node.get("rotation", (0.0, 0.0, 0.0, 1.0)))
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64).reshape(3)
    matrix[:3, 3] = np.array(node.get("translation", (0.0, 0.0, 0.0)), dtype=np.float64).reshape(3)
    return matrix


def _collect(document: _Document, primitive: dict[str, Any], name: str, world: NDArray[np.float64]) -> None:
    mode = primitive.get("mode", 4)
    if mode not in (4, 5, 6):
        document.left_out += 1
        return
    points = _accessor(document, primitive["attributes"]["POSITION"])
    if points.ndim != 2 or points.shape[1] != 3:
        raise _Damaged("POSITION is not a list of three coordinates")
    if "indices" in primitive:
        indices = _accessor(document, primitive["indices"]).astype(np.int64).ravel()
    else:
        indices = np.arange(len(points))
    if len(indices) and indices.max() >= len(points):
        raise _Damaged(f"a face of {name!r} uses vertex {indices.max()} of {len(points)}")
    triangles = _triangles(indices, mode)
    if np.linalg.det(world[:3, :3]) < 0.0:
        triangles = triangles[:, ::-1]
    material: dict[str, Any] = {}
    if "material" in primitive:
        material = document.item("materials", primitive["material"])
    label = PartLabel(name, str(material.get("name", "")), _texture(document, material))
    document.triangles.append(triangles + sum(len(block) for block in document.vertices))
    document.vertices.append(points.astype(np.float64) @ world[:3, :3].T + world[:3, 3])
    document.parts.append(document.labels.setdefault(label, len(document.labels)))


def _texture(document: _Document, material: dict[str, Any]) -> Texture | None:
    """The picture of a material's base colour; one that the file describes wrongly has no source (§3.8, §3.9.2)."""
    surface = material.get("pbrMetallicRoughness", {})
    if "baseColorTexture" not in surface:
        return None
    red, green, blue = (float(value) for value in surface.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))[:3])
    name = "without a name"
    source: Path | bytes | None = None
    try:
        texture = document.item("textures", surface["baseColorTexture"]["index"])
        webp = texture.get("extensions", {}).get("EXT_texture_webp", {})
        number = texture.get("source", webp.get("source"))
        image = document.item("images", number)
        name = str(image.get("name") or f"image {number}")
        if "bufferView" in image:
            source = _view_bytes(document, image["bufferView"])
        elif str(image["uri"]).startswith("data:"):
            source = base64.b64decode(str(image["uri"]).partition(",")[2], validate=True)
        else:
            name = unquote(str(image["uri"]))
            source = document.path.parent / name
    except _DAMAGE:
        source = None
    return Texture(name, source, (red, green, blue))


def _view_bytes(document: _Document, index: Any) -> bytes:
    view = document.item("bufferViews", index)
    start = int(view.get("byteOffset", 0))
    return _buffer(document, view["buffer"])[start : start + int(view["byteLength"])]


def _triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """(m, 3) triangles of a list (4), strip (5) or fan (6); §3.7.2.1."""
    if mode == 4:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    here = np.arange(max(len(indices) - 2, 0))
    if mode == 5:
        odd = here % 2
        return indices[np.stack([here, here + 1 + odd, here + 2 - odd], axis=1)]
    return indices[np.stack([here + 1, here + 2, np.zeros_like(here)], axis=1)]


def _accessor(document: _Document, index: Any) -> NDArray[Any]:
    """(count, width) values; normalised integers become fractions (§3.6.2)."""
    accessor = document.item("accessors", index)
    if "sparse" in accessor:
        raise _Damaged("sparse accessors are not read")
    dtype = np.dtype(_COMPONENT[accessor["componentType"]])
    width, count = _WIDTH[accessor["type"]], int(accessor["count"])
    view = document.item("bufferViews", accessor["bufferView"])
    data = _buffer(document, view["buffer"])
    start = int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
    stride = int(view.get("byteStride", 0)) or width * dtype.itemsize
    end = start + stride * (count - 1) + width * dtype.itemsize
    if count < 0 or start < 0 or stride < width * dtype.itemsize or (count and end > len(data)):
        raise _Damaged(f"accessor {index} reaches to byte {end} of {len(data)}")
    if count == 0:
        return np.empty((0, width), dtype=dtype)
    values: NDArray[Any] = np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))
    if accessor.get("normalized") and dtype.kind in "iu":
        return np.maximum(values.astype(np.float64) / np.iinfo(dtype).max, -1.0)
    return values


def _buffer(document: _Document, index: Any) -> bytes:
    """Bytes of a buffer: the binary chunk, a data URI, or a file beside this one."""
    if index not in document.buffers:
        uri = document.item("buffers", index).get("uri")
        if uri is None:
            document.buffers[index] = document.binary
        elif str(uri).startswith("data:"):
            try:
                document.buffers[index] = base64.b64decode(str(uri).partition(",")[2], validate=True)
            except binascii.Error as error:
                raise _Damaged(f"buffer {index} isn't base64") from error
        else:
            path = document.path.parent / unquote(str(uri))
            if not path.is_file():
                raise _Damaged(f"buffer file {uri!r} is missing")
            document.buffers[index] = path.read_bytes()
    return document.buffers[index]


def _assemble(document: _Document) -> RawMesh:
    notes: tuple[Note, ...] = ()
    if document.left_out:
        message = f"{document.left_out} groups of lines or points left out: only faces are read"
        notes = (Note("info", str(document.path), message),)
    sizes = [len(block) for block in document.triangles]
    return RawMesh(
        np.concatenate([np.empty((0, 3)), *document.vertices]),
        np.concatenate([np.empty((0, 3), dtype=np.int64), *document.triangles]),
        np.repeat(np.array(document.parts, dtype=np.int64), sizes),
        tuple(document.labels),
        notes,
    )
