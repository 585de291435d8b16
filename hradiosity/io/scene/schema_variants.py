"""Tables of the scene format for variants: other paints and lamps in the same room."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from hradiosity.io.scene.schema_base import LARGEST, Name, Share, Table
from hradiosity.io.scene.schema_light import (
    LightFile,
    ReflectanceColour,
    ReflectanceFile,
    ReflectanceLibrary,
    ReflectanceSteps,
    SpectrumBlackbody,
    SpectrumConstant,
    SpectrumIlluminant,
    SpectrumLines,
    light_tag,
    reflectance_tag,
)


class FactorTable(Table):
    """So many times what the scene has, in every band."""

    factor: Annotated[float, Field(strict=True, ge=0, le=LARGEST)] = Field(
        description="times what the scene has, in every band; 0 switches a luminaire off"
    )


def _has_factor(value: Any) -> bool:
    return isinstance(value, dict) and "factor" in value


VariantReflectance = Annotated[
    Annotated[FactorTable, Tag("<factor>")]
    | Annotated[Share, Tag("<number>")]
    | Annotated[ReflectanceFile, Tag("<file>")]
    | Annotated[ReflectanceLibrary, Tag("<library>")]
    | Annotated[ReflectanceSteps, Tag("<steps>")]
    | Annotated[ReflectanceColour, Tag("<rgb>")],
    Discriminator(
        lambda value: "<factor>" if _has_factor(value) else reflectance_tag(value),
        custom_error_type="reflectance_form",
        custom_error_message="a number 0 … 1, or one of { factor = … }, { file = … }, { library = … }, "
        "{ steps = … }, { rgb = …, upsample = … } is needed",
    ),
]

VariantLight = Annotated[
    Annotated[FactorTable, Tag("<factor>")]
    | Annotated[LightFile, Tag("<file>")]
    | Annotated[SpectrumIlluminant, Tag("<illuminant>")]
    | Annotated[SpectrumBlackbody, Tag("<blackbody>")]
    | Annotated[SpectrumLines, Tag("<lines>")]
    | Annotated[SpectrumConstant, Tag("<constant>")],
    Discriminator(
        lambda value: "<factor>" if _has_factor(value) else light_tag(value),
        custom_error_type="spectrum_form",
        custom_error_message="one of { factor = … }, { illuminant = … }, { file = … }, { blackbody_K = … }, "
        "{ lines = … }, { constant = … } is needed",
    ),
]


class VariantTable(Table):
    """The same scene with some other paints and lamps: solved together with it, which makes the differences sharp."""

    name: Name = Field(
        pattern=r"^\w[\w .+-]*$",
        description="name of its folder in the results: letters, digits, blanks, and . + - _ after the first",
    )
    materials: dict[str, VariantReflectance] = Field(
        {},
        description="by material: another reflectance, as in [materials], or { factor = … } times the scene's own",
    )
    luminaires: dict[str, VariantLight] = Field(
        {},
        description="by luminaire: another spectrum, with the amount of light that the luminaire states, or "
        "{ factor = … } times the scene's own light",
    )
