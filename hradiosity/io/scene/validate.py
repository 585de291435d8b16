"""From TOML text to checked tables: syntax, unknown keys, wrong types, effects that are not simulated."""

from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

from pydantic import BaseModel, Tag, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from hradiosity.errors import Fault, SceneError
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.quick_toml import parse
from hradiosity.io.scene.report import Report, did_you_mean
from hradiosity.io.scene.schema import SceneFile

_UNBUILT: Final = {
    "sun": "the sun",
    "direct_sun": "the sun",
    "daylight": "daylight other than a uniform sky",
    "cie_overcast": "a sky other than the uniform one",
    "overcast": "a sky other than the uniform one",
    "clear": "a sky other than the uniform one",
    "cie_clear": "a sky other than the uniform one",
    "perez": "a sky other than the uniform one",
    "climate": "a sky other than the uniform one",
    "epw": "a sky other than the uniform one",
    "ies": "a photometric file (IES)",
    "ldt": "a photometric file (EULUMDAT)",
    "eulumdat": "a photometric file (EULUMDAT)",
    "tm33": "a photometric file (TM-33)",
    "gldf": "a photometric file (GLDF)",
    "photometry": "a photometric file",
    "spotlight": "a luminaire that is not Lambertian or isotropic",
    "beam_angle_deg": "a luminaire that is not Lambertian or isotropic",
    "intensity_distribution": "a luminaire that is not Lambertian or isotropic",
    "fluorescence": "fluorescence",
    "fluorescent": "fluorescence",
    "donaldson": "fluorescence",
    "reradiation": "fluorescence",
    "polarisation": "polarisation",
    "polarization": "polarisation",
    "transmittance": "transmission of light",
    "transmission": "transmission of light",
    "translucent": "transmission of light",
    "translucency": "transmission of light",
    "transparent": "transmission of light",
    "opacity": "transmission of light",
    "glass": "glass",
    "glazing": "glass",
    "dielectric": "glass",
    "refractive_index": "glass",
    "ior": "glass",
    "mirror": "mirror reflection",
    "specular": "mirror or glossy reflection",
    "specularity": "mirror or glossy reflection",
    "glossy": "glossy reflection",
    "gloss": "glossy reflection",
    "roughness": "glossy reflection",
    "metal": "glossy reflection",
    "metallic": "glossy reflection",
    "brdf": "directional reflection",
    "bsdf": "directional reflection",
    "medium": "a participating medium",
    "fog": "a participating medium",
    "smoke": "a participating medium",
    "scattering": "a participating medium",
    "absorption": "a participating medium",
    "texture": "a texture (each face has one reflectance)",
    "textures": "a texture (each face has one reflectance)",
    "image": "a texture (each face has one reflectance)",
    "bump": "a bump map",
    "bump_map": "a bump map",
    "normal_map": "a bump map",
}
"""Words that a user may expect to work → the effect, which is refused by name and never ignored."""

_KIND_KEYS: Final = ("kind", "type", "model")
_EXPECTED: Final = {
    "bool_type": "true or false",
    "dict_type": "a table of keys",
    "model_type": "a table of keys",
    "model_attributes_type": "a table of keys",
}
"""Kinds of errors → what is expected, where pydantic says it in its own terms."""


def parse_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Text and raw tables of a scene file; raises ``SceneError`` with line and column when it is no TOML."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError([Fault(str(path), "", f"not UTF-8 text (byte {error.start})", "save it as UTF-8")]) from None
    except OSError as error:
        raise SceneError([Fault(str(path), "", f"can't be read: {error.strerror}", "a readable file")]) from None
    try:
        return text, parse(text)
    except RecursionError:
        raise SceneError([Fault(str(path), "", "lists are nested too deeply", "see https://toml.io")]) from None
    except ValueError as error:  # beside syntax, whole numbers of thousands of digits and dates that don't exist
        raise SceneError([Fault(str(path), "", f"not valid TOML: {error}", "see https://toml.io")]) from None


def validate(raw: dict[str, Any], report: Report) -> SceneFile:
    """Tables of a scene file.

    Entries with faults are reported and left out, so that the rest is still checked; the result is for finding more
    faults, and is only good for a scene when ``report.faults`` is empty.
    """
    tables = dict(raw)
    while True:
        try:
            return SceneFile.model_validate(tables)
        except ValidationError as error:
            details = error.errors(include_url=False)
            for detail in details:
                _report_detail(tables, detail, report)
            tables = _without_faulty(tables, details, report)


def _without_faulty(tables: dict[str, Any], details: list[ErrorDetails], report: Report) -> dict[str, Any]:
    """The tables less the entries (one material, one box …) in which something is wrong."""
    kept = dict(tables)
    faulty = {detail["loc"][:2] for detail in details}
    for key in {str(location[0]) for location in faulty}:
        value = kept.pop(key, None)
        if key == "scene":
            kept[key] = {"unit": "m"}
        elif (key,) in faulty:
            continue
        elif isinstance(value, list):
            good = [i for i in range(len(value)) if (key, i) not in faulty]
            kept[key] = [value[i] for i in good]
            report.renumber(key, good)
        elif isinstance(value, dict) and key in ("materials", "luminaires", "actions"):
            kept[key] = {name: entry for name, entry in value.items() if (key, name) not in faulty}
    return kept


