"""What readings see, by one ray to each part of their hemispheres, and the brightness of what it meets."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.guide import SIDE
from hradiosity.readings.path_tracing import Points
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.space.hierarchy import SKY, UNLIT
from hradiosity.transport.device_scene import DeviceElements, DeviceScene


def met_rows(scene: DeviceScene, elements: DeviceElements, points: Points, seed: int) -> NDArray[np.uint32]:
    """(n_points, SIDE²) row element, or outcome, that one ray to each part of the hemisphere ends on."""
    point = np.arange(points.n)
    return met_in_blocks(scene, elements, points, point, np.zeros_like(point), across=SIDE, side=1, seed=seed)


def met_in_blocks(
    scene: DeviceScene,
    elements: DeviceElements,
    points: Points,
    point: NDArray[np.int64],
    number: NDArray[np.int64],
    *,
    across: int,
    side: int,
    seed: int,
) -> NDArray[np.uint32]:
    """What one ray to each part of some blocks ends on.

    Parameters
    ----------
    point, number : (n_blocks,) int64
        Whose hemisphere each is of, and which of side × side parts of it, by rows.
    across : int
        Parts along each edge of a block.

    Returns
    -------
    (n_blocks, across²) uint32
        Row elements, or outcomes.
    """
    device = scene.device
    if not len(point):
        return np.zeros((0, across * across), np.uint32)
    row = device.empty((len(point), across * across), np.uint32)
    device.kernel("guide", "trace_guide")(
        len(point) * across * across,
        **scene.geometry,
        **elements.cells,
        position=points.position,
        normal=points.normal,
        patch_solid=scene.solid,
        block_point=device.upload(point, np.uint32),
        block_number=device.upload(number, np.uint32),
        met_row=row,
        across=across,
        side=side,
        seed=seed,
        scale=scene.scale,
    )
    met: NDArray[np.uint32] = device.fetch(row)
    return met


@dataclass(frozen=True)
class PilotLight:
    """Brightness that rays from points bring.

    bright : (n_rows + 2,) float64, see `brightness_met`
    known : (n, n_places) int64, parts of each hemisphere that lead to places that pass much light, −1 for none
    """

    scene: DeviceScene
    elements: DeviceElements
    points: Points
    bright: NDArray[np.float64]
    seed: int
    known: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 0), np.int64))

    def known_parts(self) -> NDArray[np.int64]:
        """Places of what is known among the values of `everywhere`."""
        point, place = np.nonzero(self.known >= 0)
        return np.unique(point * SIDE**2 + self.known[point, place])

    def everywhere(self) -> NDArray[np.float64]:
        """(n_points, SIDE, SIDE) in each part of the hemisphere."""
        found = met_rows(self.scene, self.elements, self.points, self.seed)
        return self._brightness(found).reshape(-1, SIDE, SIDE)

    def in_blocks(
        self, point: NDArray[np.int64], number: NDArray[np.int64], across: int, side: int, step: int
    ) -> NDArray[np.float64]:
        """(n_blocks, across, across), see `met_in_blocks`; each `step` has random numbers of its own."""
        seed = (self.seed + 0x9E3779B9 * (step + 1)) & 0xFFFFFFFF
        found = met_in_blocks(
            self.scene, self.elements, self.points, point, number, across=across, side=side, seed=seed
        )
        return self._brightness(found).reshape(len(point), across, across)

    def _brightness(self, found: NDArray[np.uint32]) -> NDArray[np.float64]:
        n_rows = len(self.bright) - 2
        place = np.where(found < UNLIT, found, np.where(found == SKY, n_rows + 1, n_rows)).astype(np.int64)
        brightness: NDArray[np.float64] = self.bright[place]
        return brightness


def brightness_met(scene: DeviceScene, elements: DeviceElements, light: SurfaceLight) -> NDArray[np.float64]:
    """(n_rows + 2,) brightness of what each row element reflects, of what has no light, of the sky."""
    device = scene.device
    weight = device.fetch(light.weight).astype(np.float64)
    of_rows = device.fetch(light.reflected) @ weight if len(elements.elements) else np.zeros(0)
    return np.append(of_rows, [0.0, device.fetch(light.sky) @ weight])
