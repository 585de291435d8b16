"""Tables of the scene format for those who look: sensors and views."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from hradiosity.io.scene.schema_base import Count, Name, Number, Positive, Table, Vector, exactly_one, one_of
from hradiosity.io.scene.schema_surfaces import BoxFace

_NAME = "name, as it appears in readings.csv"


class PointsSensor(Table):
    """Single points, each with the direction that its receiving plane faces."""

    model_config = one_of("normal", "normals")

    name: Name = Field(description=_NAME)
    kind: Literal["points"]
    positions: list[Vector] = Field(min_length=1, description="places [scene unit]")
    normal: Vector | None = Field(None, description="direction that all points face")
    normals: list[Vector] | None = Field(None, description="direction that each point faces")

    @model_validator(mode="after")
    def _one_direction(self) -> "PointsSensor":
        exactly_one(self, "normal", "normals")
        return self


class GridSensor(Table):
    """A grid of points at the centres of equal cells of a parallelogram; the index runs along edge_u first."""

    name: Name = Field(description=_NAME)
    kind: Literal["grid"]
    corner: Vector = Field(description="one corner of the parallelogram [scene unit]")
    edge_u: Vector = Field(description="edge along which the index runs first [scene unit]")
    edge_v: Vector = Field(description="the other edge [scene unit]")
    counts: tuple[Count, Count] = Field(description="cells along edge_u and edge_v")
    normal: Vector | None = Field(None, description="direction that the points face; edge_u × edge_v if left out")
    height: Number = Field(
        0.0, description="distance of the points from the parallelogram, along the normal [scene unit]"
    )


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

    @model_validator(mode="after")
    def _one_direction(self) -> "EyeSensor":
        exactly_one(self, "gaze", "gazes", "target")
        return self


SensorTable = Annotated[PointsSensor | GridSensor | SurfaceSensor | EyeSensor, Field(discriminator="kind")]


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
