"""Scenes for the tests of light: boxes, plates, lamps, any reflectances, in as many bands as wanted."""

from dataclasses import dataclass, field, replace

import numpy as np

from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Emitters, Luminaire, Material, Scene, Sensor, Sky
from hradiosity.model.spectrum import Bands


def bands_of(count: int) -> Bands:
    return Bands.explicit(500.0 + 5.0 * np.arange(count + 1))


@dataclass
class SceneBuilder:
    """Collects patches, lamps and sensors; `scene()` makes the value."""

    bands: int = 1
    rows: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    luminaires: list = field(default_factory=list)
    emitters: list = field(default_factory=list)
    sensors: list = field(default_factory=list)
    sky: Sky | None = None
    solids: int = 0

    def material(self, reflectance, two_sided=True) -> int:
        spectrum = np.broadcast_to(np.asarray(reflectance, float), (self.bands,)).copy()
        self.materials.append(Material(f"m{len(self.materials)}", spectrum, two_sided))
        return len(self.materials) - 1

    def patch(self, origin, edge_u, edge_v, material, triangle=False, solid=NONE) -> int:
        self.rows.append((origin, edge_u, edge_v, triangle, material, solid))
        return len(self.rows) - 1

    def box(self, low, high, material, inward=False, solid=False) -> list[int]:
        """Six faces in the order x0, x1, y0, y1, z0, z1; `material` one for all or a list of six."""
        low, size = np.asarray(low, float), np.asarray(high, float) - low
        x, y, z = np.diag(size)
        faces = [(low, z, y), (low + x, y, z), (low, x, z), (low + y, z, x), (low, y, x), (low + z, x, y)]
        names = material if isinstance(material, list) else [material] * 6
        number = self.solids if solid else NONE
        self.solids += solid
        return [
            self.patch(origin, b if inward else a, a if inward else b, name, solid=number)
            for (origin, a, b), name in zip(faces, names)
        ]

    def lamp(self, patches, exitance, two_sided=False):
        """The patches emit `exitance` in each band."""
        self.luminaires.append(Luminaire(f"l{len(self.luminaires)}", self._spectrum(exitance), np.zeros(0), two_sided))
        for patch in np.atleast_1d(patches):
            self.emitters.append((int(patch), (0.0, 0.0, 0.0), len(self.luminaires) - 1))

    def point(self, position, intensity):
        self.luminaires.append(Luminaire(f"l{len(self.luminaires)}", np.zeros(0), self._spectrum(intensity)))
        self.emitters.append((NONE, position, len(self.luminaires) - 1))

    def sensor(self, position, normal, name=None):
        position = np.atleast_2d(np.asarray(position, float))
        normal = np.broadcast_to(np.asarray(normal, float), position.shape).copy()
        self.sensors.append(Sensor(name or f"s{len(self.sensors)}", position, normal))

    def scene(self) -> Scene:
        columns = list(zip(*self.rows)) if self.rows else [[]] * 6
        n = len(self.rows)
        patches = Patches(
            origin=np.array(columns[0], float).reshape(n, 3),
            edge_u=np.array(columns[1], float).reshape(n, 3),
            edge_v=np.array(columns[2], float).reshape(n, 3),
            is_triangle=np.array(columns[3], bool),
            material=np.array(columns[4], np.int32),
            object=np.zeros(n, np.int32),
            surface=np.arange(n, dtype=np.int32),
            solid=np.array(columns[5], np.int32),
        )
        lamps = self.emitters
        emitters = Emitters(
            patch=np.array([e[0] for e in lamps], np.int32),
            position=np.array([e[1] for e in lamps], float).reshape(len(lamps), 3),
            luminaire=np.array([e[2] for e in lamps], np.int32),
        )
        return Scene(
            "test", None, bands_of(self.bands), patches, tuple(self.materials), tuple(self.luminaires), emitters,
            tuple(self.sensors), (), ("object",), self.sky,
        )  # fmt: skip

    def _spectrum(self, value):
        return np.broadcast_to(np.asarray(value, float), (self.bands,)).copy()


def cube(reflectance=0.5, bands=1, side=1.0) -> SceneBuilder:
    """Closed cube from the origin, one material a face when `reflectance` is a list of six."""
    b = SceneBuilder(bands)
    per_face = reflectance if isinstance(reflectance, list) else [reflectance] * 6
    b.box((0, 0, 0), (side, side, side), [b.material(r) for r in per_face], inward=True)
    return b


def moved(scene: Scene, rotation=None, shift=(0.0, 0.0, 0.0), factor=1.0) -> Scene:
    """The scene scaled, then turned by a (3, 3) matrix, then shifted."""
    turn = np.eye(3) if rotation is None else rotation
    patches = scene.patches
    return replace(
        scene,
        patches=replace(
            patches,
            origin=factor * patches.origin @ turn.T + shift,
            edge_u=factor * patches.edge_u @ turn.T,
            edge_v=factor * patches.edge_v @ turn.T,
        ),
        emitters=replace(scene.emitters, position=factor * scene.emitters.position @ turn.T + shift),
        sensors=tuple(
            replace(s, position=factor * s.position @ turn.T + shift, normal=s.normal @ turn.T) for s in scene.sensors
        ),
    )
