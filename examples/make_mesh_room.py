"""Write scenes/mesh_room: an L-shaped room from an OBJ file and furniture from a binary glTF file.

    python examples/make_mesh_room.py [FOLDER]

The files in the repository are what this script writes. The room is in metres with z up, as Blender and Rhino export
it; the furniture is in metres with y up, as glTF has it.
"""

import json
import math
import struct
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

PLAN = ((0.0, 0.0), (6.0, 0.0), (6.0, 2.5), (3.5, 2.5), (3.5, 4.5), (0.0, 4.5))
"""Corners of the floor, counter-clockwise from above [m]."""
HEIGHT = 2.8
WALL_PAINTS = ("white paint", "sage paint", "white paint", "white paint", "sage paint", "white paint")
PANELS = (("light panel A", (1.15, 2.0)), ("light panel B", (3.9, 1.1)))
"""Name and lowest x and y of the lamps [m]."""
PANEL_SIZE = (1.2, 0.3, 0.06)
PANEL_BOTTOM = 2.5

BOX_FACES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
"""Faces of a box by corner x + 2 y + 4 z, counter-clockwise from outside: left, right, front, back, bottom, top."""
BOTTOM = 4


def box_corners(corner: Sequence[float], size: Sequence[float]) -> NDArray[np.float64]:
    """(8, 3) corners, x fastest."""
    unit = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=np.float64)
    return np.asarray(corner) + unit * size


class Obj:
    """Text of an OBJ file that grows object by object."""

    def __init__(self, library: str) -> None:
        self.lines = ["# Written by examples/make_mesh_room.py", f"mtllib {library}"]
        self.count = 0

    def add(self, name: str, vertices: Iterable[Sequence[float]], faces: Iterable[tuple[str, Sequence[int]]]) -> None:
        """One object; a face is its material and its corners, counted from 0 within the object."""
        self.lines.append(f"o {name}")
        vertices = list(vertices)
        self.lines += ["v " + " ".join(f"{value:.6g}" for value in vertex) for vertex in vertices]
        for material, corners in faces:
            self.lines += [f"usemtl {material}", "f " + " ".join(str(self.count + corner + 1) for corner in corners)]
        self.count += len(vertices)


def room_obj() -> str:
    """The room: floor and ceiling as polygons of six corners, walls seen from inside, and two lamps."""
    obj = Obj("room.mtl")
    n = len(PLAN)
    corners = [(x, y, z) for z in (0.0, HEIGHT) for x, y in PLAN]
    shell = [("grey carpet", tuple(range(n))), ("ceiling paint", tuple(reversed(range(n, 2 * n))))]
    for k, paint in enumerate(WALL_PAINTS):
        following = (k + 1) % n
        shell.append((paint, (following, k, n + k, n + following)))
    obj.add("L room", corners, shell)
    for name, (x, y) in PANELS:
        faces = [("diffuser" if k == BOTTOM else "white metal", face) for k, face in enumerate(BOX_FACES)]
        obj.add(name, box_corners((x, y, PANEL_BOTTOM), PANEL_SIZE), faces)
    return "\n".join(obj.lines) + "\n"


def room_mtl() -> str:
    """Colours for other programs; the scene file says the reflectances."""
    colours = {
        "white paint": 0.8,
        "sage paint": 0.5,
        "ceiling paint": 0.85,
        "grey carpet": 0.2,
        "white metal": 0.8,
        "diffuser": 0.9,
    }
    return "\n".join(f"newmtl {name}\nKd {value} {value} {value}" for name, value in colours.items()) + "\n"


