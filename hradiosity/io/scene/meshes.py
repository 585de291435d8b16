"""Meshes that a scene file names: placed, and their names mapped to materials and luminaires of the scene."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import SceneError
from hradiosity.io.meshes import MeshFile, MeshPart, TextureColour, read_mesh
from hradiosity.io.scene.frame import Frame, rotation
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.pieces import Piece
from hradiosity.io.scene.report import Report, did_you_mean
from hradiosity.io.scene.schema_light import ReflectanceColour
from hradiosity.io.scene.schema_surfaces import MeshTable
from hradiosity.metrics.upsampling import Upsampling
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.meshing import merge_triangles
from hradiosity.model.solids import find_solids


def mesh_piece(mesh: MeshTable, location: Location, frame: Frame, names: Names, report: Report) -> Piece | None:
    """The patches of a mesh file; None, and a fault, if it can't be read."""
    _check_names(mesh, location, names, report)
    content = _read(mesh, location, report)
    if content is None:
        return None
    parts = content.parts
    _check_keys(mesh.materials, parts, (*location, "materials"), report)
    _check_keys(mesh.luminaires, parts, (*location, "luminaires"), report)
    _check_mapped(mesh, parts, location, report)
    prefix = mesh.name or Path(mesh.file).stem
    guessed = _textured(mesh, parts, prefix, location, names, report)
    part_objects = [f"{prefix}/{part.name}" if part.name else prefix for part in parts]
    objects = tuple(dict.fromkeys(part_objects))
    number = {name: i for i, name in enumerate(objects)}
    patches, part_of = _patches(mesh, parts, frame, [number[name] for name in part_objects])
    material = np.array([_material(mesh, part, guessed, names) for part in parts])
    luminaire = np.array([names.luminaire_index(_mapped(mesh.luminaires, part)) for part in parts])
    patches.material[:] = material[part_of]
    patches.solid[:] = find_solids(patches.corners(), patches.is_triangle, patches.object).solid
    locations = (location,) * len(objects)
    return Piece(objects, locations, patches, luminaire[part_of].astype(np.int32), np.full(len(patches), ""))


def _read(mesh: MeshTable, location: Location, report: Report) -> MeshFile | None:
    path = report.find_file(mesh.file, (*location, "file"))
    if path is None:
        return None
    try:
        content = read_mesh(path, mesh.unit, mesh.up, textures=mesh.upsample is not None)
    except SceneError as error:
        report.adopt(error, (*location, "file"))
        return None
    report.notes.extend(content.notes)
    return content


