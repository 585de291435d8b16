"""Luminaires, point sources and sky of a scene file: power in each band, and which patch gives it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.light import Shape, light_shape
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.names import Names
from hradiosity.io.scene.pieces import Surfaces
from hradiosity.io.scene.report import Report
from hradiosity.io.scene.schema_base import exactly_one
from hradiosity.io.scene.schema_light import AMOUNTS, LuminaireTable, SkyTable
from hradiosity.io.scene.schema_surfaces import PointSourceTable
from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Emitters, Luminaire, Sky
from hradiosity.model.spectrum import Bands

_FLUXES: Final = ("luminous_flux_lm", "radiant_flux_W")
_SAME_AREA: Final = 1e-9


@dataclass(frozen=True)
class _Lamp:
    """A table of luminaires with its spectrum on the bands."""

    name: str
    table: LuminaireTable
    shape: Shape


@dataclass(frozen=True)
class _Use:
    """Patches of one object that share one luminaire, or a point source.

    lamp : index of the luminaire's table
    patches : (n,) patch numbers; empty for a point source
    area : emitting area, one side [m²], above 0 since faces without area are gone; 0 for a point source
    position : (3,) of a point source
    """

    lamp: int
    name: str
    patches: NDArray[np.int64]
    area: float
    position: NDArray[np.float64]


def read_lamps(
    tables: Mapping[str, LuminaireTable],
    points: Sequence[PointSourceTable],
    surfaces: Surfaces,
    names: Names,
    frame: Frame,
    bands: Bands,
    report: Report,
) -> tuple[tuple[Luminaire, ...], Emitters]:
    """All kinds of light, and the patches and points that give it.

    A luminaire whose flux is shared over objects of different areas becomes one kind of light for each area.
    """
    lamps = [
        _Lamp(name, tables[name], light_shape(tables[name].spectrum, bands, ("luminaires", name, "spectrum"), report))
        if name in tables
        else None
        for name in names.luminaires
    ]
    uses = [*_surface_uses(surfaces), *_point_uses(points, names, frame, report)]
    _report_unused(names, uses, report)
    kinds: list[tuple[_Use, Luminaire]] = []
    patch, position, kind_of = [], [], []
    middle = surfaces.patches.centroid
    for use in uses:
        lamp = lamps[use.lamp]
        if lamp is None:
            continue
        number = next((i for i, (other, _) in enumerate(kinds) if _is_same_light(use, other, lamp)), len(kinds))
        if number == len(kinds):
            kinds.append((use, _luminaire(lamp, use, report)))
        is_point = len(use.patches) == 0
        patch.append(np.array([NONE]) if is_point else use.patches)
        position.append(use.position[None] if is_point else middle[use.patches])
        kind_of.append(np.full(len(patch[-1]), number))
    emitters = Emitters(
        np.concatenate([np.zeros(0), *patch]).astype(np.int32),
        np.concatenate([np.zeros((0, 3)), *position]),
        np.concatenate([np.zeros(0), *kind_of]).astype(np.int32),
    )
    return _with_own_names([luminaire for _, luminaire in kinds], [use for use, _ in kinds]), emitters


def _surface_uses(surfaces: Surfaces) -> list[_Use]:
    """The emitting patches by object and luminaire, in the order of the patches."""
    emitting = np.flatnonzero(surfaces.luminaire != NONE)
    pairs = np.stack([surfaces.patches.object[emitting], surfaces.luminaire[emitting]], axis=1)
    unique, group = np.unique(pairs, axis=0, return_inverse=True)
    area = np.bincount(group.ravel(), surfaces.patches.area[emitting], minlength=len(unique))
    return [
        _Use(int(lamp), surfaces.objects[owner], emitting[group.ravel() == i], float(area[i]), np.zeros(3))
        for i, (owner, lamp) in enumerate(unique)
    ]


def _point_uses(points: Sequence[PointSourceTable], names: Names, frame: Frame, report: Report) -> list[_Use]:
    uses, seen = [], set()
    for i, point in enumerate(points):
        names.check_luminaire(point.luminaire, ("point_source", i, "luminaire"), report)
        name = point.name or f"point_source-{i + 1}"
        if name in seen:
            report.fault(("point_source", i), f"a second point source named {name!r}", "a name of its own")
        seen.add(name)
        lamp = names.luminaire_index(point.luminaire)
        if lamp != NONE:
            uses.append(_Use(lamp, name, np.zeros(0, dtype=np.int64), 0.0, frame.points(point.position)))
    return uses


def _report_unused(names: Names, uses: Sequence[_Use], report: Report) -> None:
    used = {use.lamp for use in uses}
    for number, name in enumerate(names.luminaires):
        if number not in used:
            report.warn(("luminaires", name), "no surface and no point source uses this luminaire: it gives no light")


def _is_same_light(use: _Use, other: _Use, lamp: _Lamp) -> bool:
    """Whether two uses of luminaires have the same power per area, or the same intensity."""
    if use.lamp != other.lamp or (use.area == 0.0) != (other.area == 0.0):
        return False
    return exactly_one(lamp.table, *AMOUNTS) not in _FLUXES or abs(use.area - other.area) <= _SAME_AREA * use.area


def _luminaire(lamp: _Lamp, use: _Use, report: Report) -> Luminaire:
    """The light of one use; faults in its amount go to the report."""
    location: Location = ("luminaires", lamp.name)
    nothing = np.zeros(0)
    sides = 2 if lamp.table.sides == "both" else 1
    key = exactly_one(lamp.table, *AMOUNTS)
    amount = float(getattr(lamp.table, key))
    is_luminous = key.startswith("luminous")
    if is_luminous and lamp.shape.luminous <= 0.0:
        report.fault(
            (*location, key),
            f"the spectrum has no power that is visible, so no amount of it gives {amount:g} lm",
            "a spectrum with power between 360 and 830 nm, or a radiant flux",
        )
        return Luminaire(lamp.name, lamp.shape.power, nothing, sides == 2)
    whole = lamp.shape.luminous if is_luminous else float(lamp.shape.power.sum())
    if whole <= 0.0:
        report.fault((*location, "spectrum"), "no power in any band", "a spectrum with power in the scene's bands")
        return Luminaire(lamp.name, lamp.shape.power, nothing, sides == 2)
    if len(use.patches) == 0:
        return Luminaire(lamp.name, nothing, _intensity(lamp, use, key, amount, whole, report))
    if key == "absolute":
        return Luminaire(lamp.name, lamp.shape.power, nothing, sides == 2)
    if key in _FLUXES:
        unit = "lm" if is_luminous else "W"
        report.inform((*location, key), f"{amount:g} {unit} from {sides * use.area:.4g} m² of object {use.name!r}")
        amount /= sides * use.area
    return Luminaire(lamp.name, lamp.shape.power * (amount / whole), nothing, sides == 2)


def _intensity(lamp: _Lamp, use: _Use, key: str, amount: float, whole: float, report: Report) -> NDArray[np.float64]:
    """Radiant intensity of a point source, the same in all directions [W sr⁻¹ per band]."""
    if key == "absolute":
        return lamp.shape.power
    if key not in _FLUXES:
        found = f"point source {use.name!r} has no area"
        report.fault(("luminaires", lamp.name, key), found, "a flux, or absolute = true")
    return lamp.shape.power * (amount / (whole * 4.0 * np.pi))


def _with_own_names(luminaires: list[Luminaire], uses: list[_Use]) -> tuple[Luminaire, ...]:
    """Names told apart by the first object where a table became several kinds of light."""
    names = [luminaire.name for luminaire in luminaires]
    return tuple(
        Luminaire(
            f"{kind.name} ({use.name})" if names.count(kind.name) > 1 else kind.name,
            kind.exitance,
            kind.intensity,
            kind.two_sided,
        )
        for kind, use in zip(luminaires, uses, strict=True)
    )


def read_sky(table: SkyTable | None, bands: Bands, report: Report) -> Sky | None:
    """The sky's radiance in each band; None without a sky."""
    if table is None:
        return None
    shape = light_shape(table.spectrum, bands, ("sky", "spectrum"), report)
    if shape.luminous <= 0.0:
        report.fault(("sky", "spectrum"), "no power that is visible", "a spectrum with power between 360 and 830 nm")
        return Sky(shape.power)
    # Illuminance of a plane under a uniform sky is π sr times its luminance.
    luminance = table.luminance_cd_m2 if table.luminance_cd_m2 is not None else (table.illuminance_lx or 0.0) / np.pi
    return Sky(shape.power * (luminance / shape.luminous))
