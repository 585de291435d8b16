"""STL through assimp, which keeps coordinates in single precision (8 µm at 100 m from the origin)."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import PartLabel, RawMesh


def read_with_assimp(path: Path) -> RawMesh:
    """Read a format without objects and materials: one part named after the file.

    Damaged files have been seen to crash assimp, so this runs in a process of its own (`hradiosity.io.mesh.worker`).

    Raises
    ------
    SceneError
        When assimp refuses the file.
    """
    import assimp_py

    try:
        scene = assimp_py.import_file(str(path), assimp_py.Process_Triangulate)
    except (RuntimeError, ValueError) as error:
        cause = str(error).removeprefix(f"Assimp error loading '{path}': ")
        raise SceneError([Fault(str(path), "", f"the faces can't be read ({cause})", "export it again")]) from error
    vertices: list[NDArray[np.float64]] = [np.empty((0, 3))]
    triangles: list[NDArray[np.int64]] = [np.empty((0, 3), dtype=np.int64)]
    count = 0
    for mesh in scene.meshes:
        if mesh.vertices is None or mesh.indices is None:
            continue
        corners = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        vertices.append(corners)
        triangles.append(np.asarray(mesh.indices, dtype=np.int64).reshape(-1, 3) + count)
        count += len(corners)
    faces = np.concatenate(triangles)
    label = PartLabel(path.stem, "")
    return RawMesh(np.concatenate(vertices), faces, np.zeros(len(faces), dtype=np.int64), (label,))