def _report_detail(raw: dict[str, Any], detail: ErrorDetails, report: Report) -> None:
    """One validation error in the user's words."""
    location = _user_location(raw, detail)
    key, given = str(location[-1]), detail["input"]
    effect = _unbuilt_effect(location, detail)
    if effect is not None:
        report.fault(location, f"{effect} is not simulated by this version", "leave it out")
        return
    kind = detail["type"]
    if kind == "extra_forbidden":
        report.fault(location, f"unknown key {key!r}", did_you_mean(key, _known_keys(detail["loc"][:-1])))
    elif kind == "missing":
        report.fault(location, "is missing", _description(detail["loc"]))
    elif kind == "exactly_one":
        report.fault(location, f"{detail['ctx']['given']} given", f"exactly one of {detail['ctx']['choices']}")
    elif kind == "useless_key":
        report.fault(location, detail["msg"], f"none of that with {detail['ctx']['response']}")
    elif kind == "no_facing":
        report.fault((*location, "facing"), "is missing", "the direction that half cylinders face")
    elif kind == "no_eye":
        report.fault((*location, "eye"), "is missing", "the place that it is seen from, [x, y, z]")
    elif kind == "literal_error":
        known = detail["ctx"]["expected"].replace(" or ", ", ").strip("'").split("', '")
        report.fault(location, repr(given), did_you_mean(str(given), known))
    elif kind == "union_tag_invalid":
        tags = detail["ctx"]["expected_tags"].strip("'").split("', '")
        report.fault((*location, "kind"), repr(detail["ctx"]["tag"]), did_you_mean(detail["ctx"]["tag"], tags))
    elif kind == "union_tag_not_found":
        report.fault((*location, "kind"), "is missing", "kind = 'points', 'grid', 'surface', 'eye' or 'luminance'")
    elif kind == "list_type" and len(location) == 1:
        report.fault(location, f"[{key}] is one table", f"[[{key}]], in double brackets, since there can be several")
    else:
        expected = _EXPECTED.get(kind) or detail["msg"].removeprefix("Input should be ")
        report.fault(location, repr(given), f"{expected}: {_description(detail['loc'])}".removesuffix(": "))


def _unbuilt_effect(location: Location, detail: ErrorDetails) -> str | None:
    """The effect that an unknown key or kind asks for, if it is one that this version lacks."""
    words: list[Any] = []
    if detail["type"] == "extra_forbidden":
        words = [location[-1]]
        if location[-1] in _KIND_KEYS:
            words.append(detail["input"])
    elif detail["type"] == "literal_error":
        words = [detail["input"]]
    elif detail["type"] == "union_tag_invalid":
        words = [detail["ctx"]["tag"]]
    elif detail["type"] in ("reflectance_form", "spectrum_form") and isinstance(detail["input"], dict):
        words = list(detail["input"])
    found = (_UNBUILT.get(str(word).casefold().replace("-", "_")) for word in words if isinstance(word, str))
    return next((effect for effect in found if effect is not None), None)


def _user_location(raw: dict[str, Any], detail: ErrorDetails) -> Location:
    """Location without the tags that pydantic puts in for the alternatives of a union."""
    location: list[str | int] = []
    value: Any = raw
    names_key = detail["type"] in ("missing", "extra_forbidden")
    for number, part in enumerate(detail["loc"]):
        is_present = (isinstance(value, dict) and part in value) or (
            isinstance(value, list) and isinstance(part, int) and part < len(value)
        )
        if is_present:
            value = value[part]
            location.append(part)
        elif names_key and number == len(detail["loc"]) - 1:
            location.append(part)
    return tuple(location)


def _alternatives(annotation: Any) -> Iterator[tuple[str | None, Any]]:
    """(tag, type) of each alternative of a union; a plain type is its own only alternative."""
    if get_origin(annotation) is Annotated:
        inner, *metadata = get_args(annotation)
        tag = next((item.tag for item in metadata if isinstance(item, Tag)), None)
        for inner_tag, alternative in _alternatives(inner):
            yield tag or inner_tag, alternative
    elif get_origin(annotation) in (Union, UnionType):
        for alternative in get_args(annotation):
            yield from _alternatives(alternative)
    elif _is_table(annotation) and "kind" in annotation.model_fields:
        kind = annotation.model_fields["kind"].annotation
        yield (get_args(kind)[0] if get_origin(kind) is Literal else None), annotation
    else:
        yield None, annotation


def _is_table(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _follow(location: Location) -> tuple[Any, FieldInfo | None]:
    """Type at a location of the scene format (with pydantic's tags), and the field that leads there."""
    current: Any = SceneFile
    field: FieldInfo | None = None
    for part in location:
        choices = [(tag, kind) for tag, kind in _alternatives(current) if kind is not type(None)]
        tagged = next((kind for tag, kind in choices if tag is not None and tag == part), None)
        if tagged is not None:
            current = tagged
            continue
        current = choices[0][1] if choices else None
        if _is_table(current):
            field = current.model_fields.get(str(part))
            current = field.annotation if field else None
        elif get_origin(current) is dict:
            current = get_args(current)[1]
        elif get_origin(current) in (list, tuple):
            current = get_args(current)[0]
    return current, field


def _known_keys(location: Location) -> list[str]:
    """Keys of the table at a location."""
    models = (kind for _, kind in _alternatives(_follow(location)[0]))
    return [key for model in models if _is_table(model) for key in model.model_fields]


def _description(location: Location) -> str:
    """What the manual says about the key at a location."""
    field = _follow(location)[1]
    return (field.description or "") if field else ""
