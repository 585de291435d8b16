"""Meshes from OBJ, glTF, PLY and STL files, in metres with z up."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.model.scene import Note

SUFFIXES: Final = (".obj", ".gltf", ".glb", ".ply", ".stl")
"""File formats that are read."""
METRES: Final = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
"""Length of each unit [m]."""
TIMEOUT: Final = 30.0
"""Seconds after which reading one file is given up, beside `TIMEOUT_PER_MB`."""
TIMEOUT_PER_MB: Final = 5.0
"""More of them for each million bytes of the file."""


@dataclass(frozen=True)
class TextureColour:
    """The picture of a material.

    name : as the mesh file has it
    mean : (3,) linear sRGB, plain mean over the picture times the material's factor; None if it wasn't asked for or
        can't be had
    fault : why it can't be had
    """

    name: str
    mean: tuple[float, float, float] | None
    fault: str


@dataclass(frozen=True)
class MeshPart:
    """Faces of one object and one material.

    name, material : as the file has them; ``material`` is empty if the file names none
    vertices : (n, 3) float64 [m], z up
    triangles : (m, 3) int32, counter-clockwise as seen from the front
    texture : the picture that the file gives this material instead of one colour
    """

    name: str
    material: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    texture: TextureColour | None


class MeshFile(NamedTuple):
    """Parts in the order of the file, and what was mended or left out while reading it."""

    parts: tuple[MeshPart, ...]
    notes: tuple[Note, ...]


def read_mesh(path: Path, unit: str, up: str, *, textures: bool = False, timeout: float | None = None) -> MeshFile:
    """Read a mesh file, mend it, and bring it to metres with z up.

    Coordinates of OBJ files are read in double precision; PLY, STL and glTF carry single precision, which is
    8e-3 mm at an offset of 100 m. Reading runs in a process of its own: a file that crashes the reader is a fault of
    that file.

    Parameters
    ----------
    unit : str
        Unit of the lengths in the file, a key of ``METRES``: mesh files don't say it.
    up : str
        Upward axis of the file, "z" or "y"; y up becomes z up by a quarter turn about x.
    textures : bool
        Read the pictures of materials for their mean colour.
    timeout : float, optional
        Seconds after which reading is given up; by the size of the file if left out.

    Raises
    ------
    SceneError
        The file is missing, empty, damaged, of an unknown format, or holds no usable faces.
    ValueError
        Unknown unit or axis.
    """
    if unit not in METRES or up not in ("y", "z"):
        raise ValueError(f"unit must be one of {', '.join(METRES)} and up y or z; got {unit!r} and {up!r}")
    _check_file(path)
    if timeout is None:
        timeout = TIMEOUT + TIMEOUT_PER_MB * 1e-6 * path.stat().st_size
    with tempfile.TemporaryDirectory(prefix="hradiosity-") as folder:
        result = Path(folder) / "mesh.npz"
        _run_worker(path, result, ["textures"] if textures else [], timeout)
        with np.load(result) as stored:
            content: dict[str, Any] = dict(stored)
    if "faults" in content:
        raise SceneError([Fault(**fault) for fault in json.loads(str(content["faults"]))])
    described = json.loads(str(content["described"]))
    vertices = _world_from_file(content["vertices"], METRES[unit], up)
    parts = _parts(described["labels"], vertices, content["triangles"], content["part"])
    return MeshFile(parts, tuple(Note(**note) for note in described["notes"]))


def _check_file(path: Path) -> None:
    if path.suffix.lower() not in SUFFIXES:
        known = ", ".join(SUFFIXES)
        raise SceneError([Fault(str(path), "", f"unknown mesh format {path.suffix!r}", f"one of {known}")])
    if not path.is_file():
        raise SceneError([Fault(str(path), "", "file not found", "an existing mesh file")])
    if path.stat().st_size == 0:
        raise SceneError([Fault(str(path), "", "the file is empty", "a mesh of faces")])


def _run_worker(path: Path, result: Path, more: list[str], timeout: float) -> None:
    """Run `hradiosity.io.mesh.worker`; turns crash and hang into a fault of the file."""
    package_root = str(Path(__file__).resolve().parents[2])
    paths = [package_root, *filter(None, [os.environ.get("PYTHONPATH")])]
    command = [sys.executable, "-m", "hradiosity.io.mesh.worker", str(path), str(result), *more]
    try:
        done = subprocess.run(
            command,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        message = f"reading took more than {timeout:g} s and was given up"
        raise SceneError([Fault(str(path), "", message, "a smaller or undamaged file")]) from error
    if done.returncode < 0:
        cause = signal.strsignal(-done.returncode) or f"signal {-done.returncode}"
        raise SceneError([Fault(str(path), "", f"crashes the reader ({cause}): damaged", "export it again")])
    if done.returncode > 0:
        last = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise SceneError([Fault(str(path), "", f"can't be read ({last})", "export it again")])


def _world_from_file(vertices: NDArray[np.float64], metres: float, up: str) -> NDArray[np.float64]:
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    return vertices * metres


def _parts(
    labels: list[dict[str, Any]], vertices: NDArray[np.float64], triangles: NDArray[np.int64], part: NDArray[np.int64]
) -> tuple[MeshPart, ...]:
    """One part for each label that has faces, each with its own vertices only."""
    parts = []
    for number, label in enumerate(labels):
        used, local = np.unique(triangles[part == number], return_inverse=True)
        if len(used):
            faces = local.reshape(-1, 3).astype(np.int32)
            found = label["texture"]
            texture = None if found is None else TextureColour(**found)
            parts.append(MeshPart(label["name"], label["material"], vertices[used], faces, texture))
    return tuple(parts)
