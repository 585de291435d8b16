"""A page that shows a scene or a result in a browser: one file, without a server, without anything from elsewhere."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Light
from hradiosity.metrics.colorimetric import chromaticity, xyz
from hradiosity.metrics.temperature import colour_temperature
from hradiosity.model.spectrum import Bands
from hradiosity.show.colormap import scale_colours as map_colours
from hradiosity.show.exposure import to_bytes
from hradiosity.show.window.colours import LightValues
from hradiosity.show.window.look import MODES, NO_LINES, Look, Quantity
from hradiosity.show.window.marks import lamp_lines, scene_size, sensor_lines, sensor_marks
from hradiosity.show.window.navigation import Pose, overview
from hradiosity.show.window.outlines import edge_flags, element_levels
from hradiosity.show.window.subject import Subject
from hradiosity.show.window.vertices import swollen

MOST_SPECTRA: Final = 30_000
"""Elements whose spectra go into the page; of more, it would take tens of megabytes."""
_FOLDER: Final = Path(__file__).parent
_DATA, _SCRIPT = "/*DATA*/", "/*SCRIPT*/"


def page_bytes(subject: Subject, look: Look, pose: Pose, title: str) -> bytes:
    """The page, UTF-8.

    Parameters
    ----------
    subject : Subject
    look : Look
        To start with.
    pose : Pose
        To start from.
    title : str
    """
    data = json.dumps(page_data(subject, look, pose, title), ensure_ascii=False, allow_nan=False)
    text = (_FOLDER / "page.html").read_text(encoding="utf-8")
    script = (_FOLDER / "page.js").read_text(encoding="utf-8")
    # Names come from the user's files: none of them may end the script that holds them.
    return text.replace(_SCRIPT, script).replace(_DATA, data.replace("<", "\\u003c")).encode()


def page_data(subject: Subject, look: Look, pose: Pose, title: str) -> dict[str, Any]:
    """What the page's script reads: arrays packed, names and numbers plain."""
    drawn, cells, values = subject.drawn, subject.cells, subject.values
    size = scene_size(cells)
    lamps = lamp_lines(drawn, size)
    bright = Look(stops=look.stops)
    modes = [mode for mode in MODES if mode not in ("wireframe", "false-color")]
    colours = {mode: packed(subject.paint(Look(mode=mode, stops=look.stops)).colours) for mode in modes}
    whole = overview(*cells.bounds, 1.6)
    data: dict[str, Any] = {
        "title": title,
        "solved": values is not None,
        "mode": look.mode,
        "lines": look.lines != NO_LINES,
        "count": len(cells),
        "size": size,
        "pose": _pose(pose),
        "overview": _pose(whole),
        "position": packed(swollen(cells).astype(np.float32)),
        "triangle": packed(cells.is_triangle.astype(np.uint8)),
        "outline": packed(edge_flags(cells, 0)),
        "colours": colours,
        "exposure": f"white is {subject.luminance(bright):.4g} cd/m²" if values is not None else "paints, not solved",
        "material": packed(cells.material.astype(np.int32)),
        "object": packed(cells.object.astype(np.int32)),
        "element": packed(cells.element.astype(np.int32)),
        "level": packed(element_levels(cells).astype(np.int32)),
        "area": packed(_element_areas(subject).astype(np.float32)),
        "materials": [*drawn.words.materials, "black back"],
        "objects": list(drawn.words.objects),
        "map": packed(to_bytes(map_colours())),
        "scales": _scales(subject, look),
        "sensors": _sensors(subject),
        "lamps": packed(np.stack([lamps.start, lamps.end], axis=1).astype(np.float32)),
        "bands": {"lower": drawn.words.bands.lower.tolist(), "upper": drawn.words.bands.upper.tolist()},
    }
    if values is not None:
        data["values"] = _values(values)
        data["elements"] = _elements(values.light, drawn.words.bands)
    return data


def packed(array: NDArray[Any]) -> str:
    """Little-endian bytes, deflated, in base64."""
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    return base64.b64encode(zlib.compress(little.tobytes(), 6)).decode()


