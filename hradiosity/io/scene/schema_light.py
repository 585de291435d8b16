"""Tables of the scene format that hold spectra: materials, luminaires, the sky."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from hradiosity.io.scene.schema_base import Name, Number, Positive, Share, Table, exactly_one, one_of, three_numbers
from hradiosity.metrics.upsampling import Upsampling


class SpectrumFile(Table):
    """A measured spectrum in a CSV file: wavelengths in nm in the first column."""

    file: Name = Field(description="CSV file, relative to the folder of the scene file")
    column: Name | None = Field(None, description="header of the column to read; needed when the file has several")


class ReflectanceFile(SpectrumFile):
    """A measured reflectance in a CSV file, 0 … 1."""

    outside: Literal["hold", "refuse"] = Field(
        "hold",
        description="bands beyond the measured wavelengths: 'hold' repeats the end value (and reports it), "
        "'refuse' makes it a fault",
    )


class ActionTable(SpectrumFile):
    """An action spectrum that each reading is weighted by: of plants, hazards, or a curve of your own."""


class ReflectanceLibrary(Table):
    """A reflectance that comes with the program."""

    library: Name = Field(
        description="'colorchecker/<patch>' (for example colorchecker/red), 'cornell/white|green|red', "
        "'grey/<percent>' (for example grey/50)"
    )


class ReflectanceSteps(Table):
    """A reflectance that is constant between stated wavelengths."""

    steps: list[tuple[Number, Number, Share]] = Field(
        min_length=1,
        description="[from nm, to nm, reflectance] rows, ascending, each starting where the last one ends; the first "
        "and last value hold beyond",
    )


class ReflectanceColour(Table):
    """A reflectance guessed from a colour: not measured, and reported so."""

    rgb: Annotated[tuple[Share, Share, Share], BeforeValidator(three_numbers)] = Field(
        description="linear sRGB (not gamma-encoded), each 0 … 1"
    )
    upsample: Upsampling = Field(
        description="how the spectrum is guessed; must be named because a colour has no one spectrum. "
        "'mallett2019': Mallett and Yuksel 2019, smooth, has exactly the colour under D65; "
        "'otsu2018': Otsu, Yamamoto and Hachisuka 2018, closer to measured paints, colour approximate"
    )


def reflectance_tag(value: Any) -> str | None:
    """Which of the forms of a reflectance a value has."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return "<number>"
    keys = {"file": "<file>", "library": "<library>", "steps": "<steps>", "rgb": "<rgb>"}
    if isinstance(value, dict):
        return next((tag for key, tag in keys.items() if key in value), None)
    return None


Reflectance = Annotated[
    Annotated[Share, Tag("<number>")]
    | Annotated[ReflectanceFile, Tag("<file>")]
    | Annotated[ReflectanceLibrary, Tag("<library>")]
    | Annotated[ReflectanceSteps, Tag("<steps>")]
    | Annotated[ReflectanceColour, Tag("<rgb>")],
    Discriminator(
        reflectance_tag,
        custom_error_type="reflectance_form",
        custom_error_message="a number 0 … 1, or one of { file = … }, { library = … }, { steps = … }, "
        "{ rgb = …, upsample = … } is needed",
    ),
]


class MaterialTable(Table):
    """A matt (Lambertian) paint."""

    reflectance: Reflectance = Field(
        description="hemispherical reflectance 0 … 1: a number, or a table with file, library, steps or rgb"
    )
    sides: Literal["both", "front"] = Field(
        "both", description="'both': reflects on both sides; 'front': the back is black and opaque"
    )


class LightFile(SpectrumFile):
    """A measured spectral power distribution in a CSV file, per nm.

    A row that begins with the word line, as in ``line, 546.07, 12.3``, is a narrow spectral line: its wavelength in nm
    and its whole power, in the unit of the table times nm. A file may hold such rows only.
    """

    outside: Literal["zero", "hold", "refuse"] = Field(
        "zero",
        description="bands beyond the measured wavelengths: 'zero' gives them no light (and reports it), 'hold' "
        "repeats the end value, 'refuse' makes it a fault. An end value holds for half a step of the table in any case",
    )


class SpectrumIlluminant(Table):
    """A CIE illuminant."""

    illuminant: Name = Field(description="CIE illuminant, for example A, D50, D65, E, FL2, FL11, LED-B3")


