"""The scene: everything the user asked about, as plain values."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import Patches
from hradiosity.model.spectrum import Bands, Spectrum


@dataclass(frozen=True)
class Material:
    """A Lambertian paint.

    reflectance : (n_bands,) hemispherical reflectance of each band, 0 … 1
    two_sided : reflects on its back as well; if not, the back is black and opaque
    measured : False when the reflectance was guessed from a colour
    """

    name: str
    reflectance: NDArray[np.float64]
    two_sided: bool = True
    measured: bool = True


@dataclass(frozen=True)
class Luminaire:
    """A kind of light: its spectrum and how it leaves.

    exitance : (n_bands,) radiant exitance of an area emitter in each band [W m⁻² per band], on each emitting side
    intensity : (n_bands,) radiant intensity of a point source in each band [W sr⁻¹ per band]
    two_sided : an area emitter shines from its back as well

    Exactly one of ``exitance`` and ``intensity`` is filled; the other is empty.
    """

    name: str
    exitance: NDArray[np.float64]
    intensity: NDArray[np.float64]
    two_sided: bool = False

    @property
    def emission(self) -> NDArray[np.float64]:
        """Exitance, or intensity of a point source."""
        return self.exitance if len(self.exitance) else self.intensity


@dataclass(frozen=True)
class Emitters:
    """Where light starts: the emitting patches and the point sources.

    patch : (n,) int32, the patch that emits, or NONE for a point source
    position : (n, 3) float64 [m], of a point source; the patch's centroid otherwise
    luminaire : (n,) int32, index into ``Scene.luminaires``
    """

    patch: NDArray[np.int32]
    position: NDArray[np.float64]
    luminaire: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.patch)


@dataclass(frozen=True)
class Sky:
    """Uniform sky over the horizontal plane (z > 0), black ground below.

    radiance : (n_bands,) [W m⁻² sr⁻¹ per band]
    """

    radiance: NDArray[np.float64]


@dataclass(frozen=True)
class Looks:
    """What each plane of a luminance sensor stands in front of; NONE for a black side, and for one that is no lamp.

    material, luminaire : (n_planes,) int32, indices into those of the scene
    sky : (n_planes,) bool, whether nothing but sky is there
    """

    material: NDArray[np.int32]
    luminaire: NDArray[np.int32]
    sky: NDArray[np.bool_]


@dataclass(frozen=True)
class Parts:
    """How readings are made of planes that are traced: `count` successive ones belong to each.

    kind : "cylindrical", "semi-cylindrical", "spherical", "field of view": sums; "luminance": the mean radiance of the
        places that the planes stand in front of
    place, direction : (n, 3) float64 [m], [1], of the readings
    response : (n_planes, 12) float32, how directions weigh, see `hradiosity.model.sensor_kinds`; None: all alike
    looks : of luminance sensors
    """

    kind: str
    count: int
    place: NDArray[np.float64]
    direction: NDArray[np.float64]
    response: NDArray[np.float32] | None = None
    looks: Looks | None = None


@dataclass(frozen=True)
class Sensor:
    """A named list of places where the light is read.

    position : (n, 3) float64 [m], of the planes on which light is traced
    normal : (n, 3) float64, unit
    grid : (rows, columns) when the readings form a grid, row-major; None otherwise
    parts : how readings are made of these planes; None: each plane is a reading
    glare : the readings are observers whose UGR is wanted
    """

    name: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    grid: tuple[int, int] | None = None
    parts: Parts | None = None
    glare: bool = False

    @property
    def kind(self) -> str:
        """What its readings are: "plane", or as in `Parts`."""
        return "plane" if self.parts is None else self.parts.kind

    @property
    def n_readings(self) -> int:
        """Number of readings."""
        return len(self.place)

    @property
    def place(self) -> NDArray[np.float64]:
        """(n_readings, 3) [m]."""
        return self.position if self.parts is None else self.parts.place

    @property
    def direction(self) -> NDArray[np.float64]:
        """(n_readings, 3) unit: normal of a plane, axis of a cylinder, line of sight."""
        return self.normal if self.parts is None else self.parts.direction


@dataclass(frozen=True)
class Action:
    """An action spectrum that readings are weighted by; zero where it isn't tabulated, without lines."""

    name: str
    spectrum: Spectrum


@dataclass(frozen=True)
class View:
    """A camera.

    position, direction, up : (3,) float64; position in metres, the others unit vectors
    field_of_view : horizontal angle [degrees]
    """

    name: str
    position: NDArray[np.float64]
    direction: NDArray[np.float64]
    up: NDArray[np.float64]
    field_of_view: float = 60.0
    width: int = 640
    height: int = 480


@dataclass(frozen=True)
class Note:
    """Something that was mended or assumed while reading, or a warning; it goes into ``run.json``.

    kind : "warning" when a number may be affected, "info" otherwise
    """

    kind: Literal["warning", "info"]
    place: str
    message: str

    def __str__(self) -> str:
        return f"{self.place}: {self.message}"


@dataclass(frozen=True)
class Variant:
    """The same scene in other paints and lights; see `hradiosity.model.variants`.

    materials, luminaires : all of them in the scene's order, each in place of the scene's
    """

    name: str
    materials: tuple[Material, ...]
    luminaires: tuple[Luminaire, ...]


@dataclass(frozen=True)
class Scene:
    """A checked, immutable description; holds no device data.

    objects : names of the objects that ``patches.object`` counts
    variants : solved together with the scene itself, for the differences
    actions : action spectra that readings are weighted by, beside those of the eye
    """

    name: str
    path: Path | None
    bands: Bands
    patches: Patches
    materials: tuple[Material, ...]
    luminaires: tuple[Luminaire, ...]
    emitters: Emitters
    sensors: tuple[Sensor, ...]
    views: tuple[View, ...]
    objects: tuple[str, ...]
    sky: Sky | None = None
    notes: tuple[Note, ...] = field(default=())
    variants: tuple[Variant, ...] = field(default=())
    actions: tuple[Action, ...] = field(default=())

    @property
    def reflectance(self) -> NDArray[np.float64]:
        """(n_materials, n_bands) reflectance."""
        return np.array([m.reflectance for m in self.materials]).reshape(len(self.materials), len(self.bands))
