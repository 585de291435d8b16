"""Variants of a scene file: other paints and lamps in the same room."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.light import Shape, light_shape
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.materials import is_measured, read_reflectance
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema import SceneFile
from hradiosity.io.scene.schema_base import exactly_one
from hradiosity.io.scene.schema_light import AMOUNTS, LuminaireTable
from hradiosity.io.scene.schema_variants import FactorTable, VariantLight, VariantReflectance, VariantTable
from hradiosity.model.scene import Luminaire, Material, Scene, Variant
from hradiosity.model.spectrum import Bands


def read_variants(tables: SceneFile, scene: Scene, names: Names, report: Report) -> tuple[Variant, ...]:
    """The variants of a scene, which are good for use when nothing was reported."""
    seen: set[str] = set()
    variants = []
    for number, table in enumerate(tables.variant):
        location: Location = ("variant", number)
        if table.name.casefold() in seen:
            report.fault((*location, "name"), f"a second variant named {table.name!r}", "a name of its own")
        seen.add(table.name.casefold())
        if not table.materials and not table.luminaires:
            report.fault(location, "changes nothing", "[variant.materials] or [variant.luminaires]")
        variants.append(_variant(table, location, tables.luminaires, scene, names, report))
    return tuple(variants)


def _variant(
    table: VariantTable,
    location: Location,
    lamps: Mapping[str, LuminaireTable],
    scene: Scene,
    names: Names,
    report: Report,
) -> Variant:
    for name in table.materials:
        names.check_material(name, (*location, "materials", name), report)
    for name in table.luminaires:
        names.check_luminaire(name, (*location, "luminaires", name), report)
    materials = tuple(
        _painted(material, table.materials[material.name], (*location, "materials", material.name), scene, report)
        if material.name in table.materials
        else material
        for material in scene.materials
    )
    luminaires = list(scene.luminaires)
    for name in [name for name in table.luminaires if name in lamps]:
        kinds = [number for number, lamp in enumerate(luminaires) if is_of_table(lamp, name)]
        place: Location = (*location, "luminaires", name)
        lights = _lights(
            [luminaires[k] for k in kinds], table.luminaires[name], lamps[name], scene.bands, place, report
        )
        for number, light in zip(kinds, lights, strict=True):
            lamp = luminaires[number]
            luminaires[number] = replace(lamp, exitance=light) if len(lamp.exitance) else replace(lamp, intensity=light)
    return Variant(table.name, materials, tuple(luminaires))


def _painted(
    material: Material, form: VariantReflectance, location: Location, scene: Scene, report: Report
) -> Material:
    if isinstance(form, FactorTable):
        reflectance = form.factor * material.reflectance
        highest = float(reflectance.max())
        if highest > 1.0:
            worst = float(scene.bands.centre[int(np.argmax(reflectance))])
            most = highest / form.factor
            report.fault(location, f"reflectance {highest:g} at {worst:g} nm", f"a factor of {1.0 / most:.4g} at most")
        return replace(material, reflectance=reflectance)
    found = read_reflectance(form, scene.bands, location, report)
    return material if found is None else replace(material, reflectance=found, measured=is_measured(form))


def is_of_table(lamp: Luminaire, name: str) -> bool:
    """Whether a kind of light comes from a table of that name, see `read_lamps`."""
    return lamp.name == name or (lamp.name.startswith(f"{name} (") and lamp.name.endswith(")"))


def _lights(
    kinds: list[Luminaire],
    form: VariantLight,
    table: LuminaireTable,
    bands: Bands,
    location: Location,
    report: Report,
) -> list[NDArray[np.float64]]:
    """(n_bands,) exitance or intensity of each kind of light that comes from a table.

    Another spectrum has the amount that the table states: lumens or watts, and as it stands if it is absolute.
    """
    before = [lamp.emission for lamp in kinds]
    if isinstance(form, FactorTable):
        return [form.factor * light for light in before]
    # What is to be said about the scene's own spectrum was said when its luminaires were read.
    own = light_shape(table.spectrum, bands, location, Report(report.path, ""))
    other = light_shape(form, bands, location, report)
    key = exactly_one(table, *AMOUNTS)
    whole = _amount(other, key)
    if whole <= 0.0:
        unit = "that is visible" if key.startswith("luminous") else "in the scene's bands"
        report.fault(location, f"no power {unit}", "a spectrum with such power, as its luminaire states the amount")
        return before
    ratio = _amount(own, key) / whole
    total = max(float(own.power.sum()), np.finfo(float).tiny)
    return [other.power * (ratio * float(light.sum()) / total) for light in before]


def _amount(shape: Shape, key: str) -> float:
    """What a luminaire's stated amount is a multiple of."""
    if key == "absolute":
        return 1.0
    return shape.luminous if key.startswith("luminous") else float(shape.power.sum())
