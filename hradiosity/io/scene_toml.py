"""Reads a scene: a folder with ``scene.toml``, or the file."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hradiosity.errors import Fault, SceneError
from hradiosity.io.scene.actions import read_actions
from hradiosity.io.scene.checks import check_scene
from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.geometry import read_surfaces
from hradiosity.io.scene.lamps import read_lamps, read_sky
from hradiosity.io.scene.maintenance import maintained
from hradiosity.io.scene.materials import read_materials
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema import BandsTable, EdgeBands, RangeBands, SceneFile
from hradiosity.io.scene.schema_base import Table
from hradiosity.io.scene.sensors import read_sensors, read_views
from hradiosity.io.scene.validate import parse_toml, validate
from hradiosity.io.scene.variants import read_variants
from hradiosity.model.scene import Scene
from hradiosity.model.spectrum import Bands

SCENE_FILE = "scene.toml"


def load_scene(path: str | Path, *, bands: Bands | None = None) -> Scene:
    """Read and check a scene.

    Parameters
    ----------
    path : path of a folder with ``scene.toml``, or of the file
        The files that it names are looked for beside it.
    bands : Bands, optional
        In place of those that the scene names.

    Returns
    -------
    Scene
        In metres with z up; what was assumed or mended stands in its ``notes``.

    Raises
    ------
    SceneError
        With every fault that was found, each with its line.
    """
    file = scene_file(Path(path))
    text, raw = parse_toml(file)
    report = Report(file, text)
    tables = validate(raw, report)
    frame = Frame(tables.scene.unit, tables.scene.up)
    scene = _build(tables, raw, frame, bands or _bands(tables.scene.bands, report), report)
    if not report.faults:
        check_scene(scene, frame, report)
    report.raise_faults()
    return replace(scene, notes=tuple(report.notes))


def scene_file(path: Path) -> Path:
    """The scene file itself, of a folder or a file; raises `SceneError` when there is none."""
    if path.is_dir():
        file = path / SCENE_FILE
        if not file.is_file():
            others = ", ".join(sorted(other.name for other in path.glob("*.toml")))
            hint = f"name the file: it has {others}" if others else "a folder made by `hradiosity new room` has one"
            raise SceneError([Fault(str(path), "", f"the folder has no {SCENE_FILE}", hint)])
        return file
    if not path.exists():
        raise SceneError([Fault(str(path), "", "no such file or folder", f"a folder with {SCENE_FILE}, or the file")])
    return path


def _build(tables: SceneFile, raw: Mapping[str, Any], frame: Frame, bands: Bands, report: Report) -> Scene:
    """The scene from valid tables; what is wrong beyond them goes to the report."""
    names = Names(_names(raw, "materials"), _names(raw, "luminaires"))
    before = len(report.faults)
    surfaces = read_surfaces(tables, frame, names, report)
    kinds = ("rectangle", "polygon", "box", "mesh")
    is_whole = all(_is_whole(raw.get(kind, []), getattr(tables, kind)) for kind in kinds)
    geometry_failed = len(report.faults) > before or not is_whole
    luminaires, emitters = read_lamps(tables.luminaires, tables.point_source, surfaces, names, frame, bands, report)
    scene = Scene(
        tables.scene.title or report.path.resolve().parent.name,
        report.path,
        bands,
        surfaces.patches,
        read_materials(tables.materials, names, bands, report),
        luminaires,
        emitters,
        (),
        read_views(tables.view, frame, report),
        surfaces.objects,
        read_sky(tables.sky, bands, report),
    )
    sensors = read_sensors(tables.sensor, None if geometry_failed else surfaces, scene, frame, report)
    scene = replace(scene, sensors=sensors, actions=read_actions(tables.actions, bands, report))
    variants = read_variants(tables, scene, names, report)
    return replace(scene, variants=(*variants, *maintained(tables, scene, report)))


def _is_whole(written: object, checked: Sequence[Table]) -> bool:
    """Whether no entry of a list was left out because of its faults."""
    return isinstance(written, list) and len(written) == len(checked)


def _names(raw: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """Names of all materials or luminaires, of faulty ones too."""
    entries = raw.get(key, {})
    return tuple(entries) if isinstance(entries, dict) else ()


def _bands(table: BandsTable, report: Report) -> Bands:
    try:
        if isinstance(table, EdgeBands):
            return Bands.explicit(table.edges)
        if isinstance(table, RangeBands):
            return Bands.explicit(table.ranges)
        return Bands.uniform(table.first, table.last, table.step)
    except ValueError as error:
        report.fault(("scene", "bands"), str(error), "for example { first = 380, last = 780, step = 5 }")
        return Bands.uniform()
