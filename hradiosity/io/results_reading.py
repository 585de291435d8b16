"""Results on disk, read back for a window: mesh and light from ``solution.vtkhdf``, readings, what pictures chose."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.io.checkpoint import MESH_FILE
from hradiosity.io.drawn_scene import Cells, Drawn, Exposure, Lamps, Light, SensorPoints, Words
from hradiosity.io.results_drawing import DRAWING, VIEW_NUMBERS
from hradiosity.io.results_mesh import FORMAT
from hradiosity.io.results_tables import PLACE_COLUMNS
from hradiosity.model.scene import View
from hradiosity.model.spectrum import Bands

if TYPE_CHECKING:
    import h5py

READINGS_FILE, LUMINANCES_FILE = "readings.csv", "luminances.csv"
_SPECTRA_FILES = (("spectra.csv", "spectra_half_width.csv"), ("radiances.csv", "radiances_half_width.csv"))
"""Spectra and their half widths, of either; those of radiances are not written."""
PICTURES_FILE = Path("pictures", "pictures.json")
_RENDER_AGAIN = "render the scene again with this version"


def read_result(path: Path) -> Drawn:
    """A result.

    Parameters
    ----------
    path : Path
        Its folder, or the ``solution.vtkhdf`` in it.

    Raises
    ------
    SceneError
        When it is no result, of another version, or damaged.
    """
    file = path / MESH_FILE if path.is_dir() else path
    drawn = read_drawn(file)
    return Drawn(
        cells=drawn.cells,
        words=drawn.words,
        lamps=drawn.lamps,
        views=drawn.views,
        sensors=read_sensor_points(file.parent, len(drawn.words.bands)),
        light=drawn.light,
        exposure=_read_exposure(file.parent / PICTURES_FILE),
    )


def read_drawn(file: Path) -> Drawn:
    """All but sensors and exposure, from a mesh file alone.

    Raises
    ------
    SceneError
        When it is no such file, of another version, or damaged.
    """
    import h5py

    if not file.is_file():
        raise SceneError([Fault(str(file), "", "there is no such file", "the folder of a finished render has one")])
    try:
        with h5py.File(file, "r") as opened:
            return _drawn(opened, file)
    except (OSError, KeyError, ValueError, IndexError, RuntimeError, UnicodeDecodeError) as error:
        found = f"it is damaged or no result of this program ({error})"
        raise SceneError([Fault(str(file), "", found, _RENDER_AGAIN)]) from error


def _drawn(opened: h5py.File, file: Path) -> Drawn:
    group = opened["hradiosity"]
    if int(group.attrs["format"]) != FORMAT or DRAWING not in group:
        raise SceneError([Fault(str(file), "", "it is a result of another version", _RENDER_AGAIN)])
    words, lamps, views = _read_names(group)
    cells = _read_cells(opened, words)
    return Drawn(cells, words, lamps, views, no_sensors(), _read_light(opened, cells, words.bands))


def _read_names(group: h5py.Group) -> tuple[Words, Lamps, tuple[View, ...]]:
    own = group[DRAWING]
    bands = Bands(group["band_lower_nm"][()], group["band_upper_nm"][()])
    black = np.zeros((1, len(bands)))
    views = _array(own, "views", (None, VIEW_NUMBERS))
    words = Words(
        title=str(group.attrs["scene"]),
        bands=bands,
        materials=_names(group, "material_names"),
        reflectance=np.concatenate([_array(group, "material_reflectance", (None, len(bands))), black]),
        objects=_names(group, "object_names"),
        luminaires=_names(own, "luminaire_names"),
        exitance=np.concatenate([_array(own, "luminaire_exitance", (None, len(bands))), black]),
    )
    lamps = Lamps(
        position=_array(own, "point_position", (None, 3)),
        luminaire=own["point_luminaire"][()].astype(np.int32),
        flux=_array(own, "lamp_flux", (len(bands),)),
        sky=_array(own, "sky_radiance", (len(bands),)),
    )
    return words, lamps, tuple(_view(n, v) for n, v in zip(_names(own, "view_names"), views))


def _view(name: str, numbers: NDArray[np.float64]) -> View:
    position, direction, up = numbers[0:3], numbers[3:6], numbers[6:9]
    return View(name, position, direction, up, float(numbers[9]), int(numbers[10]), int(numbers[11]))


def _read_cells(opened: h5py.File, words: Words) -> Cells:
    mesh, own = opened["VTKHDF"], opened["hradiosity"][DRAWING]
    offsets = mesh["Polygons/Offsets"][()].astype(np.int64)
    points = _array(mesh, "Points", (None, 3))
    start, count = offsets[:-1], np.diff(offsets)
    if len(count) and (not np.isin(count, (3, 4)).all() or offsets[-1] != len(points) or offsets[0] != 0):
        raise ValueError("its polygons are not those of cells")
    corners = points[start[:, None] + np.minimum(np.arange(4), count[:, None] - 1)]
    n = len(corners)
    numbers = {name: _integers(mesh["CellData"], name, (n,)) for name in ("element", "material", "object", "side")}
    if n:
        _check_range(numbers["material"], len(words.reflectance), "materials")
        _check_range(numbers["object"], len(words.objects), "objects")
        _check_range(numbers["element"], len(opened["hradiosity/element_area_m2"]), "elements")
    luminaire = _integers(own, "cell_luminaire", (n,))
    _check_range(luminaire + 1, len(words.exitance), "luminaires")
    return Cells(
        corners=corners,
        is_triangle=count == 3,
        **numbers,
        patch=_integers(own, "cell_patch", (n,)),
        place=_integers(own, "cell_place", (n, 4, 2)),
        grid=_integers(own, "cell_grid", (n, 2)),
        width=_integers(own, "cell_width", (n,)),
        luminaire=luminaire,
    )


def _read_light(opened: h5py.File, cells: Cells, bands: Bands) -> Light | None:
    """Of each element that of one of its cells; None in a file without light."""
    data, group = opened["VTKHDF/CellData"], opened["hradiosity"]
    if "irradiance" not in data:
        return None
    n_elements = len(group["element_area_m2"])
    per_cell = _array(data, "irradiance", (len(cells), len(bands)), np.float32)
    irradiance = np.zeros((n_elements, len(bands)), np.float32)
    irradiance[cells.element] = per_cell * bands.width.astype(np.float32)
    return Light(
        irradiance=irradiance,
        exposed=_array(group, "element_exposed", (n_elements,)),
        space=_integers(group, "element_space", (n_elements,)),
        replicates=int(group.attrs["replicates"]),
    )


def no_sensors() -> SensorPoints:
    """Of a file without readings."""
    return SensorPoints((), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, np.bool_))


def read_sensor_points(folder: Path, n_bands: int) -> SensorPoints:
    """From the tables of a result, luminances after irradiances; none where it has none.

    Raises
    ------
    SceneError
        When a table is damaged.
    """
    tables = [_read_readings(folder / name) for name in (READINGS_FILE, LUMINANCES_FILE) if (folder / name).is_file()]
    if not tables:
        return no_sensors()
    count = [len(table.sensor) for table in tables]
    names = dict.fromkeys(name for table in tables for name in table.numbers)
    blank = [np.full(n, np.nan) for n in count]
    files = _SPECTRA_FILES if (folder / READINGS_FILE).is_file() else _SPECTRA_FILES[1:]

    @cache
    def spectra() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        value, half_width = (
            np.concatenate([_spectra(folder / pair[k], n, n_bands) for pair, n in zip(files, count)]) for k in (0, 1)
        )
        return value, half_width

    return SensorPoints(
        sensor=tuple(name for table in tables for name in table.sensor),
        index=np.concatenate([table.place[:, 0] for table in tables]).astype(np.int64),
        position=np.concatenate([table.place[:, 1:4] for table in tables]),
        normal=np.concatenate([table.place[:, 4:7] for table in tables]),
        looks=np.repeat([table.file.name == LUMINANCES_FILE for table in tables], count),
        numbers={name: np.concatenate([t.numbers.get(name, b) for t, b in zip(tables, blank)]) for name in names},
        spectra=spectra,
    )


@dataclass(frozen=True)
class _Readings:
    """One table: names of the sensors, (n, 7) index, place and direction, and the other columns."""

    file: Path
    sensor: list[str]
    place: NDArray[np.float64]
    numbers: dict[str, NDArray[np.float64]]


def _read_readings(file: Path) -> _Readings:
    header, rows = _table(file)
    if tuple(header[: len(PLACE_COLUMNS)]) != PLACE_COLUMNS:
        raise SceneError([Fault(str(file), "", "its columns are not those of readings", _RENDER_AGAIN)])
    values = _numbers(file, rows, 1, len(header))
    numbers = {name: values[:, column] for column, name in enumerate(header[1:]) if name not in PLACE_COLUMNS}
    return _Readings(file, [row[0] for row in rows], values[:, : len(PLACE_COLUMNS) - 1], numbers)


def _spectra(file: Path, n_rows: int, n_bands: int) -> NDArray[np.float64]:
    """(n_rows, n_bands); NaN where a result has no such file."""
    if not file.is_file():
        return np.full((n_rows, n_bands), np.nan)
    header, rows = _table(file)
    if len(rows) != n_rows or len(header) < n_bands:
        raise SceneError([Fault(str(file), "", "it does not belong to the readings beside it", _RENDER_AGAIN)])
    return _numbers(file, rows, len(header) - n_bands, len(header))


def _table(file: Path) -> tuple[list[str], list[list[str]]]:
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            lines = [line for line in csv.reader(stream) if line]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SceneError([Fault(str(file), "", f"it can't be read ({error})", _RENDER_AGAIN)]) from error
    if not lines or any(len(line) != len(lines[0]) for line in lines):
        raise SceneError([Fault(str(file), "", "it is damaged: its rows are not equally long", _RENDER_AGAIN)])
    return lines[0], lines[1:]


def _numbers(file: Path, rows: list[list[str]], first: int, last: int) -> NDArray[np.float64]:
    """(n_rows, last − first); NaN where a number stays blank."""
    try:
        values = [[float(word) if word else np.nan for word in row[first:last]] for row in rows]
    except ValueError as error:
        raise SceneError([Fault(str(file), "", f"it is damaged ({error})", _RENDER_AGAIN)]) from error
    return np.array(values, np.float64).reshape(len(rows), last - first)


def _read_exposure(file: Path) -> Exposure:
    """What the pictures chose; nothing where none were drawn or their record can't be read."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        exposure, scale = record["exposure"], record["false_color"]
        return Exposure(
            white_luminance=float(exposure["white_luminance_cd_m2"]),
            white=str(exposure.get("white", "as-measured")),
            quantity=str(scale["quantity"]),
            low=float(scale["low"]),
            high=float(scale["high"]),
            logarithmic=bool(scale["logarithmic"]),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return Exposure()


def _names(group: h5py.Group, name: str) -> tuple[str, ...]:
    return tuple(word.decode() for word in group[name][()])


def _array(group: h5py.Group, name: str, shape: tuple[int | None, ...], dtype: Any = np.float64) -> NDArray[Any]:
    """A dataset of that shape, None for any number; finite."""
    array = np.asarray(group[name][()], dtype)
    if array.ndim != len(shape) or any(e is not None and n != e for n, e in zip(array.shape, shape)):
        raise ValueError(f"{name} has the shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite")
    return array


def _integers(group: h5py.Group, name: str, shape: tuple[int, ...]) -> NDArray[np.int32]:
    array = np.asarray(group[name][()])
    if array.shape != shape or array.dtype.kind not in "iu":
        raise ValueError(f"{name} has the shape {array.shape}")
    return array.astype(np.int32)


def _check_range(number: NDArray[np.int32], count: int, what: str) -> None:
    if len(number) and not (number.min() >= 0 and number.max() < count):
        raise ValueError(f"it names {what} that it does not have")