def _patches(
    mesh: MeshTable, parts: Sequence[MeshPart], frame: Frame, part_object: Sequence[int]
) -> tuple[Patches, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Placed patches with their objects and surfaces (material and solid still to fill), and the part of each."""
    cuts = [merge_triangles(part.vertices, part.triangles) for part in parts]
    count = [len(cut.origin) for cut in cuts]
    part_of = np.repeat(np.arange(len(parts)), count)
    first_surface = np.cumsum([0, *(int(cut.surface.max(initial=NONE)) + 1 for cut in cuts)])[:-1]
    surface = np.concatenate([cut.surface for cut in cuts]) + first_surface[part_of]
    turn = mesh.scale * rotation((0.0, 0.0, 1.0), mesh.rotation_deg)
    n = len(part_of)
    patches = Patches(
        np.concatenate([cut.origin for cut in cuts]) @ turn.T + frame.points(mesh.position),
        np.concatenate([cut.edge_u for cut in cuts]) @ turn.T,
        np.concatenate([cut.edge_v for cut in cuts]) @ turn.T,
        np.concatenate([cut.is_triangle for cut in cuts]),
        np.zeros(n, dtype=np.int32),
        np.asarray(part_object, dtype=np.int32)[part_of],
        surface.astype(np.int32),
        np.full(n, NONE, dtype=np.int32),
    )
    return patches, part_of


def _mapped(entries: Mapping[str, str], part: MeshPart) -> str | None:
    """What a part is mapped to, its object's entry before its material's."""
    return entries.get(part.name) or entries.get(part.material)


def _material(mesh: MeshTable, part: MeshPart, guessed: Mapping[str, int], names: Names) -> int:
    """Number of a part's material: what it is mapped to, else the guess from its texture, else that of all the rest."""
    mapped = _mapped(mesh.materials, part)
    if mapped is None and part.texture is not None and _paint(part) in guessed:
        return guessed[_paint(part)]
    return names.material_index(mapped or mesh.material)


def _paint(part: MeshPart) -> str:
    """Name of a part's material, or of the part where the file names none."""
    return part.material or part.name


def _check_names(mesh: MeshTable, location: Location, names: Names, report: Report) -> None:
    """Report entries that name no material or luminaire of the scene."""
    names.check_material(mesh.material, (*location, "material"), report)
    for key, material in mesh.materials.items():
        names.check_material(material, (*location, "materials", key), report)
    for key, luminaire in mesh.luminaires.items():
        names.check_luminaire(luminaire, (*location, "luminaires", key), report)


def _check_keys(entries: Iterable[str], parts: Sequence[MeshPart], location: Location, report: Report) -> None:
    """Report entries for names that the file does not have."""
    known = {name for part in parts for name in (part.name, part.material) if name}
    for key in entries:
        if key not in known:
            report.fault((*location, key), f"the file has no object or material {key!r}", did_you_mean(key, known))


def _check_mapped(mesh: MeshTable, parts: Sequence[MeshPart], location: Location, report: Report) -> None:
    """Report names of the file that no entry and no default covers."""
    if mesh.material is not None:
        return
    unmapped = [part for part in parts if _mapped(mesh.materials, part) is None]
    bare = dict.fromkeys(_paint(part) for part in unmapped if part.texture is None or mesh.upsample is None)
    if bare:
        report.fault(
            location,
            f"{mesh.file} has {', '.join(repr(name) for name in bare)} without a material of the scene",
            "an entry of `materials` for each, or `material` for all the rest",
        )


def _textured(
    mesh: MeshTable, parts: Sequence[MeshPart], prefix: str, location: Location, names: Names, report: Report
) -> dict[str, int]:
    """Numbers of the materials that are guessed from pictures, by name.

    A picture is refused, unless the user has said what paint stands for it, or how a spectrum is guessed from it.
    """
    guessed: dict[str, int] = {}
    for name in dict.fromkeys(_paint(part) for part in parts if part.texture):
        bare = [part for part in parts if _paint(part) == name and _mapped(mesh.materials, part) is None]
        texture = next((part.texture for part in bare if part.texture), None)
        if texture is None:
            report.warn(location, f"{name!r} has a texture in {mesh.file}; one reflectance stands for it")
        elif mesh.upsample is None:
            report.fault(
                location,
                f"{name!r} in {mesh.file} has a texture, which is not simulated by this version",
                f"an entry {name!r} = … of `materials`: the one paint that stands for it; or `upsample`: the mean of "
                "the picture, with a guessed spectrum",
            )
        elif texture.mean is None:
            found = f"texture {texture.name!r} of {name!r} in {mesh.file}: {texture.fault}"
            report.fault(location, found, f"a PNG or JPEG file, or an entry {name!r} = … of `materials`")
        else:
            guessed[name] = _guess(f"{prefix}/{name}", mesh.upsample, texture, location, names, report)
    return guessed


def _guess(
    name: str, method: Upsampling, texture: TextureColour, location: Location, names: Names, report: Report
) -> int:
    """Number of the material that stands for a picture."""
    mean = np.array(texture.mean)
    if not ((mean >= 0.0) & (mean <= 1.0)).all():
        found = f"the mean of texture {texture.name!r} times its factor is {_triple(mean)}"
        report.fault(location, found, "0 to 1 in each of red, green and blue")
        return 0
    report.warn(
        location,
        f"{name!r} takes the mean of texture {texture.name!r}, {_triple(mean)} in linear sRGB, plain over the whole "
        f"picture; its spectrum is guessed from that colour ({method}), not measured",
    )
    return names.guess(name, ReflectanceColour(rgb=mean.tolist(), upsample=method))


def _triple(colour: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.3f}" for value in colour)
