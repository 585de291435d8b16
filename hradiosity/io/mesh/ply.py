"""PLY files (Turk 1994), as text and binary in either order of bytes, in double precision."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import PartLabel, RawMesh, notes_on_faces, triangulate_faces

_TYPES: Final = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS: Final = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS: Final = ("vertex_indices", "vertex_index")
_FIRST_LOOK: Final = 64
"""Rows that are looked at in one go at first; four times as many whenever all had lists of the same lengths."""
_LONGEST_LIST: Final = 1 << 20
_LONGEST_WORD: Final = 60
"""Letters of a number as text."""


@dataclass(frozen=True)
class _Property:
    """One column of an element.

    name : str
    kind : as numpy names it; of a list that of its items
    count : the kind of a list's length; empty for a single number
    """

    name: str
    kind: str
    count: str = ""


@dataclass
class _Element:
    name: str
    rows: int
    properties: list[_Property]


class _Damaged(ValueError):
    """Place in the file, what is there, and what was expected."""


def read_ply(path: Path) -> RawMesh:
    """Read a PLY file: one part named after the file. Elements other than vertices and faces are left out.

    Raises
    ------
    SceneError
        Naming the line of the header, the vertex or the face that can't be understood.
    """
    data = path.read_bytes()
    try:
        elements, order, start = _header(data)
        body, elements = _numbers(data[start:], elements) if order == "ascii" else (data[start:], elements)
        vertices, faces = _read(body, elements, _ORDERS[order])
    except _Damaged as damage:
        place, found, expected = damage.args
        raise SceneError([Fault(str(path), place, found, expected)]) from damage
    cut = triangulate_faces(vertices, faces)
    label = PartLabel(path.stem, "")
    part = np.zeros(len(cut.triangles), np.int64)
    return RawMesh(vertices, cut.triangles, part, (label,), notes_on_faces(cut, str(path)))


def _header(data: bytes) -> tuple[list[_Element], str, int]:
    """Elements, format, and where the data begin."""
    end = re.search(rb"^end_header[ \t]*(\r\n|\n|\r|$)", data, re.MULTILINE)
    if end is None:
        raise _Damaged("header", "it does not end", "a line 'end_header'")
    order = ""
    elements: list[_Element] = []
    for number, line in enumerate(re.split(r"\r\n|\n|\r", data[: end.start()].decode("latin-1")), start=1):
        words = line.split()
        keyword = words[0] if words else "comment"
        if keyword == "format" and len(words) > 1 and words[1] in _ORDERS:
            order = words[1]
        elif keyword == "element" and len(words) == 3 and re.fullmatch(r"[0-9]{1,18}", words[2]):
            elements.append(_Element(words[1], int(words[2]), []))
        elif keyword == "property" and elements and (column := _property(words)) is not None:
            elements[-1].properties.append(column)
        elif keyword not in ("comment", "obj_info") and not (number == 1 and keyword.lower() == "ply"):
            raise _Damaged(f"line {number}", repr(line[:60]), "a line of a PLY header")
    if not order:
        raise _Damaged("header", "no format", f"a line 'format' with one of {', '.join(_ORDERS)}")
    return elements, order, end.end()


def _property(words: list[str]) -> _Property | None:
    """The column that a line of the header describes; None if it can't be understood."""
    if len(words) == 3 and words[1] in _TYPES:
        return _Property(words[2], _TYPES[words[1]])
    is_list = len(words) == 5 and words[1] == "list" and words[3] in _TYPES
    if is_list and _TYPES.get(words[2], "f")[0] != "f":
        return _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
    return None


def _numbers(body: bytes, elements: list[_Element]) -> tuple[bytes, list[_Element]]:
    """Text as the bytes of double-precision numbers, and the elements as they are then."""
    words = body.split()
    long = next((word for word in words if len(word) > _LONGEST_WORD), None)
    if long is not None:
        raise _Damaged("data", repr(long[:60].decode("latin-1")), "numbers")
    try:
        numbers = np.array(words, dtype=np.bytes_).astype(np.float64) if words else np.zeros(0)
    except ValueError:
        wrong = next(word for word in words if not _is_number(word))
        raise _Damaged("data", repr(wrong[:60].decode("latin-1")), "numbers") from None
    wide = [
        _Element(e.name, e.rows, [_Property(p.name, "f8", "f8" if p.count else "") for p in e.properties])
        for e in elements
    ]
    return numbers.astype("<f8").tobytes(), wide


def _is_number(word: bytes) -> bool:
    try:
        np.array([word], dtype=np.bytes_).astype(np.float64)
    except ValueError:
        return False
    return True


