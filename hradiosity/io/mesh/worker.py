"""Reads and mends one mesh file in a process of its own, so that a crash of native code ends only that process.

Called as ``python -m hradiosity.io.mesh.worker FILE RESULT.npz``, with ``textures`` as a third word to have the mean
colours of textures.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.assimp import read_with_assimp
from hradiosity.io.mesh.clean import clean
from hradiosity.io.mesh.gltf import read_gltf
from hradiosity.io.mesh.obj import read_obj
from hradiosity.io.mesh.ply import read_ply
from hradiosity.io.mesh.raw import PartLabel, RawMesh
from hradiosity.io.mesh.recognise import check_content
from hradiosity.io.mesh.texture import mean_colour

READERS: Final[dict[str, Callable[[Path], RawMesh]]] = {
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".ply": read_ply,
    ".stl": read_with_assimp,
}

BASE_MEMORY: Final = 8 * 2**30
"""Bytes of address space that reading may take beside ``MEMORY_PER_BYTE`` for each byte of the file."""
MEMORY_PER_BYTE: Final = 200


def load(path: Path) -> RawMesh:
    """Read and mend the file; its suffix must be one of ``READERS``.

    Raises
    ------
    SceneError
        When the file can't be read or holds nothing usable.
    """
    try:
        check_content(path)
        mesh = READERS[path.suffix.lower()](path)
    except OSError as error:
        raise SceneError([Fault(str(path), "", f"can't be opened ({error.strerror})", "a readable file")]) from error
    return clean(mesh, str(path))


def limit_memory(path: Path) -> None:
    """Make a damaged count in a file header a refused allocation, not a machine without memory (POSIX only)."""
    if sys.platform != "win32":
        import resource

        size = path.stat().st_size if path.is_file() else 0
        wanted = BASE_MEMORY + MEMORY_PER_BYTE * size
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        soft = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _described(label: PartLabel, *, with_mean: bool) -> dict[str, Any]:
    """Names of a part, and of its texture with the mean colour, or what is wrong with it."""
    found: dict[str, Any] = {"name": label.name, "material": label.material, "texture": None}
    if label.texture is not None:
        found["texture"] = {"name": label.texture.name, "mean": None, "fault": ""}
        if with_mean:
            try:
                found["texture"]["mean"] = mean_colour(label.texture)
            except ValueError as error:
                found["texture"]["fault"] = str(error)
    return found


def main(source: str, target: str, *more: str) -> None:
    """Write the mesh, or the faults, to ``target``."""
    limit_memory(Path(source))
    try:
        mesh = load(Path(source))
    except SceneError as error:
        with Path(target).open("wb") as stream:
            np.savez(stream, faults=np.array(json.dumps([asdict(fault) for fault in error.faults])))
        return
    labels = [_described(label, with_mean="textures" in more) for label in mesh.labels]
    described = {"labels": labels, "notes": [asdict(note) for note in mesh.notes]}
    with Path(target).open("wb") as stream:
        np.savez(
            stream,
            vertices=mesh.vertices,
            triangles=mesh.triangles,
            part=mesh.part,
            described=np.array(json.dumps(described)),
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
