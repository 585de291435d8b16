"""Parts of a mesh as an OBJ file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hradiosity.io.meshes import MeshPart


def obj_text(parts: Sequence[MeshPart], remark: str) -> str:
    """Vertices with all their digits, and triangles under the names of object and material."""
    lines = [f"# {remark}"]
    first = 1
    for part in parts:
        lines += map("v %r %r %r".__mod__, map(tuple, part.vertices.tolist()))
        lines += [f"o {part.name}", f"usemtl {part.material}"]
        lines += map("f %d %d %d".__mod__, map(tuple, (np.asarray(part.triangles, np.int64) + first).tolist()))
        first += len(part.vertices)
    return "\n".join(lines) + "\n"
