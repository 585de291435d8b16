"""A scene as its file describes it, to be changed and written elsewhere."""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.mending.obj_file import obj_text
from hradiosity.io.mending.toml_text import toml_text
from hradiosity.io.meshes import METRES, MeshPart, read_mesh
from hradiosity.io.output_folder import write_file
from hradiosity.io.scene.boxes import FACES
from hradiosity.io.scene.frame import rotation
from hradiosity.io.scene.pieces import is_degenerate
from hradiosity.io.scene.validate import parse_toml
from hradiosity.io.scene_toml import SCENE_FILE
from hradiosity.model.geometry import Patches
from hradiosity.model.meshing import merge_and_trace

_REMARK: Final = "A copy of a scene, mended by `hradiosity check --repair`; comments are not kept.\n"
_UPRIGHT: Final = ("left", "right", "front", "back")


class CannotMend(Exception):
    """A change that the scene file has no words for, or that would change more than it should; says why."""


@dataclass
class _Mesh:
    """One ``[[mesh]]`` table with what its file holds, in metres with z up."""

    table: dict[str, Any]
    prefix: str
    parts: list[MeshPart]

    def rows(self, name: str) -> Iterator[tuple[int, NDArray[np.int64], int]]:
        """Of each part of an object: its number, the patch of each triangle (or -1), and how many patches it has."""
        for number, part in enumerate(self.parts):
            if self.object_of(part) == name:
                pieces, piece_of = merge_and_trace(part.vertices, part.triangles)
                n = np.zeros(len(pieces.origin), np.int32)
                whole = Patches(pieces.origin, pieces.edge_u, pieces.edge_v, pieces.is_triangle, n, n, n, n)
                kept = ~is_degenerate(whole)
                patch = np.where(kept, np.cumsum(kept) - 1, -1)
                yield number, np.where(piece_of < 0, -1, patch[piece_of]), int(kept.sum())

    def object_of(self, part: MeshPart) -> str:
        """Name of the object in the scene."""
        return f"{self.prefix}/{part.name}" if part.name else self.prefix

    def into_file(self) -> NDArray[np.float64]:
        """(3, 3): directions of the scene in metres to those of the mesh, which is placed turned and scaled."""
        turn = float(self.table.get("scale", 1.0)) * rotation((0.0, 0.0, 1.0), self.table.get("rotation_deg", 0.0))
        return np.asarray(np.linalg.inv(turn))