def _read(body: bytes, elements: list[_Element], order: str) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Vertices (n, 3), and the corners of the faces."""
    vertices: NDArray[np.float64] | None = None
    faces: list[list[int]] | None = None
    at = 0
    for element in elements:
        rows, at = _rows(body, at, element, order)
        if element.name == "vertex":
            columns = [column.name for column in element.properties if not column.count]
            if not {"x", "y", "z"} <= set(columns):
                raise _Damaged("header", f"vertices with {', '.join(columns) or 'nothing'}", "x, y and z")
            vertices = np.zeros((0, 3))
            if rows:
                vertices = np.concatenate([np.stack([r[a].astype(np.float64) for a in "xyz"], axis=1) for r in rows])
        elif element.name == "face":
            faces = _corners(rows, element)
    if vertices is None or faces is None:
        names = ", ".join(element.name for element in elements) or "none"
        raise _Damaged("header", f"elements {names}", "elements 'vertex' and 'face'")
    _check_corners(faces, len(vertices))
    return vertices, faces


def _check_corners(faces: list[list[int]], n_vertices: int) -> None:
    """Raise `_Damaged` for the first face that has a corner which is no vertex."""
    corner = np.fromiter(chain.from_iterable(faces), np.int64)
    wrong = np.flatnonzero((corner < 0) | (corner >= n_vertices))
    if len(wrong):
        last = np.cumsum([len(face) for face in faces])
        number = int(np.searchsorted(last, wrong[0], side="right"))
        found = f"vertex {corner[wrong[0]]} of {n_vertices}"
        raise _Damaged(f"face {number}", found, "numbers of vertices, from 0")


def _corners(rows: list[NDArray[Any]], element: _Element) -> list[list[int]]:
    """Vertices of each face."""
    name = next((c.name for c in element.properties if c.name in _CORNERS and c.count), "")
    if not name:
        raise _Damaged("header", "faces without vertices", f"a list {_CORNERS[0]}")
    faces: list[list[int]] = []
    for some in rows:
        corners = some[name]
        with np.errstate(invalid="ignore"):
            whole = corners.astype(np.int64)
        wrong = np.flatnonzero((whole != corners).any(axis=1)) if corners.shape[1] >= 3 else np.zeros(1, np.int64)
        if len(wrong):
            found = f"vertices {', '.join(map(str, corners[wrong[0]][:8].tolist())) or 'none'}"
            raise _Damaged(f"face {len(faces) + int(wrong[0])}", found, "three whole numbers or more")
        faces.extend(whole.tolist())
    return faces


def _rows(body: bytes, at: int, element: _Element, order: str) -> tuple[list[NDArray[Any]], int]:
    """All rows of an element, in pieces whose lists have the same lengths, and where the next element begins."""
    pieces: list[NDArray[Any]] = []
    done, look = 0, _FIRST_LOOK
    while done < element.rows:
        lengths = _lengths(body, at, element, order, done)
        row = _row_type(element, order, lengths)
        wanted = min(element.rows - done, look if lengths else element.rows)
        number = wanted if row.itemsize == 0 else min(wanted, (len(body) - at) // row.itemsize)
        if number < 1 or (number < wanted and not lengths):
            raise _Damaged(f"{element.name} {done + number}", "the data end there", f"{element.rows} of them")
        if row.itemsize == 0:
            return pieces, at
        rows = np.frombuffer(body, row, number, at)
        same = np.ones(number, bool)
        for name, length in lengths.items():
            same &= rows[f"{name} length"] == length
        kept = number if same.all() else int(same.argmin())
        pieces.append(rows[:kept])
        done, at = done + kept, at + kept * row.itemsize
        look = 4 * look if kept == number else _FIRST_LOOK
    return pieces, at


def _lengths(body: bytes, at: int, element: _Element, order: str, number: int) -> dict[str, int]:
    """Lengths of the lists of the row that begins there."""
    lengths: dict[str, int] = {}
    for column in element.properties:
        if column.count:
            kind = np.dtype(order + column.count)
            if at + kind.itemsize > len(body):
                raise _Damaged(f"{element.name} {number}", "the data end there", f"{element.rows} of them")
            length = float(np.frombuffer(body, kind, 1, at)[0])
            if not 0.0 <= length <= _LONGEST_LIST or length != int(length):
                raise _Damaged(f"{element.name} {number}", f"a list of {length:g}", "a length")
            lengths[column.name] = int(length)
            at += kind.itemsize + int(length) * np.dtype(column.kind).itemsize
        else:
            at += np.dtype(column.kind).itemsize
    return lengths


def _row_type(element: _Element, order: str, lengths: dict[str, int]) -> np.dtype[Any]:
    """Rows whose lists have these lengths."""
    fields: list[Any] = []
    for column in element.properties:
        if column.count:
            fields.append((f"{column.name} length", order + column.count))
            fields.append((column.name, order + column.kind, (lengths[column.name],)))
        else:
            fields.append((column.name, order + column.kind))
    try:
        return np.dtype(fields)
    except ValueError:
        raise _Damaged("header", f"properties of '{element.name}' of one name", "different names") from None