class Glb:
    """A binary glTF file that grows mesh by mesh (Khronos glTF 2.0, §4)."""

    def __init__(self, materials: Sequence[str]) -> None:
        self.materials = materials
        self.data = b""
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, object]] = []
        self.meshes: list[dict[str, object]] = []

    def add_mesh(self, boxes: Iterable[tuple[str, NDArray[np.float64]]]) -> int:
        """A mesh of boxes, (material, corners in z up); returns its number."""
        quads = np.array(BOX_FACES)
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        by_material: dict[str, list[NDArray[np.float64]]] = {}
        for material, corners in boxes:
            by_material.setdefault(material, []).append(corners)
        primitives = []
        for material, bodies in by_material.items():
            z_up = np.concatenate(bodies)
            points = np.stack([z_up[:, 0], z_up[:, 2], -z_up[:, 1]], axis=1).astype("<f4")
            indices = np.concatenate([triangles + 8 * k for k in range(len(bodies))]).astype("<u2").ravel()
            limits = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
            position = self._accessor(points.tobytes(), len(points), 5126, "VEC3", limits)
            index = self._accessor(indices.tobytes(), len(indices), 5123, "SCALAR", {})
            primitives.append(
                {"attributes": {"POSITION": position}, "indices": index, "material": self.materials.index(material)}
            )
        self.meshes.append({"primitives": primitives})
        return len(self.meshes) - 1

    def _accessor(self, data: bytes, count: int, component: int, kind: str, limits: dict[str, list[float]]) -> int:
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data + b"\0" * (-len(data) % 4)
        view = len(self.views) - 1
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **limits})
        return len(self.accessors) - 1

    def file(self, nodes: Sequence[dict[str, object]]) -> bytes:
        """The finished file, with these nodes as roots."""
        root = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": list(range(len(nodes)))}],
            "nodes": nodes,
            "meshes": self.meshes,
            "materials": [{"name": name} for name in self.materials],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data)}],
        }
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = (
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(self.data), b"BIN\0") + self.data
        )
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def on_legs(
    size: tuple[float, float, float], top: float, leg: float, materials: tuple[str, str]
) -> list[tuple[str, NDArray[np.float64]]]:
    """A board of thickness ``top`` on four square legs, centred on the origin, as boxes of (top, legs) materials."""
    width, depth, height = size
    boxes = [(materials[0], box_corners((-width / 2, -depth / 2, height - top), (width, depth, top)))]
    for x in (-width / 2 + leg, width / 2 - 2 * leg):
        for y in (-depth / 2 + leg, depth / 2 - 2 * leg):
            boxes.append((materials[1], box_corners((x, y, 0.0), (leg, leg, height - top))))
    return boxes


def furniture_glb() -> bytes:
    """A table, and one mesh of a stool used twice, the second one turned by 30° about the vertical."""
    glb = Glb(("oak veneer", "steel tube", "blue fabric"))
    table = glb.add_mesh(on_legs((1.6, 0.8, 0.74), 0.03, 0.05, ("oak veneer", "steel tube")))
    stool = glb.add_mesh(on_legs((0.4, 0.4, 0.45), 0.06, 0.03, ("blue fabric", "steel tube")))
    half_angle = math.radians(30.0) / 2
    turned = [0.0, round(math.sin(half_angle), 12), 0.0, round(math.cos(half_angle), 12)]
    return glb.file(
        [
            {"name": "table", "mesh": table},
            {"name": "stool by the window", "mesh": stool, "translation": [-0.3, 0.0, -0.7]},
            {"name": "stool by the door", "mesh": stool, "translation": [0.4, 0.0, 0.75], "rotation": turned},
        ]
    )


SCENE = """\
# An L-shaped room and its furniture from mesh files. Written by examples/make_mesh_room.py: edit that, not this.

[scene]
title = "Room from mesh files"
unit = "m"
up = "z"

[materials]
wall = { reflectance = { library = "grey/62" } }
sage = { reflectance = { library = "colorchecker/foliage" } }
ceiling = { reflectance = { library = "grey/86" } }
carpet = { reflectance = { library = "grey/20" } }
metal = { reflectance = 0.75 }
steel = { reflectance = 0.45 }
oak = { reflectance = { steps = [[380.0, 500.0, 0.18], [500.0, 600.0, 0.32], [600.0, 780.0, 0.48]] } }
fabric = { reflectance = { library = "colorchecker/blue" } }

[luminaires.panel]
spectrum = { illuminant = "LED-B3" }
luminous_flux_lm = 2600.0

# Names in the file on the left, materials of this scene on the right.
[[mesh]]
name = "room"
file = "room.obj"
unit = "m"
up = "z"
luminaires = { "diffuser" = "panel" }

[mesh.materials]
"white paint" = "wall"
"sage paint" = "sage"
"ceiling paint" = "ceiling"
"grey carpet" = "carpet"
"white metal" = "metal"
"diffuser" = "metal"

[[mesh]]
name = "furniture"
file = "furniture.glb"
unit = "m"
up = "y"
materials = { "oak veneer" = "oak", "steel tube" = "steel", "blue fabric" = "fabric" }
position = [1.75, 2.1, 0.0]
rotation_deg = 20.0

[[sensor]]
name = "table"
kind = "grid"
corner = [1.0, 1.8, 0.8]
edge_u = [1.2, 0.0, 0.0]
edge_v = [0.0, 0.6, 0.0]
counts = [6, 3]

[[sensor]]
name = "eyes"
kind = "eye"
positions = [[2.45, 1.4, 0.0], [5.5, 1.2, 0.0]]
eye_height = 1.2
target = [1.75, 2.1, 0.8]

[[view]]
name = "corner"
position = [5.7, 0.3, 1.7]
target = [1.5, 2.2, 0.9]
field_of_view_deg = 75.0
"""


def main(folder: Path) -> None:
    """Write scene file, meshes and material library."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("scene.toml", SCENE), ("room.obj", room_obj()), ("room.mtl", room_mtl())):
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    (folder / "furniture.glb").write_bytes(furniture_glb())


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "scenes" / "mesh_room")
