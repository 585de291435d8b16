"""Scene files from Python values."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Vector = Sequence[float]
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def scene_text(
    title: str,
    materials: Mapping[str, Any],
    luminaires: Mapping[str, Mapping[str, Any]],
    entries: Iterable[str],
    bands: Mapping[str, Any] | None = None,
) -> str:
    """Content of ``scene.toml``, in metres.

    Parameters
    ----------
    materials : mapping of name to reflectance, as in the file
    luminaires : mapping of name to the keys of its table
    entries : what `entry` gives
    bands : of the header; those of the format if left out
    """
    lines = ["[scene]", f"title = {literal(title)}", 'unit = "m"']
    if bands:
        lines.append(f"bands = {literal(bands)}")
    for name, reflectance in materials.items():
        lines += ["", f"[materials.{name}]", f"reflectance = {literal(reflectance)}"]
    for name, keys in luminaires.items():
        lines += ["", f"[luminaires.{name}]", *_keys(keys)]
    return "\n".join([*lines, "", *entries])


def entry(kind: str, /, **keys: Any) -> str:
    """A table of a list, ``[[kind]]``."""
    return "\n".join([f"[[{kind}]]", *_keys(keys), ""])


def points(name: str, positions: Sequence[Vector], normals: Sequence[Vector] | Vector) -> str:
    """A sensor of single points; one normal serves all."""
    one = isinstance(normals[0], float | int)
    direction = {"normal" if one else "normals": normals}
    return entry("sensor", name=name, kind="points", positions=positions, **direction)


def grid(name: str, corner: Vector, edge_u: Vector, edge_v: Vector, counts: tuple[int, int], **keys: Any) -> str:
    """A sensor of points at the centres of cells."""
    return entry("sensor", name=name, kind="grid", corner=corner, edge_u=edge_u, edge_v=edge_v, counts=counts, **keys)


def room(size: Vector, **faces: str) -> str:
    """A closed room at the origin; a material for each of bottom, top and the upright faces."""
    return entry("box", name="room", corner=(0, 0, 0), size=size, inside=True, faces=faces)


def lamp(corner: Vector, along_x: float, along_y: float, material: str, luminaire: str, *, up: bool = False) -> str:
    """A flat lamp that shines downwards, or upwards."""
    x, y = (along_x, 0, 0), (0, along_y, 0)
    edges = (x, y) if up else (y, x)
    return entry("rectangle", corner=corner, edge_u=edges[0], edge_v=edges[1], material=material, luminaire=luminaire)


def block(corner: Vector, size: Vector, material: str, **keys: Any) -> str:
    """A solid box."""
    return entry("box", corner=corner, size=size, material=material, **keys)


def literal(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {literal(item)}" for key, item in value.items()) + " }"
    if isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(literal, value)) + "]"
    return repr(value if isinstance(value, int) else float(value))


def _keys(keys: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {literal(value)}" for key, value in keys.items()]
