"""Sensors that are spread over the surface of an object."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.pieces import Surfaces, select
from hradiosity.io.scene.report import Report, did_you_mean
from hradiosity.io.scene.schema_sensors import SurfaceSensor
from hradiosity.model.geometry import Patches
from hradiosity.model.scene import Sensor

_DEFAULT_OFFSET: Final = 1e-3
"""Distance from the surface [m]."""

MOST_POINTS: Final = 1_000_000
"""Most points of one sensor."""


def is_reasonable(count: float, location: Location, report: Report) -> bool:
    """Whether a sensor has no more than MOST_POINTS; if it has, that is reported."""
    if count <= MOST_POINTS:
        return True
    report.fault(location, f"{count:.3g} points", f"{MOST_POINTS} at most: fewer counts, or a larger spacing")
    return False


def surface_sensor(
    table: SurfaceSensor, location: Location, surfaces: Surfaces, frame: Frame, report: Report
) -> Sensor | None:
    """Points at the centres of equal cells of the object's patches; None and a fault when it has none."""
    chosen = _chosen_patches(table, location, surfaces, report)
    if not chosen.any():
        return None
    patches = select(surfaces.patches, chosen)
    counts = _counts(table, patches, frame)
    if not is_reasonable(float(counts.astype(np.float64).prod(axis=1).sum()), location, report):
        return None
    offset = _DEFAULT_OFFSET if table.offset is None else frame.length(table.offset)
    normal = patches.normal if table.side == "front" else -patches.normal
    owner, uv = _spread(patches.is_triangle, counts)
    on_surface = patches.origin[owner] + uv[:, :1] * patches.edge_u[owner] + uv[:, 1:] * patches.edge_v[owner]
    is_grid = len(patches) == 1 and not patches.is_triangle[0]
    grid = (int(counts[0, 1]), int(counts[0, 0])) if is_grid else None
    return Sensor(table.name, on_surface + offset * normal[owner], normal[owner], grid)


def _chosen_patches(table: SurfaceSensor, location: Location, surfaces: Surfaces, report: Report) -> NDArray[np.bool_]:
    """(n,) whether a patch is meant; none, and a fault, if the object or the face does not exist."""
    objects = np.array(
        [i for i, name in enumerate(surfaces.objects) if name == table.object or name.startswith(f"{table.object}/")]
    )
    if len(objects) == 0:
        report.fault((*location, "object"), f"no object {table.object!r}", did_you_mean(table.object, surfaces.objects))
        return np.zeros(len(surfaces.patches), dtype=bool)
    wanted: NDArray[np.bool_] = np.isin(surfaces.patches.object, objects)
    if table.face is not None:
        wanted &= surfaces.face == table.face
        if not wanted.any():
            report.fault((*location, "face"), f"object {table.object!r} has no face {table.face!r}", "a face of a box")
    return wanted


def _counts(table: SurfaceSensor, patches: Patches, frame: Frame) -> NDArray[np.int64]:
    """(n, 2) cells along the two edges of each patch; a triangle has as many along both."""
    if table.counts is not None:
        counts = np.tile(np.array(table.counts), (len(patches), 1))
    else:
        length = np.linalg.norm(np.stack([patches.edge_u, patches.edge_v], axis=1), axis=2)
        cells = np.ceil(length / frame.length(table.spacing or 1.0) - 1e-9)
        counts = np.clip(cells, 1, MOST_POINTS).astype(np.int64)
    return np.where(patches.is_triangle[:, None], counts.max(axis=1, keepdims=True), counts)


def _spread(is_triangle: NDArray[np.bool_], counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Patch and (u, v) of each point, patch by patch; patches that are cut alike are done at once."""
    kinds, kind_of = np.unique(np.column_stack([is_triangle, counts]), axis=0, return_inverse=True)
    owners, places = [], []
    for number, (triangular, n_u, n_v) in enumerate(kinds):
        centres = _triangle_centres(int(n_u)) if triangular else _cell_centres(int(n_u), int(n_v))
        alike = np.flatnonzero(kind_of.ravel() == number)
        owners.append(np.repeat(alike, len(centres)))
        places.append(np.tile(centres, (len(alike), 1)))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return owner[order], np.concatenate(places)[order]


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
