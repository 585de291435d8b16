"""Wavefront OBJ with its MTL files, read in double precision and with names as they stand there."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

import numpy as np

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import PartLabel, RawMesh, Texture, notes_on_faces, triangulate_faces
from hradiosity.model.scene import Note

_MOST_FAULTS: Final = 20
_MAP_OPTIONS: Final = {
    **dict.fromkeys(("-blendu", "-blendv", "-boost", "-bm", "-cc", "-clamp", "-imfchan", "-texres", "-type"), 1),
    "-mm": 2,
    **dict.fromkeys(("-o", "-s", "-t"), 3),
}
"""Options of a texture, and how many words follow each, at most."""
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_SURFACES: Final = "free-form surfaces"
_NOT_READ: Final = {"l": "lines", "p": "points", "curv": "curves", "curv2": "curves", "surf": _SURFACES}


@dataclass
class _Parser:
    """State while the lines of one file pass by."""

    path: Path
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    faces: list[list[int]] = field(default_factory=list)
    face_part: list[int] = field(default_factory=list)
    parts: dict[tuple[str, str, str], int] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    object_name: str = ""
    group_name: str = ""
    material: str = ""

    def vertex(self, text: str) -> None:
        try:
            x, y, z = text.split(maxsplit=3)[:3]
            self.vertices.append((float(x), float(y), float(z)))
        except ValueError:
            raise ValueError("a vertex needs three numbers") from None

    def face(self, text: str) -> None:
        n = len(self.vertices)
        try:
            corners = [int(word.partition("/")[0]) for word in text.split()]
        except ValueError:
            raise ValueError("corners are whole numbers of vertices") from None
        corners = [number - 1 if number > 0 else n + number for number in corners]
        if len(corners) < 3:
            raise ValueError("a face needs three corners")
        if not all(0 <= number < n for number in corners):
            raise ValueError(f"a corner that isn't among the {n} vertices above")
        key = (self.object_name, self.group_name, self.material)
        self.faces.append(corners)
        self.face_part.append(self.parts.setdefault(key, len(self.parts)))

    def name_object(self, text: str) -> None:
        self.object_name = text

    def name_group(self, text: str) -> None:
        self.group_name = text

    def use_material(self, text: str) -> None:
        self.material = text

    def library(self, text: str) -> None:
        self.libraries.append(text)


def read_obj(path: Path) -> RawMesh:
    """Read an OBJ file.

    A part is what shares object name (``o``; without it the whole ``g`` line) and material (``usemtl``). Names may
    hold spaces. Faces are cut into triangles; lines, points and free-form surfaces are left out with a note.

    Raises
    ------
    SceneError
        Naming the lines that can't be understood.
    """
    parser = _Parser(path)
    actions: dict[str, Callable[[str], None]] = {
        "v": parser.vertex,
        "f": parser.face,
        "o": parser.name_object,
        "g": parser.name_group,
        "usemtl": parser.use_material,
        "mtllib": parser.library,
    }
    for number, line in _lines(_text(path)):
        keyword, _, rest = line.partition(" ")
        action = actions.get(keyword)
        if action is None:
            if keyword in _NOT_READ:
                parser.left_out[_NOT_READ[keyword]] = parser.left_out.get(_NOT_READ[keyword], 0) + 1
            continue
        try:
            action(rest.strip())
        except ValueError as error:
            parser.faults.append(Fault(str(path), f"line {number}", f"{line[:60]!r} ({error})", "a valid OBJ line"))
            if len(parser.faults) == _MOST_FAULTS:
                break
    if parser.faults:
        raise SceneError(parser.faults)
    return _assemble(parser)


def _assemble(parser: _Parser) -> RawMesh:
    vertices = np.array(parser.vertices, dtype=np.float64).reshape(-1, 3)
    cut = triangulate_faces(vertices, parser.faces)
    textures, notes = _read_libraries(parser)
    labels: dict[PartLabel, int] = {}
    renumber = np.zeros(len(parser.parts), dtype=np.int64)
    for (name, group, material), part in parser.parts.items():
        label = PartLabel(name or group or parser.path.stem, material, textures.get(material))
        renumber[part] = labels.setdefault(label, len(labels))
    place = str(parser.path)
    for what, number in parser.left_out.items():
        kind: Literal["warning", "info"] = "warning" if what == _SURFACES else "info"
        notes.append(Note(kind, place, f"{number} {what} left out: only faces are read"))
    notes += notes_on_faces(cut, place)
    part_of_face = renumber[np.array(parser.face_part, dtype=np.int64)[cut.face]]
    return RawMesh(vertices, cut.triangles, part_of_face, tuple(labels), tuple(notes))


def _text(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Numbered lines without comments, blanks, and with continued ones joined."""
    pending = ""
    for number, raw in enumerate(text.split("\n"), start=1):
        line = raw.strip()
        if line.endswith("\\"):
            pending += line[:-1] + " "
            continue
        line, pending = (pending + line).replace("\t", " "), ""
        if line and not line.startswith("#"):
            yield number, line


def _read_libraries(parser: _Parser) -> tuple[dict[str, Texture], list[Note]]:
    """Colour textures by material, and notes on libraries that aren't there."""
    textures: dict[str, Texture] = {}
    notes = []
    for library in parser.libraries:
        path = parser.path.parent / library
        if not path.is_file():
            message = (
                f"material library {library!r} is missing: textures are not known (reflectances come from the scene)"
            )
            notes.append(Note("info", str(parser.path), message))
            continue
        textures.update(_textures(path))
    return textures, notes


def _textures(path: Path) -> dict[str, Texture]:
    """Colour textures of one material library; ``Kd`` multiplies them, wherever it stands."""
    name = ""
    pictures: dict[str, str] = {}
    factors: dict[str, tuple[float, float, float]] = {}
    for _, line in _lines(_text(path)):
        keyword, _, rest = line.partition(" ")
        if keyword == "newmtl":
            name = rest.strip()
        elif keyword.lower() == "map_kd" and (picture := _picture_name(rest.split())):
            pictures[name] = picture
        elif keyword == "Kd":
            factors[name] = _factor(rest.split())
    return {
        name: Texture(picture, path.parent / picture.replace("\\", "/"), factors.get(name, (1.0, 1.0, 1.0)))
        for name, picture in pictures.items()
    }


def _factor(words: list[str]) -> tuple[float, float, float]:
    """Linear colour of a ``Kd`` line: one number stands for all three; 1 where it is written in another way."""
    try:
        red, green, blue = (float(word) for word in (words * 3 if len(words) == 1 else words[:3]))
    except ValueError:
        return 1.0, 1.0, 1.0
    return red, green, blue


def _picture_name(words: list[str]) -> str:
    """File name of a ``map_Kd`` line, which may hold spaces, without the options before it."""
    at = 0
    while at < len(words) and words[at] in _MAP_OPTIONS:
        most, at = _MAP_OPTIONS[words[at]], at + 1
        if most == 1:
            at += 1
        else:
            end = at + most
            while at < end and at < len(words) - 1 and _NUMBER.fullmatch(words[at]):
                at += 1
    return " ".join(words[at:])
