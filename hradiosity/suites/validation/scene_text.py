"""Scenes written out as a user would write them: ``scene.toml`` from a few values."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from hradiosity.suites.validation.values import SENSOR

Vector = Sequence[float]
FACES = ("x0", "x1", "y0", "y1", "floor", "ceiling")
INWARD = {
    "x0": (1, 0, 0),
    "x1": (-1, 0, 0),
    "y0": (0, 1, 0),
    "y1": (0, -1, 0),
    "floor": (0, 0, 1),
    "ceiling": (0, 0, -1),
}
BANDS = "bands = { first = 360, last = 830, step = 5 }"
"""All wavelengths that count in illuminances: of a constant spectrum 4e-6 lies beyond the bands from 380 to 780 nm."""
_BOX_FACES = dict(zip(FACES, ("left", "right", "front", "back", "bottom", "top")))


class Entry(Protocol):
    """A table of the scene file."""

    def lines(self) -> list[str]:
        """As it stands in the file."""


@dataclass(frozen=True)
class Rectangle:
    """A ``[[rectangle]]``; its front is where edge_u × edge_v points."""

    corner: Vector
    edge_u: Vector
    edge_v: Vector
    material: str
    luminaire: str | None = None

    def lines(self) -> list[str]:
        """As it stands in the file."""
        rows = ["[[rectangle]]", *(f"{key} = {_list(getattr(self, key))}" for key in ("corner", "edge_u", "edge_v"))]
        rows.append(f'material = "{self.material}"')
        return [*rows, f'luminaire = "{self.luminaire}"'] if self.luminaire else rows


@dataclass(frozen=True)
class Polygon:
    """A ``[[polygon]]``; corners counter-clockwise seen from the front."""

    corners: Sequence[Vector]
    material: str
    luminaire: str | None = None

    def lines(self) -> list[str]:
        """As it stands in the file."""
        rows = ["[[polygon]]", f"vertices = [{', '.join(map(_list, self.corners))}]", f'material = "{self.material}"']
        return [*rows, f'luminaire = "{self.luminaire}"'] if self.luminaire else rows


@dataclass(frozen=True)
class Room:
    """A ``[[box]]`` seen from inside, a material named after each face; omit: faces that are left out."""

    size: Vector
    luminous: str | None = None
    omit: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """As it stands in the file."""
        faces = ", ".join(f'{box} = "{face}"' for face, box in _BOX_FACES.items() if face not in self.omit)
        rows = ["[[box]]", 'name = "room"', "corner = [0, 0, 0]", f"size = {_list(self.size)}", "inside = true"]
        rows.append(f"faces = {{ {faces} }}")
        if self.luminous:
            rows.append(f'luminaires = {{ {_BOX_FACES[self.luminous]} = "lamp" }}')
        if self.omit:
            rows.append(f"omit = {json.dumps([_BOX_FACES[face] for face in self.omit])}")
        return rows


@dataclass(frozen=True)
class Solid:
    """A ``[[box]]`` seen from outside."""

    corner: Vector
    size: Vector
    material: str

    def lines(self) -> list[str]:
        """As it stands in the file."""
        return [
            *("[[box]]", f"corner = {_list(self.corner)}", f"size = {_list(self.size)}"),
            f'material = "{self.material}"',
        ]


@dataclass(frozen=True)
class Source:
    """A ``[[point_source]]`` of the luminaire "lamp"."""

    position: Vector

    def lines(self) -> list[str]:
        """As it stands in the file."""
        return ["[[point_source]]", f"position = {_list(self.position)}", 'luminaire = "lamp"']


@dataclass(frozen=True)
class Mesh:
    """A ``[[mesh]]`` in metres, all of it of one material."""

    file: str
    material: str
    luminaire: str | None = None

    def lines(self) -> list[str]:
        """As it stands in the file; everything in it is called "surface"."""
        rows = ["[[mesh]]", f'name = "{self.material}"', f'file = "{self.file}"', 'unit = "m"', 'up = "z"']
        rows.append(f'material = "{self.material}"')
        return [*rows, f'luminaires = {{ "surface" = "{self.luminaire}" }}'] if self.luminaire else rows


@dataclass(frozen=True)
class Light:
    """How much light there is: a key of the format and its value."""

    key: str
    value: float


def scene_text(
    title: str,
    objects: Iterable[Entry],
    paints: Mapping[str, float],
    points: Iterable[tuple[Vector, Vector]],
    *,
    lamp: Light | None = None,
    sky: Light | None = None,
) -> str:
    """A scene file with one sensor.

    Parameters
    ----------
    paints : mapping of str to float
        Materials and their reflectances, the same at all wavelengths.
    points : iterable of (position, normal)
        Of the sensor [m]; normals of any length.
    lamp : Light, optional
        Of the luminaire "lamp".
    sky : Light, optional
        Of the uniform sky.
    """
    lines = ["[scene]", f"title = {json.dumps(title)}", 'unit = "m"', BANDS]
    for name, reflectance in paints.items():
        lines += ["", f"[materials.{name}]", f"reflectance = {float(reflectance)!r}"]
    if lamp:
        lines += ["", "[luminaires.lamp]", "spectrum = { constant = 1 }", f"{lamp.key} = {lamp.value!r}"]
    if sky:
        lines += ["", "[sky]", 'kind = "uniform"', "spectrum = { constant = 1 }", f"{sky.key} = {sky.value!r}"]
    for item in objects:
        lines += ["", *item.lines()]
    places, normals = zip(*points)
    lines += ["", "[[sensor]]", f'name = "{SENSOR}"', 'kind = "points"']
    lines += [f"positions = [{', '.join(map(_list, places))}]", f"normals = [{', '.join(map(_list, normals))}]"]
    return "\n".join(lines) + "\n"


def wall_with_opening(
    face: str, size: Vector, low: Vector, high: Vector, material: str, opening: tuple[str, str | None] | None = None
) -> list[Rectangle]:
    """A face of a room at the origin in four pieces round an opening, fronts inwards.

    Parameters
    ----------
    face : str
        "y0" or "ceiling".
    size : extent of the room [m]
    low, high : corners of the opening in the two coordinates of the face, in the order of the axes [m]
    opening : (material, luminaire), optional
        What fills it; nothing if left out.
    """
    width, height = size[0], size[2] if face == "y0" else size[1]
    (a0, b0), (a1, b1) = low, high
    spans = [(0.0, a0, 0.0, height), (a1, width, 0.0, height), (a0, a1, 0.0, b0), (a0, a1, b1, height)]
    kinds: list[tuple[str, str | None]] = [(material, None)] * 4
    if opening:
        spans, kinds = [*spans, (a0, a1, b0, b1)], [*kinds, opening]
    pieces = []
    for (left, right, lower, upper), kind in zip(spans, kinds):
        if right > left and upper > lower:
            along, up = right - left, upper - lower
            if face == "y0":
                edges = ((left, 0.0, lower), (0.0, 0.0, up), (along, 0.0, 0.0))
            else:
                edges = ((left, lower, size[2]), (0.0, up, 0.0), (along, 0.0, 0.0))
            pieces.append(Rectangle(*edges, *kind))
    return pieces


def _list(vector: Vector) -> str:
    return "[" + ", ".join(repr(float(v)) for v in vector) + "]"
