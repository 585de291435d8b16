"""Illuminance maps as files: a false-colour picture for eyes, a table and arrays for other programs."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.show.colormap import scale_colours
from hradiosity.show.files import write_bytes
from hradiosity.show.map_planes import MapPlane, map_planes
from hradiosity.show.scale_bar import Scale, automatic_scale
from hradiosity.show.surface_map import SurfaceMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_PANELS: Final = 12
"""Surfaces of an object that are drawn, the largest; all are in the table."""
_COLUMNS: Final = ("x_m", "y_m", "z_m", "normal_x", "normal_y", "normal_z", "area_m2", "illuminance_lx",
                   "lowest_lx", "highest_lx", "half_width_lx")  # fmt: skip
_PANEL_INCHES, _DPI = 4.6, 160


@dataclass(frozen=True, kw_only=True)
class MapScale:
    """How numbers become colours.

    logarithmic : equal ratios in equal steps
    ends : lowest and highest number [lx]; None: from the map
    """

    logarithmic: bool = False
    ends: tuple[float, float] | None = None


def write_map(
    folder: Path, stem: str, found: SurfaceMap, error: float, wanted: MapScale | None = None
) -> dict[str, Any]:
    """Write ``<stem>.png``, ``<stem>.csv`` (a line a leaf) and ``<stem>.npz`` (corners) into a folder.

    Parameters
    ----------
    folder : Path
        That exists.
    stem : str
        Of the names of the files; also the title.
    found : SurfaceMap
    error : float
        That the map was asked for.
    wanted : MapScale, optional

    Returns
    -------
    dict
        What ``run.json`` says of it.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    wanted = wanted or MapScale()
    mean, area = found.leaf_lux, found.leaf_area
    lit = np.isfinite(mean)
    average = float(np.average(mean[lit], weights=area[lit])) if lit.any() else 0.0
    scale = scale_of_map(mean[lit], wanted)
    corners = found.corner_lux[lit]
    numbers = {
        "cells": int(found.n_leaves),
        "points_read": 0 if found.reflected is None else found.reflected.n_read,
        "error_asked_for": error,
        "mean_lx": average,
        "lowest_lx": float(np.nanmin(corners)) if lit.any() else 0.0,
        "highest_lx": float(np.nanmax(corners)) if lit.any() else 0.0,
        "half_width_rms_lx": float(np.sqrt(np.average(found.leaf_half_width[lit] ** 2, weights=area[lit])))
        if lit.any()
        else 0.0,
    }
    write_bytes(folder / f"{stem}.csv", _table(found))
    write_bytes(folder / f"{stem}.npz", _arrays(found))
    write_bytes(folder / f"{stem}.png", _picture(found, scale, _title(stem, numbers)))
    files = [f"{stem}.{kind}" for kind in ("png", "csv", "npz")]
    return {"files": files, **numbers, "false_color": scale.record()}


def scale_of_map(lux: NDArray[np.float64], wanted: MapScale) -> Scale:
    """The scale of false colours."""
    if wanted.ends is not None:
        return Scale(*wanted.ends, wanted.logarithmic, "illuminance", "lx")
    return automatic_scale(lux, logarithmic=wanted.logarithmic, quantity="illuminance", unit="lx")


def _title(stem: str, numbers: dict[str, Any]) -> str:
    return (
        f"{stem}: mean {numbers['mean_lx']:.4g} lx, {numbers['lowest_lx']:.3g} to {numbers['highest_lx']:.4g} lx, "
        f"{numbers['cells']} cells\nrms error of the map {100 * numbers['error_asked_for']:.3g} % of the mean; "
        f"95 % intervals ± {numbers['half_width_rms_lx']:.2g} lx (rms)"
    )


def _table(found: SurfaceMap) -> bytes:
    """One line a leaf: its middle, where it faces, area, mean, lowest and highest corner, half width."""
    corners = found.corner_lux
    with np.errstate(invalid="ignore"):
        low, high = np.fmin.reduce(corners, axis=1), np.fmax.reduce(corners, axis=1)
    columns = [found.leaf_middle, found.leaf_normal, found.leaf_area, found.leaf_lux, low, high, found.leaf_half_width]
    out = io.StringIO()
    out.write(",".join(_COLUMNS) + "\n")
    formats = ["%.5f"] * 3 + ["%.6g"] * 8
    np.savetxt(out, np.column_stack(columns), fmt=formats, delimiter=",")
    return out.getvalue().encode()


def _arrays(found: SurfaceMap) -> bytes:
    """Corners (n, 4, 3) [m], illuminance there and half widths (n, 4) [lx]; NaN inside of things."""
    out = io.BytesIO()
    half_width = found.corner_half_width
    np.savez_compressed(out, corners=found.corners, corner_lux=found.corner_lux, corner_half_width=half_width)
    return out.getvalue()


def _picture(found: SurfaceMap, scale: Scale, title: str) -> bytes:
    """All flat surfaces of the map, each as seen from its front, with axes in metres and one legend."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm, Normalize
    from matplotlib.figure import Figure

    planes = map_planes(found)
    shown = planes[:MOST_PANELS]
    columns = max(1, min(len(shown), 3))
    heights = [_row_height(shown[first : first + columns]) for first in range(0, len(shown), columns)] or [1.0]
    size = (_PANEL_INCHES * columns + 1.4, sum(heights) + 0.8)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    norm = LogNorm(scale.low, scale.high) if scale.logarithmic else Normalize(scale.low, scale.high)
    colours = ScalarMappable(norm, ListedColormap(scale_colours()))
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    for number, plane in enumerate(shown):
        _panel(figure.add_subplot(grid[divmod(number, columns)]), plane, colours)
    left_out = len(planes) - len(shown)
    more = f"\n{left_out} smaller surfaces are in the table only" if left_out else ""
    figure.suptitle(title + more, fontsize=8)
    if figure.axes:
        beyond = bool((found.leaf_lux < scale.low).any()), bool((found.leaf_lux > scale.high).any())
        extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(beyond, "neither")
        figure.colorbar(colours, ax=figure.axes, label="illuminance, lx", extend=extend, aspect=30)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=_DPI, metadata={"Software": None})
    return out.getvalue()


def _row_height(planes: Sequence[MapPlane]) -> float:
    """Inches for a row of panels: those of the tallest, within bounds, and room for its words."""
    spans = [np.ptp(plane.points, axis=0) for plane in planes]
    ratio = max(float(span[1] / max(span[0], 1e-9)) for span in spans)
    return float(np.clip(ratio, 0.05, 1.6)) * _PANEL_INCHES + 0.9


def _panel(axes: Axes, plane: MapPlane, colours: Any) -> None:
    """One flat surface."""
    from matplotlib.tri import Triangulation

    mesh = Triangulation(plane.points[:, 0], plane.points[:, 1], plane.triangles)
    axes.tripcolor(mesh, plane.lux, shading="gouraud", cmap=colours.cmap, norm=colours.norm)
    axes.set_aspect("equal")
    axes.xaxis.set_inverted(plane.leftwards)
    axes.set_title(plane.name, fontsize=8)
    axes.set_xlabel(plane.axis_names[0], fontsize=8)
    axes.set_ylabel(plane.axis_names[1], fontsize=8)
    axes.tick_params(labelsize=7)
    axes.set_facecolor("0.8")
