"""Sensors that are spread over the surface of an object."""

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_frame import Frame
from hradiosity.io.scene_lines import Location
from hradiosity.io.scene_pieces import Surfaces
from hradiosity.io.scene_report import Report, did_you_mean
from hradiosity.io.schema_sensors import SurfaceSensor
from hradiosity.model.scene import Sensor

_DEFAULT_OFFSET = 1e-3


def surface_sensor(
    table: SurfaceSensor, location: Location, surfaces: Surfaces, frame: Frame, report: Report
) -> Sensor | None:
    """Points at the centres of equal cells of the object's patches; None and a fault when it has none."""
    chosen = _chosen_patches(table, location, surfaces, report)
    if len(chosen) == 0:
        return None
    patches = surfaces.patches
    offset = _DEFAULT_OFFSET if table.offset is None else frame.length(table.offset)
    sign = 1.0 if table.side == "front" else -1.0
    positions, normals = [], []
    counts = (0, 0)
    for patch in chosen:
        counts = _counts(table, patches.edge_u[patch], patches.edge_v[patch], frame)
        uv = _triangle_centres(max(counts)) if patches.is_triangle[patch] else _cell_centres(*counts)
        normal = sign * patches.normal[patch]
        on_surface = patches.origin[patch] + uv[:, :1] * patches.edge_u[patch] + uv[:, 1:] * patches.edge_v[patch]
        positions.append(on_surface + offset * normal)
        normals.append(np.repeat(normal[None], len(uv), axis=0))
    is_grid = len(chosen) == 1 and not patches.is_triangle[chosen[0]]
    grid = (counts[1], counts[0]) if is_grid else None
    return Sensor(table.name, np.concatenate(positions), np.concatenate(normals), grid)


def _chosen_patches(
    table: SurfaceSensor, location: Location, surfaces: Surfaces, report: Report
) -> NDArray[np.int64]:
    objects = np.array(
        [i for i, name in enumerate(surfaces.objects) if name == table.object or name.startswith(f"{table.object}/")]
    )
    if len(objects) == 0:
        report.fault(
            (*location, "object"), f"no object {table.object!r}", did_you_mean(table.object, surfaces.objects)
        )
        return np.zeros(0, dtype=np.int64)
    wanted = np.isin(surfaces.patches.object, objects)
    if table.face is not None:
        wanted &= surfaces.face == table.face
        if not wanted.any():
            report.fault((*location, "face"), f"object {table.object!r} has no face {table.face!r}", "a face of a box")
    return np.flatnonzero(wanted)


def _counts(
    table: SurfaceSensor, edge_u: NDArray[np.float64], edge_v: NDArray[np.float64], frame: Frame
) -> tuple[int, int]:
    """Cells along the two edges of a patch."""
    if table.counts is not None:
        return table.counts
    spacing = frame.length(table.spacing or 1.0)
    n_u, n_v = (max(1, int(np.ceil(np.linalg.norm(edge) / spacing - 1e-9))) for edge in (edge_u, edge_v))
    return n_u, n_v


def _cell_centres(n_u: int, n_v: int) -> NDArray[np.float64]:
    """(n_u · n_v, 2) centres of equal cells of the unit square, u running first."""
    v, u = np.meshgrid((np.arange(n_v) + 0.5) / n_v, (np.arange(n_u) + 0.5) / n_u, indexing="ij")
    return np.stack([u.ravel(), v.ravel()], axis=1)


def _triangle_centres(n: int) -> NDArray[np.float64]:
    """(n², 2) centres of the equal triangles that cut each edge of the unit triangle in n."""
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="xy")
    upright = np.stack([i + 1.0 / 3.0, j + 1.0 / 3.0], axis=-1)[i + j < n]
    inverted = np.stack([i + 2.0 / 3.0, j + 2.0 / 3.0], axis=-1)[i + j < n - 1]
    return np.concatenate([upright, inverted]) / n
