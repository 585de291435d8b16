"""Variants of a scene: the same geometry in other paints and lights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.model.scene import Luminaire, Material, Scene, Variant
from hradiosity.model.spectrum import Spectrum, band_mean

MAINTAINED = "maintained"
"""Name of the variant with the light that lamps have left before maintenance."""
_SAME_IN_ALL = ("bands", "patches", "emitters", "sensors", "sky")


@dataclass(frozen=True)
class Factor:
    """So many times what the scene has, in every band."""

    value: float


def make_variant(
    scene: Scene,
    name: str,
    *,
    materials: Mapping[str, Factor | Spectrum | ArrayLike] | None = None,
    luminaires: Mapping[str, Factor | ArrayLike] | None = None,
) -> Variant:
    """A variant of a scene.

    Parameters
    ----------
    scene : Scene
    name : str
    materials : mapping, optional
        Reflectance of some materials by name: a number, (n_bands,) values, a `Spectrum`, or a `Factor`.
    luminaires : mapping, optional
        Light of some luminaires by name: (n_bands,) exitance [W m⁻² per band] or intensity [W sr⁻¹ per band] as the
        scene has it, or a `Factor`; ``Factor(0)`` switches a lamp off.

    Raises
    ------
    ValueError
        For names that the scene does not have, shapes that do not fit, reflectances outside 0 … 1 and negative light;
        all of them at once.
    """
    problems: list[str] = []
    _check_names("material", materials or {}, [m.name for m in scene.materials], problems)
    _check_names("luminaire", luminaires or {}, [lamp.name for lamp in scene.luminaires], problems)
    painted = tuple(
        _repainted(m, materials[m.name], scene, problems) if materials and m.name in materials else m
        for m in scene.materials
    )
    lit = tuple(
        _relit(lamp, luminaires[lamp.name], problems) if luminaires and lamp.name in luminaires else lamp
        for lamp in scene.luminaires
    )
    if problems:
        raise ValueError(f"variant {name!r}: {'; '.join(problems)}")
    return Variant(name, painted, lit)


def variant_from(scene: Scene, other: Scene, name: str = "") -> Variant:
    """The variant of `scene` that `other` is.

    Parameters
    ----------
    name : str
        That of `other` if empty.

    Raises
    ------
    ValueError
        When they differ in more than reflectances and emitted light.
    """
    problems = [
        f"other {entry}" for entry in _SAME_IN_ALL if not _are_equal(getattr(scene, entry), getattr(other, entry))
    ]
    materials = [[(m.name, m.two_sided) for m in some.materials] for some in (scene, other)]
    lamps = [
        [(lamp.name, lamp.two_sided, len(lamp.exitance) > 0) for lamp in some.luminaires] for some in (scene, other)
    ]
    if materials[0] != materials[1]:
        problems.append("materials of other names or sides")
    if lamps[0] != lamps[1]:
        problems.append("luminaires of other names, sides or kinds")
    if problems:
        found = ", ".join(problems)
        raise ValueError(f"a variant may differ in reflectances and emitted light only; {other.name!r} has {found}")
    return Variant(name or other.name, other.materials, other.luminaires)


def check_variants(scene: Scene) -> None:
    """Raise ``ValueError`` for variants that are no variants of the scene, or of one name."""
    names = [variant.name for variant in scene.variants]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"several variants are named {', '.join(twice)}")
    for variant in scene.variants:
        variant_from(scene, with_variant(scene, variant))


def with_variant(scene: Scene, variant: Variant) -> Scene:
    """The scene as the variant has it, without variants of its own."""
    return replace(scene, materials=variant.materials, luminaires=variant.luminaires, variants=())


def stacked_reflectance(scene: Scene) -> NDArray[np.float64]:
    """(n_materials, (1 + n_variants) · n_bands) reflectance of the scene and of its variants, side by side."""
    return np.concatenate([scene.reflectance, *(with_variant(scene, v).reflectance for v in scene.variants)], axis=1)


def stacked_emission(scene: Scene) -> NDArray[np.float64]:
    """(n_luminaires, (1 + n_variants) · n_bands) exitance or intensity, side by side in the same way."""
    lists = [scene.luminaires, *(variant.luminaires for variant in scene.variants)]
    shape = (len(scene.luminaires), len(scene.bands))
    return np.concatenate([np.array([lamp.emission for lamp in some]).reshape(shape) for some in lists], axis=1)


def stacked_sky(scene: Scene) -> NDArray[np.float64]:
    """((1 + n_variants) · n_bands,) π · radiance of the sky, the same in all; 0 without a sky."""
    one = np.zeros(len(scene.bands)) if scene.sky is None else np.pi * scene.sky.radiance
    return np.tile(one, 1 + len(scene.variants))


def _check_names(kind: str, given: Mapping[str, object], known: list[str], problems: list[str]) -> None:
    unknown = [name for name in given if name not in known]
    if unknown:
        problems.append(f"no {kind} {', '.join(map(repr, unknown))}; there are {', '.join(map(repr, known))}")


def _repainted(
    material: Material, wanted: Factor | Spectrum | ArrayLike, scene: Scene, problems: list[str]
) -> Material:
    if isinstance(wanted, Factor):
        values = wanted.value * material.reflectance
    elif isinstance(wanted, Spectrum):
        values = band_mean(wanted, scene.bands, "hold").value
    else:
        values = _spread(wanted, len(scene.bands), f"material {material.name!r}", problems)
    if not ((values >= 0.0) & (values <= 1.0)).all():
        problems.append(f"material {material.name!r} has reflectances outside 0 to 1")
    return replace(material, reflectance=values)


def _relit(lamp: Luminaire, wanted: Factor | ArrayLike, problems: list[str]) -> Luminaire:
    before = lamp.emission
    if isinstance(wanted, Factor):
        values = wanted.value * before
    else:
        values = _spread(wanted, len(before), f"luminaire {lamp.name!r}", problems)
    if not ((values >= 0.0) & np.isfinite(values)).all():
        problems.append(f"luminaire {lamp.name!r} has light below 0 or not finite")
    return replace(lamp, exitance=values) if len(lamp.exitance) else replace(lamp, intensity=values)


def _spread(wanted: ArrayLike, n_bands: int, owner: str, problems: list[str]) -> NDArray[np.float64]:
    values = np.asarray(wanted, np.float64)
    if values.shape not in ((), (n_bands,)):
        problems.append(f"{owner} has values of the shape {values.shape}, not one number or {n_bands}")
        return np.zeros(n_bands)
    return np.broadcast_to(values, (n_bands,)).copy()


def _are_equal(one: object, other: object) -> bool:
    """Whether two values made of dataclasses, arrays and tuples hold the same."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(np.asarray(one), np.asarray(other))
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_are_equal, one, other))
    if type(one) is type(other) and hasattr(one, "__dataclass_fields__"):
        return all(_are_equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))  # type: ignore[arg-type]
    return one == other
