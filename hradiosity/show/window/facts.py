"""What the panel tells of a picked element or sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Drawn, Light
from hradiosity.io.results_tables import half_width_column
from hradiosity.metrics.colorimetric import chromaticity, xyz
from hradiosity.metrics.derived import derived_numbers
from hradiosity.metrics.temperature import REASONS, colour_temperature
from hradiosity.model.spectrum import Bands
from hradiosity.show.channels import colours_of_paints
from hradiosity.show.window.outlines import element_levels
from hradiosity.show.window.picking import Picked

_SENSOR_NUMBERS: Final = (
    ("illuminance", "illuminance_lx", "lx", 1),
    ("x", "cie_x", "", 4),
    ("y", "cie_y", "", 4),
    ("CCT", "cct_k", "K", 0),
    ("Duv", "duv", "", 4),
    ("Ra", "ra", "", 1),
    ("melanopic EDI", "melanopic_edi_lx", "lx", 1),
)
"""Label, column of ``readings.csv``, unit and decimals."""
_LUMINANCE_NUMBERS: Final = (("luminance", "luminance_cd_m2", "cd/m²", 1), *_SENSOR_NUMBERS[1:6])
"""The same of ``luminances.csv``."""


@dataclass(frozen=True)
class Curve:
    """A spectrum in bands.

    name, unit : for the axis
    lower, upper : (n_bands,) edges of the bands [nm]
    value : (n_bands,)
    half_width : (n_bands,) of the 95 % interval, None where none is known
    other : (n_bands,) the same in a second result, None without one
    """

    name: str
    unit: str
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    value: NDArray[np.float64]
    half_width: NDArray[np.float64] | None = None
    other: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Facts:
    """title; (label, value) lines; curves, the first of which is plotted unless another is chosen."""

    title: str
    lines: tuple[tuple[str, str], ...]
    curves: tuple[Curve, ...]


def facts_of(drawn: Drawn, light: Light | None, picked: Picked) -> Facts:
    """All about what was picked."""
    if picked.kind == "sensor":
        return _sensor_facts(drawn, picked.number)
    return _cell_facts(drawn, light, picked.number, picked.point)


def facts_of_both(picked: Sequence[tuple[Drawn, Picked]]) -> Facts | None:
    """About what was picked in one result, or in two."""
    found = [facts_of(drawn, drawn.light, place) for drawn, place in picked]
    if not found:
        return None
    return found[0] if len(found) == 1 else joined_facts(found[0], found[1])


def joined_facts(first: Facts, second: Facts) -> Facts:
    """Of one place in two results: values that differ as "first → second", curves together."""
    other = dict(second.lines)
    lines = [(label, _changed(value, other.get(label, "–"))) for label, value in first.lines if label != "point"]
    pairs = zip(first.curves, second.curves)
    curves = [replace(a, other=b.value) if len(a.value) == len(b.value) else a for a, b in pairs]
    return Facts(first.title, tuple(lines), tuple(curves))


def _changed(first: str, second: str) -> str:
    """The value, or both where they differ; a unit that they share is told once."""
    if first == second:
        return first
    number, _, unit = first.rpartition(" ")
    shared = number and second.endswith(f" {unit}") and not unit[0].isdigit()
    return f"{number} → {second}" if shared else f"{first} → {second}"


def _cell_facts(drawn: Drawn, light: Light | None, cell: int, point: NDArray[np.float64]) -> Facts:
    cells, words = drawn.cells, drawn.words
    material = int(cells.material[cell])
    paint = words.materials[material] if material < len(words.materials) else "black back"
    bright = float(colours_of_paints(words.reflectance[material : material + 1], words.bands)[0, 1])
    lines = [
        ("object", f"{words.objects[cells.object[cell]]}, {'back' if cells.side[cell] else 'front'}"),
        ("material", f"{paint}, reflects {100.0 * bright:.3g} % of daylight"),
    ]
    lamp = int(cells.luminaire[cell])
    if lamp >= 0:
        lines.append(("luminaire", words.luminaires[lamp]))
    lines.append(("point", f"{point[0]:.3f}, {point[1]:.3f}, {point[2]:.3f} m"))
    reflectance = _curve("reflectance", "1", words.bands, words.reflectance[material])
    sent = words.exitance[lamp]
    if light is None:
        lines.append(("patch", f"{cells.patch[cell]}, {cells.area[cell]:.4g} m²"))
        shines = [_curve("exitance", "W m⁻² nm⁻¹", words.bands, sent / words.bands.width)] if lamp >= 0 else []
        return Facts(f"patch {cells.patch[cell]}", tuple(lines), (*shines, reflectance))
    element = int(cells.element[cell])
    those = cells.element == element
    level = int(element_levels(cells)[cell])
    nu, nv = (int(n) for n in cells.grid[cell])
    kind = "a group of faces" if len(np.unique(cells.patch[those])) > 1 else str(level)
    lines += [
        ("level", kind),
        ("patch", f"{cells.patch[cell]}, cut {nu} × {nv}"),
        ("area", f"{cells.area[those].sum():.4g} m²"),
    ]
    arrives = np.asarray(light.irradiance[element], np.float64)
    leaves = words.reflectance[material] * arrives + sent
    lines += light_lines(arrives, words.bands)
    seen = xyz(leaves / np.pi, words.bands)
    x, y = chromaticity(seen)
    lines += [("luminance", f"{seen[1]:.4g} cd/m²"), ("its x, y", _pair(x, y))]
    width = words.bands.width
    irradiance = _curve("irradiance", "W m⁻² nm⁻¹", words.bands, arrives / width)
    radiance = _curve("radiance", "W m⁻² sr⁻¹ nm⁻¹", words.bands, leaves / np.pi / width)
    return Facts(f"element {element}", tuple(lines), (irradiance, radiance, reflectance))


def light_lines(irradiance: NDArray[np.float64], bands: Bands) -> list[tuple[str, str]]:
    """Illuminance, chromaticity and colour temperature of an irradiance (n_bands,) [W m⁻² per band]."""
    total = xyz(irradiance, bands)
    x, y = chromaticity(total)
    numbers = {name: float(value[0]) for name, value in derived_numbers(irradiance[None], bands).items()}
    warm = colour_temperature(total[None])
    known = bool(np.isfinite(warm.cct[0]))
    return [
        ("illuminance", f"{total[1]:.4g} lx"),
        ("x, y", _pair(x, y)),
        ("CCT", f"{warm.cct[0]:.0f} K" if known else _no_temperature(float(warm.reason[0]))),
        ("Duv", f"{warm.duv[0]:.4f}" if known else "none"),
        ("melanopic EDI", f"{numbers['melanopic_edi_lx']:.4g} lx"),
    ]


def _no_temperature(reason: float) -> str:
    """Why a light has no correlated colour temperature."""
    told = REASONS[int(reason)] if np.isfinite(reason) else ""
    return f"none: {told}" if told else "none"


def _sensor_facts(drawn: Drawn, number: int) -> Facts:
    sensors = drawn.sensors
    position, normal = sensors.position[number], sensors.normal[number]
    title = f"{sensors.sensor[number]} [{sensors.index[number]}]"
    lines = [
        ("point", f"{position[0]:.3f}, {position[1]:.3f}, {position[2]:.3f} m"),
        ("direction", f"{normal[0]:.3f}, {normal[1]:.3f}, {normal[2]:.3f}"),
    ]
    if sensors.spectra is None:
        return Facts(title, tuple(lines), ())
    looks = bool(sensors.looks[number])
    reasons = sensors.numbers.get("cct_reason")
    for label, name, unit, digits in _LUMINANCE_NUMBERS if looks else _SENSOR_NUMBERS:
        told = _interval(sensors.numbers, number, name, half_width_column(name), unit, digits)
        if name == "cct_k" and told == "none" and reasons is not None:
            told = _no_temperature(float(reasons[number]))
        lines.append((label, told))
    value, half_width = (of_all[number] for of_all in sensors.spectra())
    bands = drawn.words.bands
    name, unit = ("radiance", "W m⁻² sr⁻¹ nm⁻¹") if looks else ("irradiance", "W m⁻² nm⁻¹")
    known = half_width if np.isfinite(half_width).all() else None
    return Facts(title, tuple(lines), (Curve(name, unit, bands.lower, bands.upper, value, known),))


def _curve(name: str, unit: str, bands: Bands, value: NDArray[np.float64]) -> Curve:
    return Curve(name, unit, bands.lower, bands.upper, value)


def _pair(x: float, y: float) -> str:
    return f"{x:.4f}, {y:.4f}" if np.isfinite([x, y]).all() else "none"


def _interval(
    table: Mapping[str, NDArray[np.float64]], number: int, name: str, width: str, unit: str, digits: int
) -> str:
    """Value ± half width; blank fields of the table are numbers that are not defined."""
    if name not in table or not np.isfinite(table[name][number]):
        return "none"
    half = table[width][number] if width in table else np.nan
    told = f" ± {half:.{digits}f}" if np.isfinite(half) else ""
    return f"{table[name][number]:.{digits}f}{told} {unit}".rstrip()
