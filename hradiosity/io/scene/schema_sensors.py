"""Tables of the scene format for those who look: sensors and views."""

from typing import Annotated, Any, Final, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hradiosity.io.scene.schema_base import (
    LARGEST,
    Count,
    Name,
    Number,
    Positive,
    Table,
    Truth,
    Vector,
    exactly_one,
    one_of,
)
from hradiosity.io.scene.schema_surfaces import BoxFace

_NAME = "name, as it appears in readings.csv"
HalfAxis = Annotated[Positive, Field(le=180)]
Pixel = Annotated[Number, Field(ge=0)]


def _spacing(value: Any) -> Any:
    """Refuse in one sentence what is neither a length nor the name of the standard."""
    is_length = isinstance(value, int | float) and not isinstance(value, bool) and 0 < value <= LARGEST
    if value != EN_12464_1 and not is_length:
        raise PydanticCustomError("spacing", 'a length above 0, or "EN 12464-1", is needed')
    return value


EN_12464_1: Final = "EN 12464-1"
GridSpacing = Annotated[Literal["EN 12464-1"] | Positive, BeforeValidator(_spacing)]


class Curved(Table):
    """Keys of sensors whose readings may be mean illuminances over something curved in place of a plane."""

    response: Literal["plane", "cylindrical", "semi-cylindrical", "spherical"] = Field(
        "plane",
        description="what is read: illuminance of a plane, or mean illuminance of a cylinder without its ends, of the "
        "half of it that faces `facing`, or of a sphere",
    )
    axis: Vector | None = Field(None, description="axis of cylinders; upwards if left out")
    facing: Vector | None = Field(None, description="direction that half cylinders face, across their axis")

    def check_directions(self) -> None:
        """Raise ``PydanticCustomError`` for directions that the response has no use for, or that it lacks."""
        useless = [
            key
            for key, kinds in (("axis", ("cylindrical", "semi-cylindrical")), ("facing", ("semi-cylindrical",)))
            if getattr(self, key) is not None and self.response not in kinds
        ]
        if useless:
            raise PydanticCustomError(
                "useless_key", "{keys} given", {"keys": " and ".join(useless), "response": self.response}
            )
        if self.response == "semi-cylindrical" and self.facing is None:
            raise PydanticCustomError("no_facing", "no `facing` given")


class PointsSensor(Curved):
    """Single points, each with the direction that its receiving plane faces."""

    model_config = ConfigDict(
        json_schema_extra={"anyOf": [{"required": [key]} for key in ("normal", "normals", "response")]}
    )

    name: Name = Field(description=_NAME)
    kind: Literal["points"]
    positions: list[Vector] = Field(min_length=1, description="places [scene unit]")
    normal: Vector | None = Field(None, description="direction that all points face")
    normals: list[Vector] | None = Field(None, description="direction that each point faces")

    @model_validator(mode="after")
    def _one_direction(self) -> "PointsSensor":
        self.check_directions()
        if self.response == "plane":
            exactly_one(self, "normal", "normals")
        elif self.normal is not None or self.normals is not None:
            raise PydanticCustomError("useless_key", "{keys} given", {"keys": "a normal", "response": self.response})
        return self


class GridSensor(Curved):
    """A grid of points at the centres of equal cells of a parallelogram; the index runs along edge_u first."""

    model_config = one_of("counts", "spacing")

    name: Name = Field(description=_NAME)
    kind: Literal["grid"]
    corner: Vector = Field(description="one corner of the parallelogram [scene unit]")
    edge_u: Vector = Field(description="edge along which the index runs first [scene unit]")
    edge_v: Vector = Field(description="the other edge [scene unit]")
    counts: tuple[Count, Count] | None = Field(None, description="cells along edge_u and edge_v")
    spacing: GridSpacing | None = Field(
        None,
        description="largest distance of neighbouring points [scene unit], or EN 12464-1, which makes it from the size "
        "of the area",
    )
    border: Annotated[Number, Field(ge=0)] = Field(
        0.0, description="width of a strip along all edges that has no points [scene unit]; 0.5 m from walls is usual"
    )
    normal: Vector | None = Field(None, description="direction that the points face; edge_u × edge_v if left out")
    height: Number = Field(
        0.0, description="distance of the points from the parallelogram, along the normal [scene unit]"
    )

    @model_validator(mode="after")
    def _one_density(self) -> "GridSensor":
        exactly_one(self, "counts", "spacing")
        self.check_directions()
        return self