class SceneCopy:
    """What a scene file says, with all of its files.

    Objects are known by their names, which every table gets, and patches by their place among those of the object.

    Parameters
    ----------
    file : Path
        A scene file that can be read without faults.
    """

    def __init__(self, file: Path) -> None:
        self._source = file.resolve().parent
        _, raw = parse_toml(file)
        self._tables: dict[str, Any] = copy.deepcopy(raw)
        header = self._tables["scene"]
        header.setdefault("title", self._source.name)
        self._unit, self._up = METRES[header["unit"]], header.get("up", "z")
        for kind in ("rectangle", "polygon", "box"):
            for number, table in enumerate(self._tables.get(kind, []), start=1):
                table.setdefault("name", f"{kind}-{number}")
        self._meshes = [self._read(table) for table in self._tables.get("mesh", [])]

    def _read(self, table: dict[str, Any]) -> _Mesh:
        guesses = "upsample" in table
        content = read_mesh(self._source / table["file"], table["unit"], table["up"], textures=guesses)
        table["name"] = prefix = table.get("name") or Path(table["file"]).stem
        for part in content.parts:
            mapped = {**table.get("materials", {})}
            if guesses and part.texture is not None and not {part.name, part.material} & mapped.keys():
                self._keep_guess(table, prefix, part)
        table.pop("upsample", None)
        parts = [replace(part, texture=None) for part in content.parts]
        return _Mesh(table, prefix, parts)

    def _keep_guess(self, table: dict[str, Any], prefix: str, part: MeshPart) -> None:
        """The mean colour of a picture as a material, since the copy has no pictures."""
        paint = part.material or part.name
        mean = part.texture.mean if part.texture is not None else None
        colour = {"rgb": list(mean or ()), "upsample": table["upsample"]}
        self._tables.setdefault("materials", {})[f"{prefix}/{paint}"] = {"reflectance": colour}
        table.setdefault("materials", {})[paint] = f"{prefix}/{paint}"

    def is_mesh(self, name: str) -> bool:
        """Whether an object comes from a mesh file."""
        return any(mesh.object_of(part) == name for mesh in self._meshes for part in mesh.parts)

    def is_read_by_sensors(self, name: str) -> bool:
        """Whether a sensor lies on the object, or on the mesh that it belongs to."""
        wanted = {sensor.get("object") for sensor in self._tables.get("sensor", [])}
        return name in wanted or name.partition("/")[0] in wanted

    def move(self, name: str, by: NDArray[np.float64]) -> None:
        """Shift an object by a vector (3,) in metres, z up."""
        found = self._table(name)
        if found is None:
            mesh = self._mesh(name)
            step = mesh.into_file() @ by
            for number, part in enumerate(mesh.parts):
                if mesh.object_of(part) == name:
                    mesh.parts[number] = replace(part, vertices=part.vertices + step)
            return
        _, table = found
        x, y, z = by / self._unit
        step = np.array([x, z, -y] if self._up == "y" else [x, y, z])
        for key in ("corner", "centre"):
            if key in table:
                table[key] = (np.asarray(table[key], np.float64) + step).tolist()
        if "vertices" in table:
            table["vertices"] = (np.asarray(table["vertices"], np.float64) + step).tolist()

    def turn(self, name: str, patches: NDArray[np.int64]) -> None:
        """Let some patches of an object face the other way; all of them unless it comes from a mesh file."""
        found = self._table(name)
        if found is None:
            for mesh, number, own in self._own_triangles(name, patches):
                part = mesh.parts[number]
                triangles = part.triangles.copy()
                triangles[own] = triangles[own][:, ::-1]
                mesh.parts[number] = replace(part, triangles=triangles)
            return
        kind, table = found
        if kind == "rectangle":
            table["edge_u"], table["edge_v"] = table["edge_v"], table["edge_u"]
        elif kind == "box":
            table["inside"] = not table.get("inside", False)
        else:
            faces = table.get("faces") or [list(range(len(table["vertices"])))]
            table["faces"] = [face[::-1] for face in faces]

    def drop(self, name: str, patches: NDArray[np.int64], total: int) -> None:
        """Leave out some of an object's patches.

        Raises
        ------
        CannotMend
            When only the whole object could be left out.
        """
        found = self._table(name)
        if found is None:
            for mesh, number, own in self._own_triangles(name, patches):
                part = mesh.parts[number]
                mesh.parts[number] = replace(part, triangles=part.triangles[~own])
            return
        kind, table = found
        if len(patches) == total:
            self._tables[kind] = [other for other in self._tables[kind] if other is not table]
        elif kind == "box":
            left = [face for face in FACES if face not in _single(table.get("omit", []))]
            table["omit"] = [*table.get("omit", []), *(left[int(patch)] for patch in patches)]
        else:
            raise CannotMend(f"only some faces of {kind} '{name}' would go")

    def mesh_objects(self, name: str) -> tuple[str, ...]:
        """All objects of the mesh that an object belongs to."""
        mesh = self._mesh(name)
        return tuple(dict.fromkeys(mesh.object_of(part) for part in mesh.parts))

    def reshape(self, names: Collection[str], change: Any) -> None:
        """Give all parts of some objects of one mesh new triangles.

        Parameters
        ----------
        names : at least one
        change : callable
            From points (n, 3) [m] and triangles (m, 3) to new ones and the triangle that each comes from.
        """
        mesh = self._mesh(next(iter(names)))
        scale = float(mesh.table.get("scale", 1.0))
        mine = [number for number, part in enumerate(mesh.parts) if mesh.object_of(part) in names]
        first = np.cumsum([0, *(len(mesh.parts[number].vertices) for number in mine)])
        points = np.concatenate([mesh.parts[number].vertices for number in mine])
        blocks = [mesh.parts[number].triangles.astype(np.int64) + start for number, start in zip(mine, first)]
        owner = np.repeat(mine, [len(block) for block in blocks])
        points, triangles, source = change(points * scale, np.concatenate(blocks))
        for number in mine:
            used, local = np.unique(triangles[owner[source] == number], return_inverse=True)
            faces = local.reshape(-1, 3).astype(np.int32)
            mesh.parts[number] = replace(mesh.parts[number], vertices=points[used] / scale, triangles=faces)

    def write(self, folder: Path) -> None:
        """Write the scene file, the meshes as OBJ files and the spectra into a folder that exists.

        Raises
        ------
        OutputError
            When a file can't be written.
        """
        tables = copy.deepcopy(self._tables)
        tables["mesh"] = []
        for number, mesh in enumerate(self._meshes, start=1):
            parts = [part for part in mesh.parts if len(part.triangles)]
            if parts:
                name = f"mesh-{number}.obj"
                write_file(folder / name, obj_text(parts, "metres, z up").encode())
                tables["mesh"].append(_pruned(mesh.table, parts) | {"file": name, "unit": "m", "up": "z"})
        taken: dict[Path, str] = {}
        for kind in ("materials", "luminaires", "actions", "sky", "variant"):
            for table in _with_files(tables.get(kind, {})):
                source = (self._source / table["file"]).resolve()
                table["file"] = taken.setdefault(source, f"spectrum-{len(taken) + 1}-{source.name}")
        for source, name in taken.items():
            write_file(folder / name, source.read_bytes())
        kept = {key: value for key, value in tables.items() if value not in ([], {})}
        write_file(folder / SCENE_FILE, toml_text(kept, _REMARK).encode())

    def _table(self, name: str) -> tuple[str, dict[str, Any]] | None:
        """Kind and table of an object; None for one of a mesh."""
        for kind in ("rectangle", "polygon", "box"):
            for table in self._tables.get(kind, []):
                if table["name"] == name:
                    return kind, table
        return None

    def _mesh(self, name: str) -> _Mesh:
        return next(mesh for mesh in self._meshes if any(mesh.object_of(part) == name for part in mesh.parts))

    def _own_triangles(self, name: str, patches: NDArray[np.int64]) -> list[tuple[_Mesh, int, NDArray[np.bool_]]]:
        """Of each part of a mesh object: which of its triangles belong to the patches."""
        mesh, first, found = self._mesh(name), 0, []
        for number, patch_of, count in mesh.rows(name):
            own = np.isin(patch_of, patches[(patches >= first) & (patches < first + count)] - first) & (patch_of >= 0)
            found.append((mesh, number, own))
            first += count
        return found


def _pruned(table: Mapping[str, Any], parts: list[MeshPart]) -> dict[str, Any]:
    """A mesh table without entries for objects and materials that are gone."""
    known = {name for part in parts for name in (part.name, part.material)}
    kept = dict(table)
    for key in ("materials", "luminaires"):
        if key in kept:
            kept[key] = {name: value for name, value in kept[key].items() if name in known}
    return kept


def _single(faces: list[str]) -> set[str]:
    return {single for face in faces for single in (_UPRIGHT if face == "sides" else (face,))}


def _with_files(table: Any) -> Iterator[dict[str, Any]]:
    """All tables inside of one that name a file."""
    if isinstance(table, dict):
        if isinstance(table.get("file"), str):
            yield table
        for value in table.values():
            yield from _with_files(value)
    elif isinstance(table, list):
        for value in table:
            yield from _with_files(value)