class SpectrumBlackbody(Table):
    """Thermal radiation by Planck's law."""

    blackbody_K: Positive = Field(description="temperature in kelvin")


class SpectrumLines(Table):
    """Narrow spectral lines."""

    lines: list[tuple[Positive, Positive]] = Field(
        min_length=1, description="[wavelength nm, relative power] of each line"
    )


class SpectrumConstant(Table):
    """The same power at every wavelength."""

    constant: Positive = Field(description="relative power per nm; W m⁻² nm⁻¹ (or W sr⁻¹ nm⁻¹) if absolute")


def light_tag(value: Any) -> str | None:
    """Which of the forms of a light's spectrum a value has."""
    keys = {
        "file": "<file>",
        "illuminant": "<illuminant>",
        "blackbody_K": "<blackbody>",
        "lines": "<lines>",
        "constant": "<constant>",
    }
    if isinstance(value, dict):
        return next((tag for key, tag in keys.items() if key in value), None)
    return None


LightSpectrum = Annotated[
    Annotated[LightFile, Tag("<file>")]
    | Annotated[SpectrumIlluminant, Tag("<illuminant>")]
    | Annotated[SpectrumBlackbody, Tag("<blackbody>")]
    | Annotated[SpectrumLines, Tag("<lines>")]
    | Annotated[SpectrumConstant, Tag("<constant>")],
    Discriminator(
        light_tag,
        custom_error_type="spectrum_form",
        custom_error_message="one of { illuminant = … }, { file = … }, { blackbody_K = … }, { lines = … }, "
        "{ constant = … } is needed",
    ),
]

AMOUNTS = ("luminous_flux_lm", "luminous_exitance_lm_m2", "radiant_flux_W", "radiant_exitance_W_m2", "absolute")
"""Keys of a luminaire that say how much light it gives; exactly one is given."""


MaintenanceFactor = Annotated[Positive, Field(le=1)]


class LuminaireTable(Table):
    """A kind of lamp: the shape of its spectrum, and one key that says how much light it gives."""

    model_config = one_of(*AMOUNTS)

    spectrum: LightSpectrum = Field(
        description="spectral shape: a table with illuminant, file, blackbody_K, lines or constant"
    )
    luminous_flux_lm: Positive | None = Field(
        None,
        description="luminous flux [lm] of each object that uses the luminaire, over all its emitting faces and sides, "
        "shared by area; of a point source, into all directions",
    )
    luminous_exitance_lm_m2: Positive | None = Field(
        None, description="luminous exitance [lm m⁻²] of each emitting side"
    )
    radiant_flux_W: Positive | None = Field(
        None, description="radiant flux [W] within the scene's bands; of each object, as luminous_flux_lm"
    )
    radiant_exitance_W_m2: Positive | None = Field(
        None, description="radiant exitance [W m⁻²] of each emitting side, within the scene's bands"
    )
    absolute: Literal[True] | None = Field(
        None,
        description="the spectrum is already absolute: W m⁻² nm⁻¹ of exitance on each emitting side, or W sr⁻¹ nm⁻¹ of "
        "intensity for a point source (a line: W m⁻² or W sr⁻¹)",
    )
    sides: Literal["front", "both"] = Field(
        "front", description="sides of a face that emit; front is where its normal points"
    )
    maintenance_factor: MaintenanceFactor | None = Field(
        None, description="share of its light that is left before maintenance; that of [scene] if left out"
    )

    @model_validator(mode="after")
    def _one_amount(self) -> "LuminaireTable":
        exactly_one(self, *AMOUNTS)
        return self


class SkyTable(Table):
    """Light from outside: a sky of the same radiance in all directions above the horizon, black ground below."""

    model_config = one_of("luminance_cd_m2", "illuminance_lx")

    kind: Literal["uniform"] = Field(description="'uniform' is the only sky that is simulated")
    spectrum: LightSpectrum = Field(description="spectral shape, as for a luminaire")
    luminance_cd_m2: Positive | None = Field(None, description="luminance of the sky [cd m⁻²]")
    illuminance_lx: Positive | None = Field(
        None, description="illuminance of an unobstructed horizontal plane [lx]: π sr times the luminance"
    )

    @model_validator(mode="after")
    def _one_amount(self) -> "SkyTable":
        exactly_one(self, "luminance_cd_m2", "illuminance_lx")
        return self