class SurfaceSensor(Table):
    """Points spread over the faces of an object, facing away from it."""

    model_config = one_of("counts", "spacing")

    name: Name = Field(description=_NAME)
    kind: Literal["surface"]
    object: Name = Field(description="name of an object; of a mesh, one of its objects '<mesh>/<object>' or all of it")
    face: BoxFace | None = Field(None, description="face of a box; all faces if left out")
    counts: tuple[Count, Count] | None = Field(None, description="cells along the two edges of each face")
    spacing: Positive | None = Field(None, description="largest distance of neighbouring points [scene unit]")
    side: Literal["front", "back"] = Field("front", description="side of the faces that is read")
    offset: Positive | None = Field(
        None, description="distance of the points from the surface [scene unit]; 1 mm if left out"
    )

    @model_validator(mode="after")
    def _one_density(self) -> "SurfaceSensor":
        exactly_one(self, "counts", "spacing")
        return self


class FieldTable(Table):
    """How far eyes see: half axes of an ellipse in each quarter of the field of view."""

    up: HalfAxis = Field(90.0, description="upwards from the line of sight [degrees]")
    down: HalfAxis = Field(90.0, description="downwards [degrees]")
    left: HalfAxis = Field(90.0, description="to the left [degrees]")
    right: HalfAxis = Field(90.0, description="to the right [degrees]")


class EyeSensor(Table):
    """Eyes: light on the plane at the eye that is perpendicular to the gaze (vertical illuminance when it is level)."""

    model_config = one_of("gaze", "gazes", "target")

    name: Name = Field(description=_NAME)
    kind: Literal["eye"]
    positions: list[Vector] = Field(min_length=1, description="places [scene unit]: of the eyes, or below them")
    eye_height: Number = Field(
        0.0, description="added to the positions, upwards [scene unit]; 1.2 m is usual when seated"
    )
    gaze: Vector | None = Field(None, description="direction in which all look")
    gazes: list[Vector] | None = Field(None, description="direction in which each looks")
    target: Vector | None = Field(None, description="point that all look at [scene unit]")
    field: FieldTable | None = Field(None, description="light from outside of this field of view does not count")
    glare: Truth = Field(False, description="whether glare is rated: UGR of CIE 117, in glare.csv")

    @model_validator(mode="after")
    def _one_direction(self) -> "EyeSensor":
        exactly_one(self, "gaze", "gazes", "target")
        return self


class LuminanceSensor(Table):
    """Luminance of what is seen from an eye: at points, or the mean over a rectangle of a view."""

    model_config = one_of("targets", "directions", "view")

    name: Name = Field(description=_NAME.replace("readings", "luminances"))
    kind: Literal["luminance"]
    eye: Vector | None = Field(None, description="place that it is seen from [scene unit]; a view has its own")
    targets: list[Vector] | None = Field(None, min_length=1, description="points that are looked at [scene unit]")
    directions: list[Vector] | None = Field(None, min_length=1, description="directions that are looked in")
    view: Name | None = Field(None, description="name of a view, a rectangle of which is one reading")
    pixels: tuple[Pixel, Pixel, Pixel, Pixel] | None = Field(
        None,
        description="left, top, right and bottom edge of the rectangle [pixels from the top left]; all if left out",
    )
    rays: tuple[Count, Count] | None = Field(
        None, description="columns and rows of the even grid of rays that the mean is over; 8 × 8 if left out"
    )

    @model_validator(mode="after")
    def _one_region(self) -> "LuminanceSensor":
        what = exactly_one(self, "targets", "directions", "view")
        if what == "view" and self.eye is not None:
            raise PydanticCustomError("useless_key", "{keys} given", {"keys": "eye", "response": "a view"})
        if what != "view" and self.eye is None:
            raise PydanticCustomError("no_eye", "no eye")
        if what != "view" and (self.pixels is not None or self.rays is not None):
            raise PydanticCustomError("useless_key", "{keys} given", {"keys": "pixels or rays", "response": what})
        return self


SensorTable = Annotated[
    PointsSensor | GridSensor | SurfaceSensor | EyeSensor | LuminanceSensor, Field(discriminator="kind")
]


class ViewTable(Table):
    """A camera; its pictures are written by `render`."""

    model_config = one_of("target", "direction")

    name: Name = Field(description="name, also of the picture files")
    position: Vector = Field(description="place of the camera [scene unit]")
    target: Vector | None = Field(None, description="point in the middle of the picture [scene unit]")
    direction: Vector | None = Field(None, description="direction of the middle of the picture")
    up: Vector | None = Field(None, description="direction that is up in the picture; upwards if left out")
    field_of_view_deg: Annotated[Positive, Field(lt=180)] = Field(
        60.0, description="horizontal angle of view [degrees]"
    )
    size: tuple[Count, Count] = Field((640, 480), description="width and height of the picture [pixels]")

    @model_validator(mode="after")
    def _one_direction(self) -> "ViewTable":
        exactly_one(self, "target", "direction")
        return self
