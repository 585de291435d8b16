"""Tells files that are not what their suffix says, or that end early, before a reader stumbles over them."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

from hradiosity.errors import Fault, SceneError

_SIGNATURES: Final = (
    (b"glTF", "a binary glTF file"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"%PDF", "a PDF file"),
    (b"BLENDER", "a Blender file"),
    (b"Kaydara FBX", "an FBX file"),
    (b"version https://git-lfs", "a pointer of Git LFS in place of the file (`git lfs pull` fetches it)"),
)
_STL_HEADER, _STL_FACE = 84, 50
"""Bytes of a binary STL file before its faces, and of each face."""
_MOST_DIGITS: Final = 18
"""Of a count: more digits than any file has bytes."""
_PLY_SIZES: Final = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}


def check_content(path: Path) -> None:
    """Look at the file with the eyes of its format.

    Raises
    ------
    SceneError
        When the content is of another kind, or less than the file says it holds; names both.
    """
    wrong = _CHECKS[path.suffix.lower()](path.read_bytes())
    if wrong is not None:
        raise SceneError([Fault(str(path), "", *wrong)])


def _described(data: bytes) -> str:
    """What some bytes seem to be."""
    known = next((name for start, name in _SIGNATURES if data.startswith(start)), None)
    if known is not None:
        return f"the content is {known}"
    begin = data[:400].lstrip(b"\xef\xbb\xbf \t\r\n")
    if re.match(rb"<(!doctype\s+html|html)", begin, re.IGNORECASE):
        return "the content is an HTML page (a download that went wrong?)"
    if begin.startswith(b"<"):
        return "the content is XML"
    first = begin.split(b"\n", 1)[0].strip()[:40]
    if first and re.fullmatch(rb"[\t\x20-\x7e]+", first):
        return f"the content begins with {first.decode()!r}"
    return f"the content begins with the bytes {data[:8].hex(' ')}"


def _check_obj(data: bytes) -> tuple[str, str] | None:
    if b"\0" not in data and re.search(rb"^\s*v\s", data, re.MULTILINE):
        return None
    return _described(data), "an OBJ file: text with lines that begin with v and f"


def _check_gltf(data: bytes) -> tuple[str, str] | None:
    if data[:4] == b"glTF" or data[:400].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        return None
    return _described(data), "binary glTF, which begins with 'glTF', or JSON, which begins with '{'"


def _check_stl(data: bytes) -> tuple[str, str] | None:
    n_faces = int.from_bytes(data[80:_STL_HEADER], "little")
    whole = _STL_HEADER + _STL_FACE * n_faces
    if len(data) == whole:
        return None
    if re.match(rb"\s*solid\b", data, re.IGNORECASE) and re.search(rb"^\s*facet\b", data, re.IGNORECASE | re.MULTILINE):
        if re.search(rb"^\s*endsolid\b", data, re.IGNORECASE | re.MULTILINE):
            return None
        return "an STL file without its last line, 'endsolid': the end is missing", "the whole file"
    # A header is free text, so that nothing but a plausible number of faces tells a cut file from another one.
    if _STL_HEADER < len(data) < whole < 1000 * len(data):
        return f"{len(data)} of the {whole} bytes of {n_faces} faces are there", "the whole file"
    return _described(data), "an STL file: 'solid' and faces as text, or 84 bytes and 50 for each face"


def _check_ply(data: bytes) -> tuple[str, str] | None:
    if not re.match(rb"ply\s", data, re.IGNORECASE):
        return _described(data), "a PLY file, which begins with 'ply'"
    end = re.search(rb"^end_header\r?\n?", data, re.MULTILINE)
    if end is None:
        return "a PLY file whose header does not end", "the whole file, with a line 'end_header'"
    header, body = data[: end.start()].decode("latin-1").splitlines(), data[end.end() :]
    lines = [line.split() for line in header]
    for words in lines:
        if words[:1] == ["element"] and (len(words) != 3 or not re.fullmatch("[0-9]+", words[2])):
            return f"the header has a line {' '.join(words)[:60]!r}", "element, a name and a count"
    numbers, size, most = _ply_least(lines)
    if most > len(data):
        return f"{len(data)} bytes can't hold {most} elements", "the whole file, with the right counts in its header"
    is_text = any(line.split()[:2] == ["format", "ascii"] for line in header)
    there, least, unit = (len(body.split()), numbers, "numbers") if is_text else (len(body), size, "bytes of data")
    if there < least:
        return f"{there} of at least {least} {unit} are there", "the whole file"
    return None


def _ply_least(header: list[list[str]]) -> tuple[int, int, int]:
    """Numbers of all elements, and the bytes that they take, at least: a face has three vertices; the largest count."""
    numbers = size = count = most = 0
    for words in header:
        if words[:1] == ["element"]:
            count = int(words[2][:_MOST_DIGITS])
            most = max(most, count)
        elif words[:2] == ["property", "list"] and len(words) == 5:
            corners = 3 if words[4] in ("vertex_index", "vertex_indices") else 0
            numbers += count * (1 + corners)
            size += count * (_PLY_SIZES.get(words[2], 1) + corners * _PLY_SIZES.get(words[3], 1))
        elif words[:1] == ["property"] and len(words) == 3:
            numbers += count
            size += count * _PLY_SIZES.get(words[1], 1)
    return numbers, size, most


_CHECKS: Final[dict[str, Callable[[bytes], tuple[str, str] | None]]] = {
    ".obj": _check_obj,
    ".gltf": _check_gltf,
    ".glb": _check_gltf,
    ".stl": _check_stl,
    ".ply": _check_ply,
}
