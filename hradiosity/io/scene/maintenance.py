"""Maintained light: lamps with what they have left before maintenance, as one more variant of the scene."""

from __future__ import annotations

from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema import SceneFile
from hradiosity.io.scene.variants import is_of_table
from hradiosity.model.scene import Scene, Variant
from hradiosity.model.variants import MAINTAINED, Factor, make_variant


def maintained(tables: SceneFile, scene: Scene, report: Report) -> tuple[Variant, ...]:
    """The variant, if some lamp has a maintenance factor: its own, or that of the scene. The sky has none."""
    usual = tables.scene.maintenance_factor
    stated = {name: lamp.maintenance_factor or usual for name, lamp in tables.luminaires.items()}
    factors = {
        lamp.name: Factor(factor)
        for lamp in scene.luminaires
        for name, factor in stated.items()
        if factor is not None and is_of_table(lamp, name)
    }
    if not factors:
        return ()
    for number, variant in enumerate(tables.variant):
        if variant.name.casefold() == MAINTAINED:
            report.fault(
                ("variant", number, "name"), repr(variant.name), "another name: maintenance factors make one so"
            )
            return ()
    return (make_variant(scene, MAINTAINED, luminaires=factors),)
