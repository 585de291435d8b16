"""Tables of the scene format that hold geometry: rectangles, polygons, boxes, meshes, point sources."""

from typing import Literal

from pydantic import Field, model_validator

from hradiosity.io.scene.schema_base import Count, Name, Number, Positive, Table, Truth, Vector, exactly_one, one_of
from hradiosity.metrics.upsampling import Upsampling

LengthUnit = Literal["m", "cm", "mm", "in", "ft"]
UpAxis = Literal["z", "y"]
BoxFace = Literal["left", "right", "front", "back", "bottom", "top"]
BoxFaces = Literal["left", "right", "front", "back", "bottom", "top", "sides"]

_MATERIAL = "name of a [materials.…] table"
_LUMINAIRE = "name of a [luminaires.…] table, if the surface gives light"


class RectangleTable(Table):
    """A rectangle or parallelogram; its front is where edge_u × edge_v points."""

    name: Name | None = Field(None, description="name of the object; 'rectangle-<n>' if left out")
    corner: Vector = Field(description="one corner [scene unit]")
    edge_u: Vector = Field(description="edge from the corner to the next one [scene unit]")
    edge_v: Vector = Field(description="the other edge from the corner [scene unit]")
    material: Name = Field(description=_MATERIAL)
    luminaire: Name | None = Field(None, description=_LUMINAIRE)


class PolygonTable(Table):
    """One flat polygon, or several that share vertices; seen from the front the vertices run counter-clockwise."""

    name: Name | None = Field(None, description="name of the object; 'polygon-<n>' if left out")
    vertices: list[Vector] = Field(min_length=3, description="corners [scene unit], in order if there is one face")
    faces: list[list[Count | Literal[0]]] | None = Field(
        None, description="each face as a list of vertex numbers, counted from 0; all vertices in order if left out"
    )
    material: Name = Field(description=_MATERIAL)
    luminaire: Name | None = Field(None, description=_LUMINAIRE)
    solid: Truth | None = Field(
        None,
        description="behind the faces there is matter and no light; found out if left out. Say true for a block whose "
        "bottom is left out because it stands on the floor",
    )


class BoxTable(Table):
    """A box: a solid block with normals outwards, or (inside = true) a room with normals inwards.

    Faces are named in the frame of the box, before it is turned, with z up: left −x, right +x, front −y, back +y,
    bottom −z, top +z (with y up: left −x, right +x, front +z, back −z, bottom −y, top +y).
    """

    model_config = one_of("corner", "centre")

    name: Name | None = Field(None, description="name of the object; 'box-<n>' if left out")
    corner: Vector | None = Field(
        None, description="corner with the lowest coordinates before turning [scene unit]; the box turns about it"
    )
    centre: Vector | None = Field(None, description="centre [scene unit]; the box turns about it")
    size: tuple[Positive, Positive, Positive] = Field(description="extent along x, y, z before turning [scene unit]")
    rotation_deg: Number = Field(0.0, description="turn about rotation_axis [degrees], right-handed")
    rotation_axis: Vector | None = Field(None, description="axis of the turn; upwards if left out")
    material: Name | None = Field(None, description=f"{_MATERIAL}; may be left out if `faces` names every face")
    luminaire: Name | None = Field(None, description=f"{_LUMINAIRE}: on every face")
    faces: dict[BoxFaces, Name] = Field({}, description="other materials by face; 'sides' means the four upright faces")
    luminaires: dict[BoxFaces, Name] = Field({}, description="luminaires by face; 'sides' means the four upright faces")
    inside: Truth = Field(False, description="normals point inwards: a room")
    omit: list[BoxFaces] = Field([], description="faces that are left out; the box is then no solid")

    @model_validator(mode="after")
    def _one_place(self) -> "BoxTable":
        exactly_one(self, "corner", "centre")
        return self


class MeshTable(Table):
    """Faces from an OBJ, glTF, PLY or STL file."""

    name: Name | None = Field(None, description="prefix of the object names, '<name>/<object>'; file name if left out")
    file: Name = Field(description="mesh file, relative to the folder of the scene file")
    unit: LengthUnit = Field(description="unit of the lengths in the mesh file, which does not say it")
    up: UpAxis = Field(description="upward axis of the mesh file: z (Blender, Rhino, SketchUp) or y (Maya, glTF)")
    material: Name | None = Field(None, description="material of everything that `materials` does not map")
    materials: dict[str, Name] = Field(
        {},
        description="object or material name in the file → material of this scene; an object's entry wins over its "
        "material's; without `material`, every name must be mapped",
    )
    upsample: Upsampling | None = Field(
        None,
        description="how reflectances are guessed for textured materials that `materials` does not map, from the mean "
        "colour of their pictures (plain over the whole picture): as for an rgb reflectance. Without it they must be "
        "mapped",
    )
    luminaires: dict[str, Name] = Field({}, description="object or material name in the file → luminaire")
    position: Vector = Field((0.0, 0.0, 0.0), description="where the origin of the mesh goes [scene unit]")
    rotation_deg: Number = Field(0.0, description="turn about the upward axis through the origin of the mesh [degrees]")
    scale: Positive = Field(1.0, description="extra factor on the lengths of the mesh, beside its unit")


class PointSourceTable(Table):
    """A lamp too small to see: the same intensity in all directions."""

    name: Name | None = Field(None, description="name; 'point_source-<n>' if left out")
    position: Vector = Field(description="place [scene unit]")
    luminaire: Name = Field(description="name of a [luminaires.…] table with a flux, or with absolute = true")