def _pose(pose: Pose) -> dict[str, Any]:
    return {
        "position": pose.position.tolist(),
        "yaw": pose.yaw,
        "pitch": pose.pitch,
        "distance": pose.distance,
        "angle": pose.angle,
    }


def _element_areas(subject: Subject) -> NDArray[np.float64]:
    """(n_elements,) [m²]."""
    areas: NDArray[np.float64] = np.bincount(subject.cells.element, subject.cells.area).astype(np.float64)
    return areas


def _scales(subject: Subject, look: Look) -> dict[str, Any]:
    """Of the false colours, by quantity, as linear and logarithmic ones."""
    if subject.values is None:
        return {}
    quantities: tuple[Quantity, ...] = ("illuminance", "luminance")
    found = {}
    for quantity in quantities:
        for logarithmic in (False, True):
            scale = subject.scale(Look(quantity=quantity, logarithmic=logarithmic, stops=look.stops))
            name = f"{quantity} {'log' if logarithmic else 'linear'}"
            found[name] = {
                "low": scale.low,
                "high": scale.high,
                "log": logarithmic,
                "unit": scale.unit,
                "ticks": scale.ticks().tolist(),
            }
    return found


def _values(values: LightValues) -> dict[str, str]:
    """Numbers at the corners, for false colours."""
    smooth = values.smooth
    return {
        "illuminance": packed(smooth.illuminance.astype(np.float32)),
        "luminance": packed(smooth.xyz[..., 1].astype(np.float32)),
        "cell illuminance": packed(values.flat.illuminance.astype(np.float32)),
        "cell luminance": packed(values.flat.xyz[:, 1].astype(np.float32)),
    }


def _elements(light: Light, bands: Bands) -> dict[str, Any]:
    """Chromaticity and colour temperature of what arrives, and spectra as shares of 65535 of the largest number."""
    power = np.asarray(light.irradiance, np.float64)
    tristimulus = xyz(power, bands)
    found: dict[str, Any] = {
        "xy": packed(np.nan_to_num(chromaticity(tristimulus)).astype(np.float32)),
        "cct": packed(np.nan_to_num(colour_temperature(tristimulus).cct).astype(np.float32)),
    }
    if len(power) <= MOST_SPECTRA:
        found.update(_packed_spectra(power / bands.width))
    return found


def _packed_spectra(spectra: NDArray[np.float64]) -> dict[str, str]:
    top = np.maximum(spectra.max(axis=1, initial=0.0), 1e-30)
    shares = np.rint(spectra / top[:, None] * 65535.0).astype(np.uint16)
    return {"top": packed(top.astype(np.float32)), "spectra": packed(shares)}


def _sensors(subject: Subject) -> dict[str, Any]:
    sensors = subject.drawn.sensors
    lines = sensor_lines(subject.drawn)
    found: dict[str, Any] = {
        "names": [f"{name} [{index}]" for name, index in zip(sensors.sensor, sensors.index, strict=True)],
        "position": packed(sensors.position.astype(np.float32)),
        "marks": packed(sensor_marks(subject.drawn).astype(np.float32)),
        "looks": packed(sensors.looks.astype(np.float32)),
        "lines": packed(np.stack([lines.start, lines.end], axis=1).astype(np.float32)),
    }
    for key, column in _SENSOR_COLUMNS:
        if column in sensors.numbers:
            found[key] = packed(np.nan_to_num(sensors.numbers[column]).astype(np.float32))
    if sensors.spectra is not None and len(sensors) <= MOST_SPECTRA:
        value, half = sensors.spectra()
        found |= _packed_spectra(value) | {"half": packed(np.nan_to_num(half).astype(np.float32))}
    return found


_SENSOR_COLUMNS: Final = (
    ("lux", "illuminance_lx"),
    ("lux half", "illuminance_half_width_lx"),
    ("luminance", "luminance_cd_m2"),
    ("luminance half", "luminance_half_width_cd_m2"),
    ("x", "cie_x"),
    ("y", "cie_y"),
    ("cct", "cct_k"),
    ("cct half", "cct_half_width_k"),
)
