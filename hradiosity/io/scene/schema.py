"""The scene format as a whole: what may stand in ``scene.toml``, documented so that its JSON Schema is a manual."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from hradiosity.io.scene.schema_base import Name, Positive, Table
from hradiosity.io.scene.schema_light import ActionTable, LuminaireTable, MaintenanceFactor, MaterialTable, SkyTable
from hradiosity.io.scene.schema_sensors import SensorTable, ViewTable
from hradiosity.io.scene.schema_surfaces import (
    BoxTable,
    LengthUnit,
    MeshTable,
    PointSourceTable,
    PolygonTable,
    RectangleTable,
    UpAxis,
)
from hradiosity.io.scene.schema_variants import VariantTable


class UniformBands(Table):
    """Bands of one width."""

    first: Positive = Field(default=380.0, description="centre of the first band [nm]")
    last: Positive = Field(default=780.0, description="centre of the last band [nm], whole steps from the first")
    step: Positive = Field(default=5.0, description="width and distance of the bands [nm]")


class EdgeBands(Table):
    """Neighbouring bands of any width."""

    edges: list[Positive] = Field(min_length=2, description="edges [nm], ascending: one more than there are bands")


class RangeBands(Table):
    """Separate bands."""

    ranges: list[tuple[Positive, Positive]] = Field(
        min_length=1, description="[from nm, to nm] of each band, ascending"
    )


def _bands_tag(value: Any) -> str | None:
    if not isinstance(value, dict):
        return None
    return next((f"<{key}>" for key in ("edges", "ranges") if key in value), "<uniform>")


BandsTable = Annotated[
    Annotated[UniformBands, Tag("<uniform>")]
    | Annotated[EdgeBands, Tag("<edges>")]
    | Annotated[RangeBands, Tag("<ranges>")],
    Discriminator(
        _bands_tag,
        custom_error_type="bands_form",
        custom_error_message="{ first = …, last = …, step = … }, { edges = […] } or { ranges = [[…, …], …] } is needed",
    ),
]


class HeaderTable(Table):
    """What holds for the whole file."""

    title: Name | None = Field(None, description="name of the scene in reports; the folder's name if left out")
    unit: LengthUnit = Field(
        description="unit of all lengths in this file: m, cm, mm, in or ft (mesh files have their own)"
    )
    up: UpAxis = Field("z", description="upward axis of all coordinates in this file: z or y")
    bands: BandsTable = Field(
        UniformBands(), description="wavelength bands that light is counted in; 380 to 780 nm in 5 nm if left out"
    )
    maintenance_factor: MaintenanceFactor | None = Field(
        None,
        description="share of all lamps' light that is left before maintenance: then readings.csv has maintained "
        "illuminances too; the sky keeps its light",
    )


class SceneFile(Table):
    """A scene: materials, luminaires, surfaces, sensors, views and variants."""

    scene: HeaderTable = Field(description="what holds for the whole file")
    materials: dict[str, MaterialTable] = Field({}, description="paints by name")
    luminaires: dict[str, LuminaireTable] = Field({}, description="kinds of lamp by name")
    rectangle: list[RectangleTable] = Field([], description="rectangles and parallelograms")
    polygon: list[PolygonTable] = Field([], description="flat polygons, one or several to an object")
    box: list[BoxTable] = Field([], description="blocks and rooms")
    mesh: list[MeshTable] = Field([], description="meshes from files")
    point_source: list[PointSourceTable] = Field([], description="point-like lamps")
    sky: SkyTable | None = Field(None, description="light from outside")
    sensor: list[SensorTable] = Field([], description="where the light is read")
    view: list[ViewTable] = Field([], description="cameras")
    actions: dict[str, ActionTable] = Field(
        {}, description="action spectra by name: readings.csv gets a column NAME_w_m2 for each [W m⁻² times its unit]"
    )
    variant: list[VariantTable] = Field([], description="the same scene in other paints and lamps")


def scene_json_schema() -> dict[str, Any]:
    """JSON Schema of ``scene.toml``: for editors, and as the reference of every key with its unit."""
    schema = SceneFile.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "hradiosity scene"
    return schema
